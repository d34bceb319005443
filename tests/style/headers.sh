#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Every header compiles alone, as C17 and, where it says extern "C", as C++17, and has the guard that its path
# makes: headers.sh ROOT CC CXX [HEADER...]
self=$(cd "$(dirname "$0")" && pwd)/headers.sh
cd "$1" || exit 2
cc=$2
cxx=$3
shift 3
bad=0

if [ $# = 0 ]; then # all of them, several at a time
    tools/list-files '^(base|capture|calib|render|pose|fit|cli)/.*\.h$' |
        xargs -r -n 4 -P "$(nproc)" sh "$self" . "$cc" "$cxx"
    exit
fi

# alone COMPILER LANGUAGE STANDARD HEADER
alone() {
    printf '#include "%s"\n' "$4" |
        "$1" -x "$2" -std="$3" -D_POSIX_C_SOURCE=200809L -Wall -Wextra -Wpedantic -Werror -fopenmp-simd -I . -fsyntax-only - || {
        echo "$4 does not compile alone with $1 -std=$3"
        bad=1
    }
}

for header; do
    alone "$cc" c c17 "$header"
    if grep -q 'extern "C"' "$header"; then
        alone "$cxx" c++ c++17 "$header"
    fi
    guard=SHEEN_$(echo "$header" | tr '[:lower:]/.' '[:upper:]__')
    grep -q "^#define $guard\$" "$header" || {
        echo "$header: its include guard should be $guard"
        bad=1
    }
done
exit $bad

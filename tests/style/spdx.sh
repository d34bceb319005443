#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Every source and script names its licence in its first line, after #! where there is one: spdx.sh ROOT
cd "$1" || exit 2
bad=0
for file in $(tools/list-files | grep -vE '^tests/(data|fuzz/corpus)/'); do
    case $file in
    *.c | *.h | *.cc | *.sh | *.py | *.cmake | *.ts | *.js | *.css | *.scd | */CMakeLists.txt | CMakeLists.txt) ;;
    Makefile | .clang-format | .clang-tidy | *.rules) ;;
    *) head -c 2 "$file" | grep -q '^#!' || continue ;;
    esac
    awk 'NR == 1 && /^#!/ { next } { print; exit }' "$file" | grep -q 'SPDX-License-Identifier: Apache-2\.0' || {
        echo "$file: no SPDX-License-Identifier: Apache-2.0 in its first line"
        bad=1
    }
done
exit $bad

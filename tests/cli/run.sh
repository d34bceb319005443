#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Runs a transcript and compares what is printed: run.sh SHEEN MAKE_INPUT x.cmd
#
# x.cmd is a list of shell commands, one a line, run in an empty folder with `sheen` and `make_input` in reach.
# Lines beginning with "@ " prepare something: they must succeed and are not shown. x.out is what the others print
# (stdout, then stderr as it comes), each after "$ <command>", with "exit N" where a command does not exit with 0.
# UPDATE=1 writes x.out anew.
sheen=$1 make_input=$2 cmd=$3
expected=${cmd%.cmd}.out
cmd=$(cd "$(dirname "$cmd")" && pwd)/$(basename "$cmd")
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
mkdir "$scratch/bin" "$scratch/work"
ln -s "$sheen" "$scratch/bin/sheen"
ln -s "$make_input" "$scratch/bin/make_input"
PATH=$scratch/bin:$PATH
export PATH
cd "$scratch/work" || exit 2

while IFS= read -r line; do
    case $line in
    '' | '#'*) continue ;;
    '@ '*)
        (eval "${line#@ }") >../prepared 2>&1 </dev/null || {
            echo "cannot prepare: $line"
            cat ../prepared
            exit 1
        }
        continue
        ;;
    esac
    printf '$ %s\n' "$line"
    (eval "$line") >../printed 2>&1 </dev/null
    code=$?
    grep -vE '^[a-z ]+: [0-9]+( of [0-9]+)?$' ../printed # progress, which depends on the clock
    [ $code = 0 ] || echo "exit $code"
done <"$cmd" >../got || {
    cat ../got
    exit 1
}

cd "$OLDPWD" || exit 2
if [ "$UPDATE" = 1 ]; then
    cp "$scratch/got" "$expected"
    exit 0
fi
diff -u "$expected" "$scratch/got"

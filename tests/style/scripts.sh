#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# All our shell scripts can be executed and satisfy shellcheck: scripts.sh ROOT
cd "$1" || exit 2
command -v shellcheck >/dev/null || {
    echo "shellcheck is not installed"
    exit 77
}
scripts=$(tools/list-files | grep -vE '^tests/(data|fuzz/corpus)/' |
    xargs -r awk 'FNR == 1 && /^#!.*[\/ ](ba)?sh/ { print FILENAME } { nextfile }')
bad=0
for script in $scripts; do
    case $script in
    *.sh) ;;
    *)
        [ -x "$script" ] || {
            echo "$script: cannot be executed"
            bad=1
        }
        ;;
    esac
done
# shellcheck disable=SC2086 # a list of files
shellcheck --external-sources $scripts || bad=1
exit $bad

#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Plain text everywhere: no tabs (but in Makefiles), no trailing blanks, a final newline, no marks of
# unfinished work, no names of folders of the machine that something was written on: text.sh ROOT
cd "$1" || exit 2
bad=0
# Recorded data and expected output are what they are.
files=$(tools/list-files | grep -vE '^(tests/data/|tests/fuzz/corpus/|LICENSE$)' | xargs -r grep -lI '')

# refuse WHY REGEX [FILES_TO_LEAVE_OUT]
refuse() {
    if echo "$files" | grep -vE "${3:-^$}" | xargs -r grep -nHE "$2"; then
        echo "^ $1"
        bad=1
    fi
}

tab=$(printf '\t')
refuse 'a tab' "$tab" '(^|/)(Makefile|\.gitmodules)$|\.(out|scd|tsv)$'
refuse 'blanks at the end of a line' '[[:blank:]]+$' '\.(out|md|tsv)$'
refuse 'unfinished' '\b(TO''DO|FIX''ME|XX''X|HA''CK)\b'
refuse 'a path of one machine' '(^|[^A-Za-z0-9_.])/(wo''rk|ho''me|ro''ot|Us''ers|tmp/w)/'

for file in $files; do
    if [ -s "$file" ] && [ -n "$(tail -c 1 "$file")" ]; then
        echo "$file: no newline at its end"
        bad=1
    fi
done
exit $bad

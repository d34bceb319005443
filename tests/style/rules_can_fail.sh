#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Each rule's script refuses a repository that breaks that rule, and lets a clean one pass:
# rules_can_fail.sh ROOT
here=$(cd "$(dirname "$0")" && pwd)
root=$1
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch" || exit 2
bad=0

# A repository of two small files that breaks no rule.
clean() {
    rm -rf "${scratch:?}"/*
    mkdir base fit render tools
    cp "$root/tools/list-files" "$root/tools/format" tools/
    cp "$root/.clang-format" .
    printf '// SPDX-License-Identifier: Apache-2.0\n#ifndef SHEEN_BASE_A_H\n#define SHEEN_BASE_A_H\nint sheen_a(void);\n#endif\n' >base/a.h
    printf '// SPDX-License-Identifier: Apache-2.0\n#include "base/a.h"\n\nint sheen_a(void)\n{\n    return 1;\n}\n' >base/a.c
    cp base/a.c fit/b.c
}

# check SCRIPT pass|fail WHAT [ARGUMENTS]
check() {
    script=$1 want=$2 what=$3
    shift 3
    sh "$here/$script" "$scratch" "$@" >log 2>&1
    code=$?
    [ $code != 77 ] || return 0 # its tool is not here
    case $want$code in
    pass0 | fail1 | fail123) ;; # 123 is xargs' word for a failure
    *)
        echo "$script: should $want on $what, but exits with $code:"
        cat log
        bad=1
        ;;
    esac
}

line() {
    printf '%s\n' "$2" >>"$1"
}

archive() {
    rm -f libsheen_fit.a
    printf '%s\n' "$1" | cc -O1 -x c -c -o t.o - && ar rc libsheen_fit.a t.o
}

clean
for script in layers.sh doors.sh functions.sh text.sh spdx.sh format.sh scripts.sh; do
    check $script pass "a clean repository"
done
check headers.sh pass "a clean repository" cc c++

line base/a.c '#include "fit/b.h"'
check layers.sh fail "base including fit"
clean
line fit/b.c '#include "pose/p.h"'
check layers.sh fail "a sibling's header"
clean
line fit/b.c '#include "jansson.h"'
check layers.sh fail "a quoted header of no folder"

clean
line base/a.c '#include <png.h>'
check doors.sh pass "one door"
line fit/b.c '#include <png.h>'
check doors.sh fail "two doors to one library"
clean
line base/a.h '#include <mrcal/mrcal.h>'
check doors.sh fail "a library's header in a header"

clean
printf '#ifndef SHEEN_BASE_A_H\n#define SHEEN_BASE_A_H\nsize_t sheen_a(void);\n#endif\n' >base/a.h
check headers.sh fail "a header that needs another" cc c++
clean
sed -i s/SHEEN_BASE_A_H/SHEEN_A_H/ base/a.h
check headers.sh fail "a guard of another name" cc c++

clean
{ echo 'int sheen_long(void)' && echo '{' && seq -f '    // %g' 78 && echo '}'; } >>base/a.c
check functions.sh pass "a function of 80 lines"
sed -i 's|^    // 7$|&\n    // and one more|' base/a.c
check functions.sh fail "a function of 81 lines"

clean
line base/a.c '// TO''DO: later'
check text.sh fail "unfinished work"
clean
line base/a.c "// see /ho""me/someone/notes"
check text.sh fail "a machine's path"
clean
line base/a.c 'int sheen_x; '
check text.sh fail "a blank at the end of a line"
clean
printf 'int sheen_x;' >>base/a.c
check text.sh fail "a last line without newline"

clean
sed -i 1d fit/b.c
check spdx.sh fail "a source without its licence line"
clean
printf '#!/bin/sh\necho\n' >tools/x
check spdx.sh fail "a script without its licence line"
check scripts.sh fail "a script that cannot be executed"
chmod +x tools/x
line tools/x "rm \$1"
check scripts.sh fail "a word that splits"

clean
mkdir udev
line udev/60-a.rules 'SUBSYSTEM=="usb", TAG+="uaccess", MODE="0660"'
check udev.sh pass "a rule"
line udev/60-a.rules 'SUBSYSTEM=="usb", MODE="0666"'
check udev.sh fail "a node that everybody may write"
clean
mkdir udev
line udev/60-a.rules 'SUBSYSTEM="usb" TAG+="uaccess"'
check udev.sh fail "a comma that is missing"
clean
mkdir udev
line udev/99-a.rules 'SUBSYSTEM=="usb", TAG+="uaccess"'
check udev.sh fail "rules that come too late"

clean
line base/a.c 'int  sheen_x;'
check format.sh fail "two blanks where one belongs"

archive 'static const int t[] = {1, 2}; int sheen_t(int i); int sheen_t(int i) { return t[i]; }'
check symbols.sh pass "a clean archive" libsheen_fit.a
archive 'int other_t(void); int other_t(void) { return 1; }'
check symbols.sh fail "a foreign name" libsheen_fit.a
archive '#include <stdio.h>
void sheen_t(void); void sheen_t(void) { printf("%d\n", getchar()); }'
check symbols.sh fail "printing" libsheen_fit.a
archive '#include <stdlib.h>
char *sheen_t(void); char *sheen_t(void) { return getenv("A"); }'
check symbols.sh fail "reading the environment" libsheen_fit.a
archive 'int sheen_t(void); int sheen_t(void) { static int n; return n++; }'
check symbols.sh fail "a variable that stays" libsheen_fit.a
exit $bad

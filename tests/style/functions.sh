#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# No function is longer than 80 lines, its braces included: functions.sh ROOT
# In our format a function's braces, and only those, stand alone in the first column. (clang-tidy's
# function-size checks the same, and statements and nesting, more slowly.)
cd "$1" || exit 2
tools/list-files '\.(c|cc)$' | xargs -r awk '
    FNR == 1 { start = 0 }
    /^(\{|try \{)$/ { start = FNR }
    /^\}/ && start {
        if (FNR - start + 1 > 80) {
            print FILENAME ":" start ": a function of " FNR - start + 1 " lines"
            bad = 1
        }
        start = 0
    }
    END { exit bad }'

#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# All sources are as clang-format 14 writes them: format.sh ROOT
cd "$1" || exit 2
command -v clang-format-14 >/dev/null || {
    echo "clang-format 14 is not installed"
    exit 77
}
tools/format --check 2>&1 | grep -E 'error:' | sort -u -t : -k 1,1 | sed 's/$/ (run tools\/format)/'
tools/format --check >/dev/null 2>&1

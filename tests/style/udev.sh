#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The udev rules say what they are meant to, line by line (udevadm of Debian 12 cannot check them): udev.sh ROOT
# Every line is a list of KEY OP "VALUE" with known keys; nothing is made writable for everybody; a tag that comes too
# late (a file after 73-) would be no access.
cd "$1" || exit 2
awk '
    FNR == 1 && FILENAME !~ /\/[0-6][0-9]-[^\/]*\.rules$/ {
        print FILENAME ": must be read before 70-uaccess.rules"
        bad = 1
    }
    /^#/ || /^$/ { next }
    {
        rest = $0
        while (rest != "") {
            if (!match(rest, /^(ACTION|SUBSYSTEMS?|KERNELS?|DRIVERS?|ATTRS?\{[A-Za-z]+\}|ENV\{[A-Z_]+\}|TAGS?|GROUP|MODE|SYMLINK|GOTO|LABEL|IMPORT\{(builtin|parent)\})(==|!=|=|\+=|:=)"[^"]*"(, |$)/)) {
                print FILENAME ":" FNR ": not understood: " rest
                bad = 1
                break
            }
            part = substr(rest, 1, RLENGTH)
            rest = substr(rest, RLENGTH + 1)
            if (part ~ /^MODE="[0-7]*[2367]"/) {
                print FILENAME ":" FNR ": a node that everybody may write"
                bad = 1
            }
            if (part ~ /^GOTO/) { split(part, word, "\""); jump[word[2]] = FNR }
            if (part ~ /^LABEL/) { split(part, word, "\""); label[word[2]] = FNR }
        }
    }
    END {
        for (name in jump)
            if (!(label[name] > jump[name])) {
                print "GOTO " name " leads nowhere"
                bad = 1
            }
        exit bad
    }' udev/*.rules

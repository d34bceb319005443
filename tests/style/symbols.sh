#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# What our libraries offer, use and keep: symbols.sh ROOT ARCHIVE...
#   - every global symbol begins with sheen_
#   - below cli nothing prints to the terminal, exits, or reads the environment
#   - below cli there is no variable outside functions' frames that could change (const tables are fine)
cd "$1" || exit 2
shift
bad=0

# Catching the chatter of mrcal and OpenCV turns the process's one stderr aside, under a lock: this object may
# name the stream and keep the lock.
quiet=quiet.c.o
# Starting ffmpeg hands the environment on to it, unread.
starts_ffmpeg=film.c.o

for archive in "$@"; do
    name=$(basename "$archive")
    if nm -A -g --defined-only "$archive" | awk '$(NF - 1) ~ /^[TDBRCGS]$/ && $NF !~ /^sheen_/ { print; n++ } END { exit !n }'; then
        echo "^ $name: a global symbol must begin with sheen_"
        bad=1
    fi
    [ "$name" != libsheen_cli.a ] || continue
    if nm -A -u "$archive" | grep -vE "$quiet: .* (stderr|stdout)\$|$starts_ffmpeg: .* environ\$" |
        grep -v 'mesh_foreign_assimp.c.o: *U _exit' | # ends the reader's own process, which it started
        grep -E ' (_?exit|_Exit|quick_exit|abort|(__)?v?printf(_chk)?|puts|putchar|perror|psignal|stdout|stderr|(secure_)?getenv|setenv|putenv|environ|_ZSt4c(out|err|log))(@.*)?$'; then
        echo "^ $name: a library prints, exits or reads the environment"
        bad=1
    fi
    if objdump -t "$archive" | awk -v quiet="$quiet:" '
        /file format/ { object = $1 }
        # "address flags section size name": O is an object, .data.rel.ro is constant once loaded; the names left
        # out are what the C++ compiler and <iostream> put into every object
        / O \.(data|bss|tdata|tbss)/ && !/ O \.data\.rel\.ro/ && object != quiet && !/ (DW\.ref\.|_ZStL8__ioinit$)/ {
            print object " " $NF
            n++
        }
        END { exit !n }'; then
        echo "^ $name: a variable that outlives its function"
        bad=1
    fi
done
exit $bad

#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# One door per library: each third-party header set is included by one source file (mrcal and Embree: two),
# and by no header, so that no foreign type leaves its door: doors.sh ROOT
#
# Third-party is every <header> that is not C's, C++'s, POSIX's or the kernel's.
cd "$1" || exit 2

includes=$(grep -rHoE '^[[:space:]]*#[[:space:]]*include[[:space:]]*<[^>]+>' \
    base capture calib render pose fit cli 2>/dev/null | sed -E 's/:[^<]*<([^>]+)>/ \1/')

echo "$includes" | awk '
    BEGIN {
        n = split("assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal " \
                  "stdalign stdarg stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string tgmath " \
                  "threads time uchar wchar wctype " \
                  "dirent dlfcn fcntl ftw getopt glob libgen netdb poll pthread pwd regex sched semaphore " \
                  "spawn strings termios unistd utime", names, " ")
        for (i = 1; i <= n; i++)
            system_header[names[i] ".h"] = 1
        split("mrcal 2 embree3 2", two, " ")
        for (i = 1; i in two; i += 2)
            doors[two[i]] = two[i + 1]
        # names under which one library is included
        library["jerror.h"] = "jpeglib.h"
        library["xtiffio.h"] = library["tiff.h"] = "tiffio.h"
        library["pngconf.h"] = "png.h"
        library["libavcodec"] = library["libavformat"] = library["libavutil"] = library["libswscale"] = "libav"
    }
    NF < 2 || $2 in system_header { next }
    $2 ~ /^(sys|linux|arpa|netinet|net|asm)\// { next }
    $2 ~ /^[a-z_]+$/ { next } # C++: <vector>
    {
        name = $2
        sub(/\/.*/, "", name)
        if (name in library)
            name = library[name]
        if ($1 ~ /\.h$/) {
            print $1 " is a header and must not include <" $2 ">"
            bad = 1
        }
        if (!((name, $1) in seen)) {
            seen[name, $1] = 1
            count[name]++
            files[name] = files[name] " " $1
        }
    }
    END {
        for (name in count)
            if (count[name] > (name in doors ? doors[name] : 1)) {
                print "library " name " has " count[name] " doors:" files[name]
                bad = 1
            }
        exit bad
    }'

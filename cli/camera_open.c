// SPDX-License-Identifier: Apache-2.0
// camera_open.c - see camera_open.h.
#include "cli/camera_open.h"

#include "cli/camera_memory.h"

sheen_status sheen_cli_camera_open(sheen_cli *cli, sheen_source **src, const char *uri, bool keep,
                                   sheen_err *err)
{
    char known[SHEEN_PATH_MAX], noted[240];
    const sheen_status s = sheen_cli_camera_uri(known, noted, uri, keep, err);
    if (s)
        return s;
    if (noted[0])
        sheen_cli_say(cli, "%s", noted);
    return sheen_source_open(src, known, err);
}

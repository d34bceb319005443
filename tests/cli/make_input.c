// SPDX-License-Identifier: Apache-2.0
// make_input.c - a program that writes small input files for the transcripts: make_input KIND FILE ARGUMENTS.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/capture/fixtures.h"

static int number(char **argv, int argc, int i, int fallback)
{
    return i < argc ? (int)strtol(argv[i], NULL, 10) : fallback;
}

//     picture FILE WIDTH HEIGHT SEED      flat FILE WIDTH HEIGHT      mask FILE WIDTH HEIGHT
//     camera FILE WIDTH HEIGHT            poses FILE WIDTH HEIGHT NAME...
//     shiny DIR WIDTH HEIGHT NAME...
//     board FILE                          mesh FILE [OFFSET_MM]
int main(int argc, char **argv)
{
    if (argc < 3)
        return 2;
    const char *kind = argv[1], *path = argv[2];
    const int width_px = number(argv, argc, 3, 64), height_px = number(argv, argc, 4, 48);
    if (!strcmp(kind, "picture") || !strcmp(kind, "flat"))
        fixture_picture(path, width_px, height_px, (unsigned)number(argv, argc, 5, 1), !strcmp(kind, "flat"));
    else if (!strcmp(kind, "mask"))
        fixture_mask(path, width_px, height_px);
    else if (!strcmp(kind, "camera"))
        fixture_camera(path, width_px, height_px);
    else if (!strcmp(kind, "poses"))
        fixture_poses(path, width_px, height_px, (const char *const *)(argv + 5), argc - 5);
    else if (!strcmp(kind, "shiny"))
        fixture_shiny(path, width_px, height_px, (const char *const *)(argv + 5), argc - 5);
    else if (!strcmp(kind, "board"))
        fixture_board(path);
    else if (!strcmp(kind, "mesh"))
        fixture_mesh(path, number(argv, argc, 3, 0) * 1e-3);
    else
        return 2;
    return 0;
}

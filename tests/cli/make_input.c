// SPDX-License-Identifier: Apache-2.0
// make_input.c - a program that writes small input files for the transcripts: make_input KIND FILE ARGUMENTS.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/image_file.h"
#include "tests/capture/fixtures.h"

static int number(char **argv, int argc, int i, int fallback)
{
    return i < argc ? (int)strtol(argv[i], NULL, 10) : fallback;
}

// A picture as it looks when the camera moves by length_px along a row during the exposure, or, rolled, when it swings by
// so much to and fro while the rows are read one after the other (a paper that is not flat looks alike).
static int moved(const char *path, const char *from_path, int length_px, bool rolled)
{
    sheen_err err;
    sheen_raster from, to;
    if (sheen_raster_load(&from, from_path, &err))
        return fprintf(stderr, "%s\n", err.msg), 1;
    const int width_px = from.width_px, n = from.n_channels;
    if (from.bits != 8 || sheen_raster_init(&to, width_px, from.height_px, n, 8, &err))
        return 1;
    const uint8_t *in = from.data;
    uint8_t *out = to.data;
    for (int i = 0; i < width_px * from.height_px * n; i++) {
        const int c = i % n, x = i / n % width_px, y = i / n / width_px;
        const int first = rolled ? (int)lrint(length_px * sin(0.02 * y)) : -length_px / 2;
        const int count = rolled ? 1 : length_px;
        int sum = 0;
        for (int k = 0; k < count; k++) {
            const int at = x + first + k;
            sum += in[(y * width_px + (at < 0 ? 0 : at >= width_px ? width_px - 1 : at)) * n + c];
        }
        out[i] = (uint8_t)(sum / count);
    }
    const sheen_status s = sheen_png_write(path, &to, &err);
    sheen_raster_release(&from);
    sheen_raster_release(&to);
    return s != SHEEN_OK;
}

// A picture as a float file in which a pixel in 97 is no number, infinite or absurd; or one of which nothing is left.
static int floats(const char *path, const char *from_path, int black)
{
    const float wrong[3] = {NAN, INFINITY, 1e30f};
    sheen_err err;
    sheen_raster from;
    sheen_image light;
    if (sheen_raster_load(&from, from_path, &err) ||
        sheen_image_from_raster(&light, &from, SHEEN_TRANSFER_SRGB, &err))
        return fprintf(stderr, "%s\n", err.msg), 1;
    const size_t n = (size_t)from.width_px * (size_t)from.height_px;
    for (size_t i = 0; i < 3 * n; i++)
        light.data[i] = black ? 0 : i % 97 ? light.data[i] : wrong[i / 97 % 3];
    const sheen_status s = black ? sheen_png_write_srgb(path, &light, &err)
                                 : sheen_exr_write(path, &light, NULL, false, &err);
    sheen_raster_release(&from);
    sheen_image_release(&light);
    return s != SHEEN_OK;
}

//     hot FILE.exr FROM                   black FILE.png FROM
//     blurred FILE FROM LENGTH_PX         rolled FILE FROM LENGTH_PX
//     picture FILE WIDTH HEIGHT SEED      flat FILE WIDTH HEIGHT      mask FILE WIDTH HEIGHT
//     camera FILE WIDTH HEIGHT            poses FILE WIDTH HEIGHT NAME...
//     shiny DIR WIDTH HEIGHT NAME...
//     board FILE                          mesh FILE [OFFSET_MM]
//     figure FILE UNITS_PER_M             figure-marks FILE WIDTH HEIGHT UNITS_PER_M NAME...
//     figure-views DIR WIDTH HEIGHT NAME...    figure-masks, ball-masks DIR WIDTH HEIGHT NAME...
int main(int argc, char **argv)
{
    if (argc < 3)
        return 2;
    const char *kind = argv[1], *path = argv[2];
    if (!strcmp(kind, "blurred") || !strcmp(kind, "rolled"))
        return argc < 5 ? 2 : moved(path, argv[3], number(argv, argc, 4, 1), !strcmp(kind, "rolled"));
    if (!strcmp(kind, "hot") || !strcmp(kind, "black"))
        return argc < 4 ? 2 : floats(path, argv[3], !strcmp(kind, "black"));
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
    else if (!strcmp(kind, "figure"))
        fixture_figure(path, number(argv, argc, 3, 1));
    else if (!strcmp(kind, "figure-views") || !strcmp(kind, "figure-masks") || !strcmp(kind, "ball-masks"))
        fixture_figure_views(path, width_px, height_px, (const char *const *)(argv + 5), argc - 5,
                             strcmp(kind, "figure-views") != 0, strcmp(kind, "ball-masks") ? 4 : 1);
    else if (!strcmp(kind, "figure-marks"))
        fixture_figure_marks(path, width_px, height_px, (const char *const *)(argv + 6), argc - 6,
                             number(argv, argc, 5, 1));
    else
        return 2;
    return 0;
}

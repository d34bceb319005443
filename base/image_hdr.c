// SPDX-License-Identifier: Apache-2.0
// image_hdr.c - Radiance pictures: three mantissas of 8 bits and a common exponent a pixel (Ward 1991), rows coded by runs.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/image_file.h"

// Rows outside of these widths are stored plainly.
enum { LEAST_RUN_WIDTH = 8, MOST_RUN_WIDTH = 32767, LONGEST = 127, LEAST_RUN = 4 };

static void rgbe_of(uint8_t rgbe[4], const float rgb[3])
{
    int exponent;
    float most = 0;
    for (int c = 0; c < 3; c++)
        if (rgb[c] > most)
            most = rgb[c];
    memset(rgbe, 0, 4);
    if (!(most > 1e-32f) || !isfinite(most))
        return;
    const float scale = frexpf(most, &exponent) * 256.0f / most;
    for (int c = 0; c < 3; c++)
        rgbe[c] = rgb[c] > 0 ? (uint8_t)(rgb[c] * scale) : 0;
    rgbe[3] = (uint8_t)(exponent + 128);
}

static size_t run_at(const uint8_t *from, size_t n, size_t i)
{
    size_t run = 1;
    while (i + run < n && run < LONGEST && from[i + run] == from[i])
        run++;
    return run;
}

// One channel of a row: runs as (128 + length, value), the rest as (length, values). Returns the end.
static uint8_t *put_runs(uint8_t *to, const uint8_t *from, size_t n)
{
    for (size_t i = 0; i < n;) {
        const size_t run = run_at(from, n, i);
        if (run >= LEAST_RUN) {
            *to++ = (uint8_t)(128 + run);
            *to++ = from[i];
            i += run;
            continue;
        }
        size_t plain = 0;
        while (i + plain < n && plain < LONGEST && run_at(from, n, i + plain) < LEAST_RUN)
            plain++;
        *to++ = (uint8_t)plain;
        memcpy(to, from + i, plain);
        to += plain;
        i += plain;
    }
    return to;
}

// planes: [4][width], to: room for 4 + 8 width bytes.
static uint8_t *put_row(uint8_t *to, uint8_t *planes, const float *rgb, size_t width)
{
    const int runs = width >= LEAST_RUN_WIDTH && width <= MOST_RUN_WIDTH;
    for (size_t x = 0; x < width; x++) {
        uint8_t rgbe[4];
        rgbe_of(rgbe, rgb + 3 * x);
        for (size_t c = 0; c < 4; c++)
            planes[runs ? c * width + x : 4 * x + c] = rgbe[c];
    }
    if (!runs) {
        memcpy(to, planes, 4 * width);
        return to + 4 * width;
    }
    *to++ = 2;
    *to++ = 2;
    *to++ = (uint8_t)(width >> 8);
    *to++ = (uint8_t)width;
    for (size_t c = 0; c < 4; c++)
        to = put_runs(to, planes + c * width, width);
    return to;
}

sheen_status sheen_hdr_write(const char *path, const sheen_image *img, sheen_err *err)
{
    if (!img->data || img->n_channels != 3)
        return sheen_fail(err, SHEEN_EARG, "cannot write '%s': a Radiance picture has 3 channels", path);
    const size_t width = (size_t)img->width_px, height = (size_t)img->height_px;
    const size_t room_bytes = 128 + height * (4 + 8 * width);
    uint8_t *room = malloc(room_bytes), *planes = malloc(4 * width), *to = room;
    sheen_status s = SHEEN_OK;
    if (!room || !planes) {
        s = sheen_fail_memory(err, (double)room_bytes, path);
    } else {
        to += snprintf((char *)to, 128, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %zu +X %zu\n", height,
                       width);
        for (size_t y = 0; y < height; y++)
            to = put_row(to, planes, img->data + 3 * width * y, width);
        s = sheen_file_write(path, room, (size_t)(to - room), err);
    }
    free(room);
    free(planes);
    return s;
}

// SPDX-License-Identifier: Apache-2.0
// pixel_bayer.c - colours of a mosaic: the mean of the neighbours that have a colour, corrected by how much the pixel's
// own colour stands out of its neighbourhood (Malvar, He, Cutler 2004, fig. 2).
#include "base/pixel_parts.h"

#include <math.h>

// Where the picture ends it is mirrored about its last sample, which keeps the pattern.
static int mirror(int i, int n)
{
    if (i < 0)
        i = -i;
    if (i >= n)
        i = 2 * (n - 1) - i;
    return i < 0 ? 0 : i >= n ? n - 1 : i;
}

typedef struct window {
    float at[5][5]; // [y][x], the pixel in the middle
} window;

static window look(const uint16_t *mosaic, int width_px, int height_px, int x, int y)
{
    window w;
    for (int dy = -2; dy <= 2; dy++)
        for (int dx = -2; dx <= 2; dx++) {
            // Two apart is the same colour; a picture of two or three samples a side has to make do with one.
            const int row = mirror(y + dy, height_px), column = mirror(x + dx, width_px);
            w.at[dy + 2][dx + 2] = mosaic[(size_t)row * (size_t)width_px + (size_t)column];
        }
    return w;
}

static float green_at_colour(const window *w)
{
    const float cross = w->at[1][2] + w->at[3][2] + w->at[2][1] + w->at[2][3];
    const float far_cross = w->at[0][2] + w->at[4][2] + w->at[2][0] + w->at[2][4];
    return (4 * w->at[2][2] + 2 * cross - far_cross) / 8;
}

// At green: the colour whose samples are left and right (or, transposed, above and below).
static float colour_at_green(const window *w, bool left_right)
{
    const float diagonal = w->at[1][1] + w->at[1][3] + w->at[3][1] + w->at[3][3];
    const float across = left_right ? w->at[2][1] + w->at[2][3] : w->at[1][2] + w->at[3][2];
    const float far_along = left_right ? w->at[2][0] + w->at[2][4] : w->at[0][2] + w->at[4][2];
    const float far_over = left_right ? w->at[0][2] + w->at[4][2] : w->at[2][0] + w->at[2][4];
    return (5 * w->at[2][2] + 4 * across - diagonal - far_along + 0.5f * far_over) / 8;
}

// At red: blue, and the other way round.
static float opposite_colour(const window *w)
{
    const float diagonal = w->at[1][1] + w->at[1][3] + w->at[3][1] + w->at[3][3];
    const float far_cross = w->at[0][2] + w->at[4][2] + w->at[2][0] + w->at[2][4];
    return (6 * w->at[2][2] + 2 * diagonal - 1.5f * far_cross) / 8;
}

static uint16_t clip(float x)
{
    return x <= 0 ? 0 : x >= 65535 ? 65535 : (uint16_t)lrintf(x);
}

void sheen_bayer_develop(uint16_t *rgb, const uint16_t *mosaic, int width_px, int height_px, int red)
{
    const int red_x = red % 2, red_y = red / 2;
    for (int y = 0; y < height_px; y++)
        for (int x = 0; x < width_px; x++, rgb += 3) {
            const window w = look(mosaic, width_px, height_px, x, y);
            const bool in_red_row = y % 2 == red_y, in_red_column = x % 2 == red_x;
            if (in_red_row == in_red_column) { // red or blue
                const int own = in_red_row ? 0 : 2;
                rgb[own] = (uint16_t)w.at[2][2];
                rgb[1] = clip(green_at_colour(&w));
                rgb[2 - own] = clip(opposite_colour(&w));
            } else {
                rgb[0] = clip(colour_at_green(&w, in_red_row));
                rgb[1] = (uint16_t)w.at[2][2];
                rgb[2] = clip(colour_at_green(&w, !in_red_row));
            }
        }
}

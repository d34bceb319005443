// SPDX-License-Identifier: Apache-2.0
// image_fill.c - colours for pixels that have none, from those about them: pull-push over a pyramid of halves.
//
// A pyramid's pixel is the mean of the known ones of its four; what is not known anywhere below takes its value from the
// level above. Near a known pixel that is nearly its colour, far away a mean of many.
#include "render/charts.h"

#include <string.h>

// rgb (3 channels) and weight (0 or 1) of one level.
typedef struct level {
    sheen_image rgb, weight;
} level;

enum { MAX_LEVELS = 17 };

static sheen_status halve(level *to, const level *from, sheen_err *err)
{
    const int w = (from->rgb.width_px + 1) / 2, h = (from->rgb.height_px + 1) / 2;
    sheen_status s = sheen_image_init(&to->rgb, w, h, 3, err);
    if (!s)
        s = sheen_image_init(&to->weight, w, h, 1, err);
    for (int y = 0; !s && y < from->rgb.height_px; y++)
        for (int x = 0; x < from->rgb.width_px; x++) {
            const float weight = *sheen_image_at(&from->weight, x, y);
            const float *rgb = sheen_image_at(&from->rgb, x, y);
            float *sum = sheen_image_at(&to->rgb, x / 2, y / 2);
            *sheen_image_at(&to->weight, x / 2, y / 2) += weight;
            for (int c = 0; c < 3; c++)
                sum[c] += weight * rgb[c];
        }
    for (int i = 0; !s && i < w * h; i++)
        if (to->weight.data[i] > 0) {
            for (int c = 0; c < 3; c++)
                to->rgb.data[3 * i + c] /= to->weight.data[i];
            to->weight.data[i] = 1;
        }
    return s;
}

static void take_from_above(level *to, const level *from)
{
    for (int y = 0; y < to->rgb.height_px; y++)
        for (int x = 0; x < to->rgb.width_px; x++)
            if (!(*sheen_image_at(&to->weight, x, y) > 0))
                memcpy(sheen_image_at(&to->rgb, x, y), sheen_image_at(&from->rgb, x / 2, y / 2),
                       3 * sizeof(float));
}

sheen_status sheen_image_fill(sheen_image *img, const uint8_t *known, sheen_err *err)
{
    level levels[MAX_LEVELS] = {{.rgb = *img}};
    int n = 1;
    sheen_status s = sheen_image_init(&levels[0].weight, img->width_px, img->height_px, 1, err);
    const size_t n_px = s ? 0 : (size_t)img->width_px * (size_t)img->height_px;
    for (size_t i = 0; i < n_px; i++)
        levels[0].weight.data[i] = known[i] ? 1 : 0;
    for (; !s && n < MAX_LEVELS && (levels[n - 1].rgb.width_px > 1 || levels[n - 1].rgb.height_px > 1); n++)
        s = halve(&levels[n], &levels[n - 1], err);
    for (int i = n - 1; !s && i > 0; i--)
        take_from_above(&levels[i - 1], &levels[i]);
    for (int i = 0; i < n; i++) {
        if (i)
            sheen_image_release(&levels[i].rgb);
        sheen_image_release(&levels[i].weight);
    }
    return s;
}

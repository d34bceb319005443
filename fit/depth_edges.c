// SPDX-License-Identifier: Apache-2.0
// depth_edges.c - compares the distances that a 3x3 neighbourhood of a gbuffer shows.
#include "fit/depth_edges.h"

#include <assert.h>
#include <math.h>

bool sheen_clear_of_depth_edges(const sheen_gbuffer *g, int x_px, int y_px, float distance_m, float cosine,
                                float footprint_per_m)
{
    assert(g->samples_per_side == 1);
    const int x = x_px - g->x0_px, y = y_px - g->y0_px;
    if (x < 1 || y < 1 || x >= g->width_px - 1 || y >= g->height_px - 1)
        return false;
    const float slope = sqrtf(fmaxf(0, 1 - cosine * cosine)) / cosine;
    const float tolerance_m = footprint_per_m * distance_m * (2 + 4 * slope);
    for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++) {
            const sheen_hit *h = &g->hits[(size_t)(y + dy) * (size_t)g->width_px + (size_t)(x + dx)];
            if (h->triangle == SHEEN_NO_HIT || fabsf(h->t_m - distance_m) > tolerance_m)
                return false;
        }
    return true;
}

// SPDX-License-Identifier: Apache-2.0
// texture_resample.c - the global texture with another number of texels a triangle's edge.
//
// A new texel is the mean of the old surface about it, weighted by the hat function of its lattice point (1 there, 0
// at its six neighbours, linear between) and sampled symmetrically, so that a linear surface stays as it is. On an
// edge only the edge itself is averaged, and a corner keeps its value: two triangles that share an edge hold the same
// texels along it and so arrive at the same new ones, and no seam opens.
#include "render/texture.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

// Less seen weight than this is a rounding error of the place, not a photograph.
#define LEAST_SEEN 1e-3f

// The new lattice over the old one. Places are in steps of the old lattice.
typedef struct grid {
    const sheen_texture *old;
    int last_new; // texels_per_edge - 1
    float step;   // between new texels
    int n;        // samples are step / n apart; 1: only the place itself
} grid;

static float sample(float rgb[3], const grid *g, size_t triangle, float a, float b)
{
    const float last = (float)(g->old->texels_per_edge - 1);
    const sheen_hit hit = {.triangle = (uint32_t)triangle, .b1 = a / last, .b2 = b / last};
    return sheen_texture_sample(g->old, &hit, rgb);
}

// Offsets (k, m) of samples, in units of step / n, that a texel of this kind averages over.
static bool counts(int i, int j, int last, int k, int m)
{
    return (i > 0 || k == 0) && (j > 0 || m == 0) && (i + j < last || k + m == 0);
}

// Returns the weight of what was seen; where that is 0, rgb is what the place was filled with.
static float gather(float rgb[3], const grid *g, size_t triangle, int i, int j)
{
    float sum[3] = {0, 0, 0}, filled[3] = {0, 0, 0}, weight_sum = 0, filled_sum = 0;
    for (int m = 1 - g->n; m < g->n; m++)
        for (int k = 1 - g->n; k < g->n; k++) {
            const int distance = abs(k + m) > abs(k) ? abs(k + m) : abs(k);
            const int hexagonal = distance > abs(m) ? distance : abs(m);
            if (hexagonal >= g->n || !counts(i, j, g->last_new, k, m))
                continue;
            float here[3];
            const float seen = sample(here, g, triangle, ((float)i + (float)k / (float)g->n) * g->step,
                                      ((float)j + (float)m / (float)g->n) * g->step);
            const bool is_seen = seen >= LEAST_SEEN;
            const float weight = (is_seen ? seen : 1) * (float)(g->n - hexagonal);
            for (int c = 0; c < 3; c++)
                (is_seen ? sum : filled)[c] += weight * here[c];
            *(is_seen ? &weight_sum : &filled_sum) += weight;
        }
    for (int c = 0; c < 3; c++)
        rgb[c] = weight_sum > 0 ? sum[c] / weight_sum : filled_sum > 0 ? filled[c] / filled_sum : 0;
    return weight_sum;
}

// How many photographs saw the old texel nearest to a new one.
static uint8_t views_near(const grid *g, size_t triangle, int i, int j)
{
    const int texels = g->old->texels_per_edge, last = texels - 1;
    const int a = (int)lrintf((float)i * g->step), b = (int)lrintf((float)j * g->step);
    return g->old->n_views[triangle * sheen_texels_per_triangle(texels) +
                           sheen_texel_index(texels, a + b > last ? last - b : a, b)];
}

sheen_status sheen_texture_resample(sheen_texture *out, const sheen_texture *t, int texels_per_edge,
                                    sheen_err *err)
{
    const sheen_status s = sheen_texture_init(out, t->n_triangles, texels_per_edge, err);
    if (s)
        return s;
    grid g = {.old = t, .last_new = texels_per_edge - 1};
    g.step = (float)(t->texels_per_edge - 1) / (float)g.last_new;
    g.n = g.step > 1 ? (int)ceilf(g.step) + 1 : 1;
    size_t texel = 0;
    for (size_t triangle = 0; triangle < t->n_triangles; triangle++)
        for (int j = 0; j < texels_per_edge; j++)
            for (int i = 0; i + j < texels_per_edge; i++, texel++) {
                if (!(gather(out->rgb + 3 * texel, &g, triangle, i, j) > 0))
                    continue;
                const uint8_t views = views_near(&g, triangle, i, j);
                out->n_views[texel] = views ? views : 1;
            }
    return SHEEN_OK;
}

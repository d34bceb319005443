// SPDX-License-Identifier: Apache-2.0
// gloss.c - the mean of gloss.h; distances are taken from the nearest colour's, so that no place is too far for all.
#include "render/gloss.h"

#include <math.h>

void sheen_gloss_weights(float *weight, const sheen_gloss *g, const float root[3])
{
    float least = HUGE_VALF, sum = 0;
    for (int i = 0; i < g->n; i++) {
        float d2 = 0;
        for (int c = 0; c < 3; c++)
            d2 += (root[c] - g->root[i][c]) * (root[c] - g->root[i][c]);
        weight[i] = d2;
        least = fminf(least, d2);
    }
    for (int i = 0; i < g->n; i++) {
        weight[i] = expf(-0.5f * (weight[i] - least) / (g->width * g->width));
        sum += weight[i];
    }
    for (int i = 0; i < g->n; i++)
        weight[i] /= sum;
}

float sheen_gloss_at_root(const sheen_gloss *g, const float root[3])
{
    float weight[SHEEN_GLOSS_MAX], sum = 0;
    if (!g->n)
        return 1;
    sheen_gloss_weights(weight, g, root);
    for (int i = 0; i < g->n; i++)
        sum += weight[i] * g->share[i];
    return sum;
}

float sheen_gloss_at(const sheen_gloss *g, const float rgb[3])
{
    float root[3];
    for (int c = 0; c < 3; c++)
        root[c] = g->n ? sqrtf(fmaxf(0, rgb[c])) : 0;
    return sheen_gloss_at_root(g, root);
}

// SPDX-License-Identifier: Apache-2.0
// hemisphere.c - splats residuals to the nodes nearest to their mirror directions, and combines the views.
#include "fit/hemisphere.h"

#include <stdlib.h>

#include "base/image.h"
#include "base/parallel.h"
#include "base/vec.h"

typedef struct shots {
    const sheen_geodesic *g;
    const sheen_residual *residual;
    uint32_t *node; // of each pixel
} shots;

static void shoot(void *self, size_t begin, size_t end)
{
    const shots *s = self;
    for (size_t i = begin; i < end; i++) {
        float mirror_world[3];
        sheen_mirrorf(mirror_world, s->residual->pixels[i].n_world, s->residual->pixels[i].v_world);
        s->node[i] = sheen_geodesic_nearest(s->g, mirror_world);
    }
}

sheen_status sheen_partial_hemisphere_make(sheen_partial_hemisphere *out, const sheen_geodesic *g,
                                           const sheen_residual *residual, int n_threads, sheen_err *err)
{
    shots s = {g, residual, malloc((residual->count + 1) * sizeof *s.node)};
    *out = (sheen_partial_hemisphere){.n_nodes = g->n_nodes};
    out->rgb = calloc(g->n_nodes * 3, sizeof *out->rgb);
    out->n_hits = calloc(g->n_nodes, sizeof *out->n_hits);
    if (!out->rgb || !out->n_hits || !s.node) {
        free(s.node);
        sheen_partial_hemisphere_release(out);
        return sheen_fail_memory(err, 16.0 * (double)g->n_nodes, "a partial hemisphere");
    }
    sheen_parallel_for(residual->count, 4096, n_threads, shoot, &s);
    for (size_t i = 0; i < residual->count; i++) {
        const uint32_t node = s.node[i];
        if (node == UINT32_MAX)
            continue;
        for (int c = 0; c < 3; c++)
            out->rgb[3 * node + (uint32_t)c] += residual->pixels[i].rgb[c];
        out->n_hits[node]++;
    }
    free(s.node);
    for (size_t i = 0; i < 3 * g->n_nodes; i++)
        if (out->n_hits[i / 3])
            out->rgb[i] /= (float)out->n_hits[i / 3];
    return SHEEN_OK;
}

void sheen_partial_hemisphere_release(sheen_partial_hemisphere *p)
{
    free(p->rgb);
    free(p->n_hits);
    *p = (sheen_partial_hemisphere){0};
}

static void combine_node(sheen_hemisphere *h, size_t node, const sheen_partial_hemisphere *partials,
                         size_t n_views, float threshold_lin, float min_share)
{
    float sum[3] = {0, 0, 0};
    size_t n_reached = 0, n_lit = 0;
    for (size_t v = 0; v < n_views; v++) {
        const float *rgb = partials[v].rgb + 3 * node;
        if (!partials[v].n_hits[node])
            continue;
        n_reached++;
        n_lit += sheen_luminance(rgb) > threshold_lin;
        for (int c = 0; c < 3; c++)
            sum[c] += rgb[c];
    }
    h->n_reached[node] = (uint8_t)(n_reached < 255 ? n_reached : 255);
    h->n_lit[node] = (uint8_t)(n_lit < 255 ? n_lit : 255);
    if (!n_lit || (float)n_lit < min_share * (float)n_reached)
        return;
    for (int c = 0; c < 3; c++)
        h->rgb[3 * node + (size_t)c] = sum[c] > 0 ? sum[c] / (float)n_reached : 0;
    h->n_assigned++;
}

sheen_status sheen_hemisphere_combine(sheen_hemisphere *out, const sheen_partial_hemisphere *partials,
                                      size_t n_views, float threshold_lin, float min_share, sheen_err *err)
{
    const size_t n = n_views ? partials[0].n_nodes : 0;
    *out = (sheen_hemisphere){.n_nodes = n};
    out->rgb = calloc(n * 3 + 1, sizeof *out->rgb);
    out->n_reached = calloc(n + 1, 1);
    out->n_lit = calloc(n + 1, 1);
    if (!out->rgb || !out->n_reached || !out->n_lit) {
        sheen_hemisphere_release(out);
        return sheen_fail_memory(err, 14.0 * (double)n, "the illumination hemisphere");
    }
    for (size_t i = 0; i < n; i++)
        combine_node(out, i, partials, n_views, threshold_lin, min_share);
    return SHEEN_OK;
}

void sheen_hemisphere_release(sheen_hemisphere *h)
{
    free(h->rgb);
    free(h->n_reached);
    free(h->n_lit);
    *h = (sheen_hemisphere){0};
}

void sheen_hemisphere_colour(double light_rgb[3], const sheen_hemisphere *h)
{
    double sum[3] = {0, 0, 0};
    for (size_t i = 0; i < 3 * h->n_nodes; i++)
        sum[i % 3] += (double)h->rgb[i];
    const double Y = 0.2126 * sum[0] + 0.7152 * sum[1] + 0.0722 * sum[2];
    for (int c = 0; c < 3; c++)
        light_rgb[c] = Y > 0 ? sum[c] / Y : 1;
}

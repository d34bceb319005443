// SPDX-License-Identifier: Apache-2.0
// lamp_start.c - splats residuals to geodesic nodes at several distances, view by view, and takes the best node.
#include "fit/lamp_start.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "render/geodesic.h"

// Object's radius over the lamp's distance.
static const float nearness[] = {0, 0.06f, 0.12f, 0.19f, 0.27f, 0.38f, 0.5f};

typedef struct shot {
    float sum;
    uint32_t count;
} shot;

typedef struct best {
    double evidence;
    uint32_t node;
    float per_m;
} best;

// Direction from the origin to where the mirror ray of a sample meets the sphere of radius 1 / per_m.
static void meet_sphere(float d[3], const sheen_lamp_sample *s, float per_m)
{
    sheen_mirrorf(d, s->n_world, s->v_world);
    if (!(per_m > 0))
        return;
    const float xr = sheen_dotf(s->x_m, d), distance_m = 1 / per_m;
    const float t = -xr + sqrtf(fmaxf(0, xr * xr + distance_m * distance_m - sheen_dotf(s->x_m, s->x_m)));
    for (int i = 0; i < 3; i++)
        d[i] = s->x_m[i] + t * d[i];
    sheen_normalizef(d);
}

static int is_banned(const float d[3], const sheen_lamp_ban *bans, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (sheen_dotf(d, bans[i].direction_world) > bans[i].cosine)
            return 1;
    return 0;
}

static double evidence_of(const shot *shots, size_t n_nodes, size_t n_views, uint32_t node,
                          float threshold_lin)
{
    size_t n_reached = 0, n_lit = 0, count = 0;
    double sum = 0;
    for (size_t v = 0; v < n_views; v++) {
        const shot *s = &shots[v * n_nodes + node];
        if (!s->count)
            continue;
        n_reached++;
        n_lit += s->sum > 0.5f * threshold_lin * (float)s->count;
        count += s->count;
        sum += (double)s->sum;
    }
    if (!n_lit || 2 * n_lit < n_reached || !(sum > 0) || count < 3)
        return 0;
    return sum * sum / (double)count;
}

// The node's spot: direction and mean light, weighted by what arrives there.
static void measure_spot(sheen_lamp *out, const sheen_lamp_samples *samples, const float *residual,
                         const float centre[3], float per_m, float cosine)
{
    float d[3] = {0, 0, 0}, most = 0;
    for (size_t i = 0; i < samples->count; i++) {
        float m[3];
        if (!(residual[i] > 0))
            continue;
        meet_sphere(m, &samples->at[i], per_m);
        if (sheen_dotf(m, centre) < cosine)
            continue;
        for (int k = 0; k < 3; k++)
            d[k] += residual[i] * m[k];
        most = fmaxf(most, residual[i] * sheen_dotf(samples->at[i].n_world, samples->at[i].v_world));
    }
    if (!(sheen_normalizef(d) > 0))
        memcpy(d, centre, sizeof d);
    *out = (sheen_lamp){.inverse_distance_per_m = per_m, .rgb = {0.8f * most, 0.8f * most, 0.8f * most}};
    memcpy(out->direction_world, d, sizeof d);
}

int sheen_lamp_start(sheen_lamp *out, const sheen_lamp_samples *samples, const float *residual,
                     float sigma_rad, float threshold_lin, const sheen_lamp_ban *bans, size_t n_bans)
{
    // Nodes about one and a half sigma apart: a point's spot is two sigma wide there
    const int frequency = (int)fminf(90, fmaxf(6, 0.8f / sigma_rad));
    sheen_geodesic g;
    best b = {0};
    if (sheen_geodesic_init(&g, frequency, NULL))
        return -1;
    const size_t n_shots = g.n_nodes * samples->n_views;
    shot *shots = malloc(n_shots * sizeof *shots);
    for (size_t k = 0; shots && k < sizeof nearness / sizeof *nearness; k++) {
        const float per_m = nearness[k] / samples->radius_m;
        memset(shots, 0, n_shots * sizeof *shots);
        for (size_t i = 0; i < samples->count; i++) {
            float d[3];
            meet_sphere(d, &samples->at[i], per_m);
            const uint32_t node = sheen_geodesic_nearest(&g, d);
            if (node == UINT32_MAX)
                continue;
            shot *s = &shots[samples->at[i].view * g.n_nodes + node];
            s->sum += residual[i];
            s->count++;
        }
        for (uint32_t node = 0; node < g.n_nodes; node++) {
            const double evidence = evidence_of(shots, g.n_nodes, samples->n_views, node, threshold_lin);
            if (evidence > b.evidence && !is_banned(g.v_world + 3 * node, bans, n_bans))
                b = (best){evidence, node, per_m};
        }
    }
    if (b.evidence > 0)
        measure_spot(out, samples, residual, g.v_world + 3 * b.node, b.per_m, cosf(2 * sigma_rad));
    const int found = shots ? b.evidence > 0 : -1;
    free(shots);
    sheen_geodesic_release(&g);
    return found;
}

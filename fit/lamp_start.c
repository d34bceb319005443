// SPDX-License-Identifier: Apache-2.0
// lamp_start.c - splats residuals to geodesic nodes at several distances, view by view, and takes the best node.
#include "fit/lamp_start.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/vec.h"

// Object's radius over the lamp's distance.
enum { DISTANCES = 7 };
static const float nearness[DISTANCES] = {0, 0.06f, 0.12f, 0.19f, 0.27f, 0.38f, 0.5f};

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

// The best node of each distance: one is worked on by one thread.
typedef struct distances {
    const sheen_geodesic *g;
    const sheen_lamp_samples *samples;
    const float *residual;
    float threshold_lin;
    const sheen_lamp_ban *bans;
    size_t n_bans;
    best best[DISTANCES];
    int without_memory[DISTANCES];
} distances;

static void shoot(shot *shots, const distances *j, float per_m)
{
    for (size_t i = 0; i < j->samples->count; i++) {
        float d[3];
        meet_sphere(d, &j->samples->at[i], per_m);
        const uint32_t node = sheen_geodesic_nearest(j->g, d);
        if (node == UINT32_MAX)
            continue;
        shot *s = &shots[j->samples->at[i].view * j->g->n_nodes + node];
        s->sum += j->residual[i];
        s->count++;
    }
}

static void search_distances(void *self, size_t begin, size_t end)
{
    distances *j = self;
    for (size_t k = begin; k < end; k++) {
        const float per_m = nearness[k] / j->samples->radius_m;
        shot *shots = calloc(j->g->n_nodes * j->samples->n_views + 1, sizeof *shots);
        j->without_memory[k] = !shots;
        if (!shots)
            continue;
        shoot(shots, j, per_m);
        for (uint32_t node = 0; node < j->g->n_nodes; node++) {
            const double evidence = evidence_of(shots, j->g->n_nodes, j->samples->n_views, node,
                                                j->threshold_lin);
            if (evidence > j->best[k].evidence &&
                !is_banned(j->g->v_world + 3 * (size_t)node, j->bans, j->n_bans))
                j->best[k] = (best){evidence, node, per_m};
        }
        free(shots);
    }
}

int sheen_lamp_start_frequency(float sigma_rad)
{
    return (int)fminf(90, fmaxf(6, 0.8f / sigma_rad));
}

int sheen_lamp_start(sheen_lamp *out, const sheen_geodesic *g, const sheen_lamp_samples *samples,
                     const float *residual, const sheen_lamp_start_options *options)
{
    distances j = {.g = g,
                   .samples = samples,
                   .residual = residual,
                   .threshold_lin = options->threshold_lin,
                   .bans = options->bans,
                   .n_bans = options->n_bans};
    best b = {0};
    sheen_parallel_for(DISTANCES, 1, options->n_threads, search_distances, &j);
    for (size_t k = 0; k < DISTANCES; k++) {
        if (j.without_memory[k])
            return -1;
        if (j.best[k].evidence > b.evidence)
            b = j.best[k];
    }
    if (b.evidence > 0)
        measure_spot(out, samples, residual, g->v_world + 3 * (size_t)b.node, b.per_m,
                     cosf(2 * options->sigma_rad));
    return b.evidence > 0;
}

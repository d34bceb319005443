// SPDX-License-Identifier: Apache-2.0
// bench_lobe.c - the lobe's sum at each level of instruction set, its reference, and the sum over cells.
//
// A share is of what kernels written by hand for these terms reached on an EPYC of the fourth generation at 2.6 GHz: 2.1
// thousand million a second with AVX-512, and half of it with vectors of half the width.
#include "render/lobe.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/cpu_level.h"
#include "render/geodesic.h"
#include "tests/bench/bench.h"
#include "tests/support.h"

enum { N_VIEWS = 2000, N_BRUTE = 200 };

typedef struct job {
    sheen_lights lights;
    sheen_light_cells *cells;
    const sheen_geodesic *g;
    float n[N_VIEWS][3], v[N_VIEWS][3], sigma_rad;
    int level;
} job;

static void run_level(void *self)
{
    const job *j = self;
    float sum = 0;
    for (int i = 0; i < N_BRUTE; i++)
        sum += sheen_lobe_sum_level(&j->lights, j->n[i], j->v[i], j->sigma_rad, j->level);
    bench_keep((double)sum);
}

static void run_ref(void *self)
{
    const job *j = self;
    double sum = 0;
    for (int i = 0; i < N_BRUTE / 10; i++)
        sum += sheen_lobe_sum_ref(&j->lights, j->n[i], j->v[i], j->sigma_rad);
    bench_keep(sum);
}

static void run_cells(void *self)
{
    const job *j = self;
    float sum = 0;
    for (int i = 0; i < N_VIEWS; i++)
        sum += sheen_light_cells_sum(j->cells, j->n[i], j->v[i]);
    bench_keep((double)sum);
}

static void run_new_cells(void *self)
{
    const job *j = self;
    sheen_light_cells *cells;
    if (!sheen_light_cells_new(&cells, &j->lights, j->sigma_rad, NULL))
        sheen_light_cells_free(&cells);
}

static void run_alpha(void *self)
{
    const job *j = self;
    float sum = 0;
    for (size_t i = 0; i < j->lights.count; i++) {
        const float l[3] = {j->lights.dx[i], j->lights.dy[i], j->lights.dz[i]};
        sum += sheen_lobe_alpha2(j->n[0], j->v[0], l);
    }
    bench_keep((double)sum);
}

static void run_nearest(void *self)
{
    const job *j = self;
    uint32_t sum = 0;
    for (int i = 0; i < N_VIEWS; i++)
        sum += sheen_geodesic_nearest(j->g, j->n[i]);
    bench_keep((double)sum);
}

static void fill_views(job *j)
{
    uint64_t seed = 1;
    for (int i = 0; i < N_VIEWS; i++)
        do
            for (int k = 0; k < 3; k++) {
                j->n[i][k] = (float)test_random_normal(&seed);
                j->v[i][k] = (float)test_random_normal(&seed);
            }
        while (sheen_normalizef(j->n[i]) < 0.1f || sheen_normalizef(j->v[i]) < 0.1f ||
               sheen_dotf(j->n[i], j->v[i]) <= 0.1f || j->n[i][2] < 0);
}

// Every `step`-th node of the paper's hemisphere is lit.
static int fill_lights(job *j, const sheen_geodesic *g, size_t step)
{
    const size_t n = (g->n_nodes + step - 1) / step;
    float *all = malloc(4 * n * sizeof *all);
    if (!all)
        return 0;
    j->lights = (sheen_lights){all, all + n, all + 2 * n, all + 3 * n, n};
    for (size_t i = 0; i < n; i++) {
        const float *d = g->v_world + 3 * step * i;
        j->lights.dx[i] = d[0];
        j->lights.dy[i] = d[1];
        j->lights.dz[i] = d[2];
        j->lights.weight[i] = 1;
    }
    return 1;
}

int main(void)
{
    static job j;
    sheen_geodesic g;
    if (sheen_geodesic_init(&g, 60, NULL))
        return 1;
    j.g = &g;
    fill_views(&j);
    bench("geodesic: nearest of 18151 nodes", N_VIEWS, 200, run_nearest, &j);
    static const size_t steps[] = {1, 16};
    for (size_t s = 0; s < 2; s++) {
        if (!fill_lights(&j, &g, steps[s]))
            return 1;
        char name[64];
        j.sigma_rad = 0.0114f;
        for (j.level = 0; j.level <= sheen_cpu_level(); j.level++) {
            static const double limits_per_ns[] = {0, 1.05, 2.1};
            snprintf(name, sizeof name, "lobe: level %d, %zu lights", j.level, j.lights.count);
            const double per_ns = 1 / bench(name, N_BRUTE * j.lights.count, 20, run_level, &j);
            if (limits_per_ns[j.level] > 0)
                printf("    %.2f terms a ns, %.0f %% of the limit\n", per_ns,
                       100 * per_ns / limits_per_ns[j.level]);
        }
        bench("lobe: reference", N_BRUTE / 10 * j.lights.count, 3, run_ref, &j);
        bench("lobe: alpha2 of a pair", j.lights.count, 50, run_alpha, &j);
        static const float sigmas_rad[] = {0.0114f, 0.03f, 0.1f, 0.3f};
        for (size_t i = 0; i < 4; i++) {
            j.sigma_rad = sigmas_rad[i];
            if (sheen_light_cells_new(&j.cells, &j.lights, j.sigma_rad, NULL))
                return 1;
            snprintf(name, sizeof name, "cells: sigma %.4f, %zu lights, a sum", (double)j.sigma_rad,
                     j.lights.count);
            bench(name, N_VIEWS, 20, run_cells, &j);
            snprintf(name, sizeof name, "cells: sigma %.4f, %zu lights, making", (double)j.sigma_rad,
                     j.lights.count);
            bench(name, 1, 2, run_new_cells, &j);
            sheen_light_cells_free(&j.cells);
        }
        free(j.lights.dx);
    }
    sheen_geodesic_release(&g);
    return 0;
}

// SPDX-License-Identifier: Apache-2.0
// light_step.c - lamps on the paper's hemisphere, seen by samples whose mirror directions fall on and about them.
#include "tests/bench/light_step.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "fit/robust.h"
#include "render/geodesic.h"
#include "tests/support.h"

enum { LAMPS = 24, FREQUENCY = 60 };

static const double sigma_rad = 0.0114, noise_lin = 0.01, cap_rad = 0.091, reach_rad = 0.115;

static void direction(float v[3], uint64_t *seed)
{
    do
        for (int k = 0; k < 3; k++)
            v[k] = (float)test_random_normal(seed);
    while (sheen_dotf(v, v) < 1e-3f);
    sheen_normalizef(v);
}

static void lay_lamps(float lamp[LAMPS][3], uint64_t *seed)
{
    for (int i = 0; i < LAMPS; i++) {
        int apart = 0;
        while (!apart) {
            direction(lamp[i], seed);
            apart = lamp[i][2] > 0.25f;
            for (int k = 0; k < i; k++)
                apart = apart && sheen_dotf(lamp[i], lamp[k]) < cosf(2.1f * (float)cap_rad);
        }
    }
}

// Nodes in the caps may be lit; a bright middle is.
static size_t choose_nodes(float *node_world, double *x, const sheen_geodesic *g, float lamp[LAMPS][3])
{
    size_t n = 0;
    for (size_t i = 0; i < g->n_nodes; i++)
        for (int k = 0; k < LAMPS; k++) {
            const double angle_rad = acos(fmin(1, (double)sheen_dotf(g->v_world + 3 * i, lamp[k])));
            if (angle_rad > cap_rad)
                continue;
            memcpy(node_world + 3 * n, g->v_world + 3 * i, 3 * sizeof *node_world);
            x[n++] = angle_rad < 0.5 * cap_rad ? 0.02 + 0.03 * (k % 4) : 0;
        }
    return n;
}

static void take_samples(sheen_samples *s, size_t n, float lamp[LAMPS][3], uint64_t *seed)
{
    *s = (sheen_samples){.n_world = malloc(3 * n * sizeof(float)), .v_world = malloc(3 * n * sizeof(float))};
    assert_true(s->n_world && s->v_world);
    while (s->count < n) {
        const float *towards = lamp[(size_t)(LAMPS * test_random(seed))];
        float r[3], v[3], *normal = s->n_world + 3 * s->count;
        direction(r, seed);
        for (int k = 0; k < 3; k++)
            r[k] = towards[k] + (float)reach_rad * r[k];
        sheen_normalizef(r);
        direction(v, seed);
        for (int k = 0; k < 3; k++)
            normal[k] = r[k] + v[k];
        sheen_normalizef(normal);
        if (sheen_dotf(normal, v) < 0.4f)
            continue;
        memcpy(s->v_world + 3 * s->count++, v, sizeof v);
    }
}

void light_step_make(light_step *p, size_t n_samples, uint64_t seed)
{
    sheen_geodesic g;
    sheen_samples samples;
    sheen_err err;
    float lamp[LAMPS][3];
    memset(p, 0, sizeof *p);
    assert_ok(sheen_geodesic_init(&g, FREQUENCY, &err), err);
    lay_lamps(lamp, &seed);
    float *node_world = malloc(3 * g.n_nodes * sizeof *node_world);
    p->x_true = calloc(g.n_nodes, sizeof *p->x_true);
    p->y = malloc(n_samples * sizeof *p->y);
    assert_true(node_world && p->x_true && p->y);
    const size_t n_nodes = choose_nodes(node_world, p->x_true, &g, lamp);
    take_samples(&samples, n_samples, lamp, &seed);
    assert_ok(sheen_light_matrix_init(&p->m, &samples, node_world, n_nodes, sigma_rad, 1, &err), err);
    sheen_light_matrix_set_sigma(&p->m, sigma_rad, 1);
    double *clean = malloc(n_samples * sizeof *clean);
    assert_non_null(clean);
    sheen_light_matrix_predict(&p->m, clean, p->x_true, sigma_rad);
    for (size_t i = 0; i < n_samples; i++)
        p->y[i] = (float)(clean[i] + noise_lin * test_random_normal(&seed) +
                          (test_random(&seed) < 0.05 ? test_random(&seed) : 0));
    p->scale = noise_lin;
    free(clean);
    free(node_world);
    sheen_samples_release(&samples);
    sheen_geodesic_release(&g);
}

void light_step_release(light_step *p)
{
    sheen_light_matrix_release(&p->m);
    free(p->y);
    free(p->x_true);
}

double light_step_objective(const light_step *p, const double *x)
{
    double *r = malloc(p->m.n_samples * sizeof *r);
    assert_non_null(r);
    sheen_light_matrix_predict(&p->m, r, x, sigma_rad);
    for (size_t i = 0; i < p->m.n_samples; i++)
        r[i] = (double)p->y[i] - r[i];
    const double E = sheen_loss_mean(SHEEN_LOSS_LORENTZIAN, r, p->m.n_samples, p->scale);
    free(r);
    return E;
}

// SPDX-License-Identifier: Apache-2.0
// test_nnls.c - the sparse matrix of eq. (7) against the formula, and the solver against its optimality conditions.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fit/nnls.h"
#include "lit_sphere.h"
#include "render/geodesic.h"
#include "support.h"

static const lit_sphere scene = {.light_world = {{0.6, 0, 0.8}, {-0.48, 0.6, 0.64}},
                                 .strength = {0.5, 0.3},
                                 .n_lights = 2,
                                 .sigma_rad = 0.06,
                                 .noise = 0.002,
                                 .n_views = 4};

static void matrix_is_the_formula(void **state)
{
    (void)state;
    sheen_err err;
    sheen_samples s;
    sheen_geodesic g;
    sheen_light_matrix m;
    lit_sphere_samples(&s, &scene, 0.05, 1);
    assert_true(s.count > 300);
    assert_ok(sheen_geodesic_init(&g, 12, &err), err);
    assert_ok(sheen_light_matrix_init(&m, &s, g.v_world, g.n_nodes, 0.1, 1, &err), err);
    double *x = calloc(g.n_nodes, sizeof *x), *got = malloc(s.count * sizeof *got);
    float *w = calloc(g.n_nodes, sizeof *w), *d = malloc(3 * g.n_nodes * sizeof *d);
    uint64_t seed = 9;
    for (size_t l = 0; l < g.n_nodes; l++) {
        x[l] = l % 3 ? 0 : test_random(&seed);
        w[l] = (float)x[l];
        for (size_t c = 0; c < 3; c++)
            d[c * g.n_nodes + l] = g.v_world[3 * l + c];
    }
    const sheen_lights lights = {d, d + g.n_nodes, d + 2 * g.n_nodes, w, g.n_nodes};
    sheen_light_matrix_predict(&m, got, x, 0.08);
    for (size_t i = 0; i < s.count; i += 7) {
        const double want = sheen_lobe_sum_ref(&lights, s.n_world + 3 * i, s.v_world + 3 * i, 0.08f);
        assert_close(got[i], want, 1e-4 + 1e-4 * want);
    }
    free(x);
    free(got);
    free(w);
    free(d);
    sheen_light_matrix_release(&m);
    sheen_geodesic_release(&g);
    sheen_samples_release(&s);
}

// Karush, Kuhn and Tucker: no slope where x > 0, none downwards where x = 0. And E never rises on the way.
static void solution_is_a_minimum(void **state)
{
    (void)state;
    sheen_err err;
    sheen_samples s;
    sheen_geodesic g;
    sheen_light_matrix m;
    lit_sphere_samples(&s, &scene, 0.02, 2);
    for (size_t i = 0; i < s.count; i += 11)
        s.intensity[i] += 0.7f; // outliers
    assert_ok(sheen_geodesic_init(&g, 10, &err), err);
    assert_ok(sheen_light_matrix_init(&m, &s, g.v_world, g.n_nodes, 0.06, 1, &err), err);
    sheen_light_matrix_set_sigma(&m, 0.06, 1);
    double *x = calloc(g.n_nodes, sizeof *x), *r = malloc(s.count * sizeof *r),
           *w = malloc(s.count * sizeof *w);
    double before = HUGE_VAL;
    for (int i = 0; i < 400; i++) {
        const sheen_nnls_options o = {SHEEN_LOSS_LORENTZIAN, 0.02, 1, 4, 0};
        const double now = sheen_nnls(&m, s.intensity, x, r, w, &o);
        assert_true(now <= before * (1 + 1e-12));
        before = now;
    }
    size_t n_lit = 0;
    for (size_t l = 0; l < m.n_nodes; l++) {
        double slope = 0, curvature = 0;
        for (size_t k = m.column_start[l]; k < m.column_start[l + 1]; k++) {
            const double weight = sheen_loss_weight(SHEEN_LOSS_LORENTZIAN, r[m.sample[k]], 0.02);
            slope += weight * (double)m.value[k] * r[m.sample[k]];
            curvature += weight * (double)(m.value[k] * m.value[k]);
        }
        if (curvature < 1e-3)
            continue;
        assert_true(slope / curvature < 2e-3); // a step up would be smaller than this
        if (x[l] > 1e-3)
            assert_close(slope / curvature, 0, 2e-3);
        n_lit += x[l] > 0.01;
    }
    assert_true(n_lit >= 2 && n_lit < 40);
    free(x);
    free(r);
    free(w);
    sheen_light_matrix_release(&m);
    sheen_geodesic_release(&g);
    sheen_samples_release(&s);
}

static void threads_do_not_change_the_matrix(void **state)
{
    (void)state;
    sheen_err err;
    sheen_samples s;
    sheen_geodesic g;
    sheen_light_matrix a, b;
    lit_sphere_samples(&s, &scene, 0.05, 3);
    assert_ok(sheen_geodesic_init(&g, 20, &err), err);
    assert_ok(sheen_light_matrix_init(&a, &s, g.v_world, g.n_nodes, 0.08, 1, &err), err);
    assert_ok(sheen_light_matrix_init(&b, &s, g.v_world, g.n_nodes, 0.08, 3, &err), err);
    sheen_light_matrix_set_sigma(&a, 0.07, 1);
    sheen_light_matrix_set_sigma(&b, 0.07, 3);
    assert_int_equal(a.n_pairs, b.n_pairs);
    assert_memory_equal(a.value, b.value, a.n_pairs * sizeof *a.value);
    assert_memory_equal(a.sample, b.sample, a.n_pairs * sizeof *a.sample);
    sheen_light_matrix_release(&a);
    sheen_light_matrix_release(&b);
    sheen_geodesic_release(&g);
    sheen_samples_release(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(matrix_is_the_formula),
        cmocka_unit_test(solution_is_a_minimum),
        cmocka_unit_test(threads_do_not_change_the_matrix),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

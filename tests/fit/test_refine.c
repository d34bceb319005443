// SPDX-License-Identifier: Apache-2.0
// test_refine.c - section 4.3 on samples with known lights: does it find sigma, and the lights' directions?
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fit/refine.h"
#include "lit_sphere.h"
#include "render/geodesic.h"
#include "support.h"

typedef struct found {
    sheen_refine_result r;
    float *node_world, *radiance0;
    size_t n_nodes;
} found;

// Every node within 12 degrees of a light, all equally bright: a poorer start than an illumination hemisphere gives.
static void start(found *f, const sheen_geodesic *g, const lit_sphere *scene)
{
    f->node_world = malloc(3 * g->n_nodes * sizeof(float));
    f->radiance0 = malloc(g->n_nodes * sizeof(float));
    f->n_nodes = 0;
    for (size_t i = 0; i < g->n_nodes; i++)
        for (int l = 0; l < scene->n_lights; l++) {
            const float *v = g->v_world + 3 * i;
            const double c = (double)v[0] * scene->light_world[l][0] +
                             (double)v[1] * scene->light_world[l][1] +
                             (double)v[2] * scene->light_world[l][2];
            if (c < cos(0.21))
                continue;
            memcpy(f->node_world + 3 * f->n_nodes, v, 3 * sizeof(float));
            f->radiance0[f->n_nodes++] = 1;
            break;
        }
}

static void fit(found *f, const lit_sphere *scene, double sigma0_rad, int frequency, uint64_t seed)
{
    sheen_err err;
    sheen_samples s;
    sheen_geodesic g;
    lit_sphere_samples(&s, scene, 0.03, seed);
    assert_ok(sheen_geodesic_init(&g, frequency, &err), err);
    start(f, &g, scene);
    const sheen_refine_options o = {.sigma0_rad = sigma0_rad};
    assert_ok(sheen_refine(&f->r, &s, f->node_world, f->radiance0, f->n_nodes,
                           sheen_geodesic_solid_angle_sr(&g), &o, &err),
              err);
    // Gauge: sum omega L = 1
    double sum = 0;
    for (size_t i = 0; i < f->n_nodes; i++)
        sum += f->r.radiance[i] * sheen_geodesic_solid_angle_sr(&g);
    assert_close(sum, 1, 1e-9);
    sheen_geodesic_release(&g);
    sheen_samples_release(&s);
}

static void release(found *f)
{
    sheen_refine_result_release(&f->r);
    free(f->node_world);
    free(f->radiance0);
}

// Angle between a true light and the radiance-weighted centre of the nodes within 6 degrees of it.
static double direction_error_rad(const found *f, const double light[3])
{
    double c[3] = {0, 0, 0};
    for (size_t i = 0; i < f->n_nodes; i++) {
        const double v[3] = {(double)f->node_world[3 * i], (double)f->node_world[3 * i + 1],
                             (double)f->node_world[3 * i + 2]};
        if (sheen_dot(v, light) > cos(0.105))
            for (int k = 0; k < 3; k++)
                c[k] += f->r.radiance[i] * v[k];
    }
    sheen_normalize(c);
    return acos(fmin(1, sheen_dot(c, light)));
}

static const lit_sphere scene = {.light_world = {{0.6, 0, 0.8}, {-0.48, 0.6, 0.64}, {0, -0.8, 0.6}},
                                 .strength = {0.5, 0.3, 0.6},
                                 .n_lights = 3,
                                 .noise = 0.005,
                                 .n_views = 6};

static void finds_sigma_and_lights(void **state)
{
    (void)state;
    for (int k = 0; k < 2; k++) {
        lit_sphere s = scene;
        s.sigma_rad = k ? 0.06 : 0.03;
        found f;
        fit(&f, &s, 2 * s.sigma_rad, k ? 40 : 60, 4);
        print_message(
            "sigma %.5f, truth %.5f (%+.1f %%), k_S %.4f, truth 1.4, %zu turns, %zu of %zu nodes left\n",
            f.r.sigma_rad, s.sigma_rad, 100 * (f.r.sigma_rad / s.sigma_rad - 1), f.r.k_s, f.r.n_turns,
            f.r.n_nodes_left, f.n_nodes);
        assert_true(f.r.converged);
        assert_close(f.r.sigma_rad / s.sigma_rad, 1, 0.05);
        assert_close(f.r.k_s, 1.4, 0.3);
        for (int l = 0; l < 3; l++)
            assert_true(direction_error_rad(&f, s.light_world[l]) < 0.2 * 3.14159265 / 180);
        for (size_t t = 7; t < f.r.n_turns; t++) // the scale is settled: E may not rise
            assert_true(f.r.turns[t].objective <= f.r.turns[t - 1].objective * (1 + 1e-9));
        release(&f);
    }
}

static void outliers_do_not_matter_much(void **state)
{
    (void)state;
    lit_sphere s = scene;
    sheen_err err;
    sheen_samples samples;
    sheen_geodesic g;
    s.sigma_rad = 0.05;
    lit_sphere_samples(&samples, &s, 0.03, 8);
    uint64_t seed = 3;
    for (size_t i = 0; i < samples.count; i++)
        if (test_random(&seed) < 0.08)
            samples.intensity[i] += (float)test_random(&seed);
    assert_ok(sheen_geodesic_init(&g, 40, &err), err);
    found f;
    start(&f, &g, &s);
    const sheen_refine_options o = {.sigma0_rad = 0.1};
    assert_ok(sheen_refine(&f.r, &samples, f.node_world, f.radiance0, f.n_nodes,
                           sheen_geodesic_solid_angle_sr(&g), &o, &err),
              err);
    assert_close(f.r.sigma_rad / s.sigma_rad, 1, 0.15);
    release(&f);
    sheen_geodesic_release(&g);
    sheen_samples_release(&samples);
}

static bool refuse(void *self, const char *what, int done, int total)
{
    (void)what;
    (void)total;
    *(int *)self = done;
    return done < 2;
}

static void says_what_is_wrong_and_can_be_cancelled(void **state)
{
    (void)state;
    sheen_err err;
    sheen_refine_result r;
    const sheen_samples none = {0};
    const sheen_refine_options o = {.sigma0_rad = 0.1};
    assert_fails(sheen_refine(&r, &none, NULL, NULL, 0, 1, &o, &err), err, SHEEN_EDATA, "no highlight");

    lit_sphere s = scene;
    s.sigma_rad = 0.05;
    sheen_samples samples;
    sheen_geodesic g;
    found f;
    lit_sphere_samples(&samples, &s, 0.05, 8);
    assert_ok(sheen_geodesic_init(&g, 20, &err), err);
    start(&f, &g, &s);
    int last = -1;
    const sheen_refine_options stop = {.sigma0_rad = 0.1, .progress = {.step = refuse, .self = &last}};
    assert_fails(sheen_refine(&f.r, &samples, f.node_world, f.radiance0, f.n_nodes, 0.001, &stop, &err), err,
                 SHEEN_ECANCEL, "cancelled");
    assert_int_equal(last, 2);
    release(&f);
    sheen_geodesic_release(&g);
    sheen_samples_release(&samples);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(finds_sigma_and_lights),
        cmocka_unit_test(outliers_do_not_matter_much),
        cmocka_unit_test(says_what_is_wrong_and_can_be_cancelled),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// SPDX-License-Identifier: Apache-2.0
// test_irradiance_fit.c - light and albedo of a surface that turned, told apart; and that nothing is told of what stood still.
#include "fit/irradiance_fit.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "tests/support.h"

enum { N_TEXELS = 1500, N_VIEWS = 12 };

typedef struct scene {
    sheen_irradiance truth;
    sheen_lit_texels texels;
    double (*albedo)[3];
} scene;

static const float lamp_directions[2][3] = {{0.6f, 0, 0.8f}, {-0.48f, 0.6f, 0.64f}};

// Random normals and colours, turned about z by 30 degrees a view; each is lit by ambient light and lamps.
static void make(scene *s, int degree, int n_lamps, double noise, bool turned)
{
    uint64_t seed = 7;
    *s = (scene){.truth = {.present = 1, .degree = degree, .n_lamps = n_lamps}};
    for (int c = 0; c < 3; c++) {
        const double ambient[9] = {1, 0.2, 0.25, -0.15 - 0.05 * c, 0.05, 0.04, 0.03, -0.05, 0.06};
        double mean = ambient[0] * 0.28209479;
        for (int j = 0; j < n_lamps; j++)
            mean += (s->truth.lamps[j].rgb[c] = 0.8 - 0.2 * c + 0.3 * j) / 4;
        for (int k = 0; k < (degree + 1) * (degree + 1); k++)
            s->truth.rgb[k][c] = ambient[k] / mean;
        for (int j = 0; j < n_lamps; j++)
            s->truth.lamps[j].rgb[c] /= mean;
    }
    for (int j = 0; j < n_lamps; j++)
        memcpy(s->truth.lamps[j].l_world, lamp_directions[j], sizeof lamp_directions[j]);
    s->texels = (sheen_lit_texels){.samples = calloc((size_t)N_TEXELS * N_VIEWS, sizeof *s->texels.samples),
                                   .first = calloc(N_TEXELS + 1, sizeof *s->texels.first),
                                   .n_texels = N_TEXELS};
    s->albedo = calloc(N_TEXELS, sizeof *s->albedo);
    for (size_t t = 0; t < N_TEXELS; t++) {
        float n[3];
        for (int k = 0; k < 3; k++) {
            n[k] = (float)test_random_normal(&seed);
            s->albedo[t][k] = 0.1 + 0.5 * test_random(&seed);
        }
        sheen_normalizef(n);
        s->texels.first[t + 1] = (t + 1) * N_VIEWS;
        for (int v = 0; v < N_VIEWS; v++) {
            sheen_lit_sample *x = &s->texels.samples[t * N_VIEWS + (size_t)v];
            const double a = turned ? v * 3.14159265358979323846 / 6 : 0;
            double E[3];
            x->n_world[0] = (float)(cos(a) * (double)n[0] - sin(a) * (double)n[1]);
            x->n_world[1] = (float)(sin(a) * (double)n[0] + cos(a) * (double)n[1]);
            x->n_world[2] = n[2];
            x->weight = 1;
            x->view = v;
            x->lit = 3;
            sheen_lit_irradiance(E, &s->truth, x);
            for (int c = 0; c < 3; c++)
                x->rgb[c] = (float)(s->albedo[t][c] * E[c] + noise * test_random_normal(&seed));
        }
    }
}

static void drop(scene *s)
{
    sheen_lit_texels_release(&s->texels);
    free(s->albedo);
}

// rms of albedo times light against the truth: what pictures are drawn from.
static double product_error(const scene *s, const sheen_irradiance *e)
{
    double sum = 0;
    for (size_t t = 0; t < N_TEXELS; t++) {
        const sheen_lit_sample *x = s->texels.samples + t * N_VIEWS;
        double a[3], E[3], truth[3];
        sheen_lit_albedo(a, e, x, N_VIEWS);
        for (int v = 0; v < N_VIEWS; v++) {
            sheen_lit_irradiance(E, e, &x[v]);
            sheen_lit_irradiance(truth, &s->truth, &x[v]);
            for (int c = 0; c < 3; c++)
                sum += pow(a[c] * E[c] - s->albedo[t][c] * truth[c], 2);
        }
    }
    return sqrt(sum / (3.0 * N_TEXELS * N_VIEWS));
}

static sheen_irradiance fitted(const scene *s, int degree)
{
    sheen_irradiance e = {.degree = degree, .n_lamps = s->truth.n_lamps};
    sheen_err err;
    memcpy(e.lamps, s->truth.lamps, sizeof e.lamps);
    assert_ok(sheen_irradiance_fit(&e, &s->texels, SHEEN_NO_FOLD, 25, &err), err);
    return e;
}

static void light_and_albedo_are_told_apart(void **state)
{
    (void)state;
    for (int n_lamps = 0; n_lamps <= 2; n_lamps += 2) {
        scene s;
        make(&s, 2, n_lamps, 0.002, true);
        const sheen_irradiance e = fitted(&s, 2);
        assert_true(product_error(&s, &e) < 0.003);
        for (int c = 0; c < 3; c++) { // the convention: mean 1
            double mean = e.rgb[0][c] * 0.28209479;
            for (int j = 0; j < n_lamps; j++)
                mean += e.lamps[j].rgb[c] / 4;
            assert_close(mean, 1, 1e-6);
            for (int j = 0; j < n_lamps; j++)
                assert_close(e.lamps[j].rgb[c] / s.truth.lamps[j].rgb[c], 1, 0.15);
        }
        drop(&s);
    }
}

static void highlights_left_over_do_not_matter(void **state)
{
    (void)state;
    scene s;
    uint64_t seed = 3;
    make(&s, 2, 2, 0.002, true);
    for (size_t i = 0; i < (size_t)N_TEXELS * N_VIEWS; i++)
        if (test_random(&seed) < 0.08)
            for (int c = 0; c < 3; c++)
                s.texels.samples[i].rgb[c] += 0.5f;
    const sheen_irradiance e = fitted(&s, 2);
    assert_true(product_error(&s, &e) < 0.006);
    drop(&s);
}

// One light frame: the same code finds even light, and the albedo is the robust mean over the views, the paper's colour.
static void what_did_not_turn_keeps_the_model_of_the_paper(void **state)
{
    (void)state;
    scene s;
    make(&s, 2, 2, 0.002, false);
    const sheen_irradiance e = fitted(&s, 2), even = {0};
    for (size_t t = 0; t < N_TEXELS; t++) {
        const sheen_lit_sample *x = s.texels.samples + t * N_VIEWS;
        double E[3], a[3], plain[3];
        sheen_lit_irradiance(E, &e, x);
        sheen_lit_albedo(a, &e, x, N_VIEWS);
        sheen_lit_albedo(plain, &even, x, N_VIEWS);
        for (int c = 0; c < 3; c++) {
            assert_close(E[c], 1, 0.02);
            assert_close(a[c] * E[c], plain[c], 1e-4);
        }
    }
    drop(&s);
}

static void the_degree_is_the_one_that_predicts(void **state)
{
    (void)state;
    for (int degree = 0; degree <= 2; degree++) {
        scene s;
        sheen_err err;
        int found;
        make(&s, degree, 0, 0.005, true);
        assert_ok(sheen_irradiance_choose_degree(&found, &s.truth, &s.texels, &err), err);
        assert_int_equal(found, degree);
        drop(&s);
    }
}

static void light_is_nowhere_negative(void **state)
{
    (void)state;
    scene s;
    make(&s, 2, 2, 0.05, true);
    const sheen_irradiance e = fitted(&s, 2);
    for (size_t i = 0; i < (size_t)N_TEXELS * N_VIEWS; i++) {
        sheen_irradiance ambient = e;
        ambient.n_lamps = 0;
        double E[3];
        sheen_lit_irradiance(E, &ambient, &s.texels.samples[i]);
        for (int c = 0; c < 3; c++)
            assert_true(E[c] >= 0);
    }
    for (int j = 0; j < e.n_lamps; j++)
        for (int c = 0; c < 3; c++)
            assert_true(e.lamps[j].rgb[c] >= 0);
    drop(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_and_albedo_are_told_apart),
        cmocka_unit_test(highlights_left_over_do_not_matter),
        cmocka_unit_test(what_did_not_turn_keeps_the_model_of_the_paper),
        cmocka_unit_test(the_degree_is_the_one_that_predicts),
        cmocka_unit_test(light_is_nowhere_negative),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

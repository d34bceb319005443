// SPDX-License-Identifier: Apache-2.0
// test_gloss.c - shares of k_S by colour of texture from made highlights: paints of several glosses, one, none, outliers.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fit/gloss_fit.h"
#include "support.h"

enum { N = 6000, VIEWS = 8, PAINTS = 5 };

static const float paint_rgb[PAINTS][3] = {
    {0.5f, 0.1f, 0.1f}, {0.1f, 0.5f, 0.2f}, {0.6f, 0.6f, 0.5f}, {0.05f, 0.1f, 0.4f}, {0.3f, 0.25f, 0.1f}};

typedef struct made {
    sheen_lamp_samples samples;
    float predicted[N];
} made;

// Light on the paint differs by a factor of two; `outliers` is the share of samples that are something else.
static void make(made *m, const double share[PAINTS], double outliers)
{
    uint64_t seed = 9;
    m->samples = (sheen_lamp_samples){.at = calloc(N, sizeof *m->samples.at), .count = N, .n_views = VIEWS};
    assert_non_null(m->samples.at);
    for (size_t i = 0; i < N; i++) {
        sheen_lamp_sample *s = &m->samples.at[i];
        const size_t paint = i % PAINTS;
        const double light = 0.7 + 0.7 * test_random(&seed), highlight = 0.8 * test_random(&seed);
        for (int c = 0; c < 3; c++)
            s->texture_root[c] = sqrtf((float)light * paint_rgb[paint][c]);
        m->predicted[i] = (float)highlight;
        s->view = (uint32_t)(i / PAINTS % VIEWS);
        s->Y = (float)(share[paint] * highlight + 0.005 * test_random_normal(&seed));
        if (test_random(&seed) < outliers)
            s->Y += 0.5f;
    }
}

static double gloss_of(const sheen_gloss *g, int paint, float light)
{
    float rgb[3];
    for (int c = 0; c < 3; c++)
        rgb[c] = light * paint_rgb[paint][c];
    return (double)sheen_gloss_at(g, rgb);
}

static void paints_of_several_glosses(void **state)
{
    (void)state;
    static const double share[PAINTS] = {1, 0.5, 0.2, 0.5, 0};
    for (int spoiled = 0; spoiled < 2; spoiled++) {
        made m;
        sheen_gloss g;
        sheen_err err;
        double strength;
        make(&m, share, spoiled ? 0.1 : 0);
        assert_ok(sheen_gloss_fit(&g, &strength, &m.samples, m.predicted, 0.01, false, &err), err);
        for (int paint = 0; paint < PAINTS; paint++)
            for (float light = 0.8f; light < 1.4f; light += 0.25f)
                assert_close(strength * gloss_of(&g, paint, light), share[paint], 0.05);
        assert_close(strength, 1, 0.05); // the largest share is 1
        sheen_lamp_samples_release(&m.samples);
    }
}

static void one_gloss_stays_one(void **state)
{
    (void)state;
    static const double share[PAINTS] = {0.7, 0.7, 0.7, 0.7, 0.7};
    made m;
    sheen_gloss g;
    sheen_err err;
    double strength;
    make(&m, share, 0.05);
    assert_ok(sheen_gloss_fit(&g, &strength, &m.samples, m.predicted, 0.01, false, &err), err);
    assert_int_equal(g.n, 0);
    assert_close(gloss_of(&g, 1, 1), 1, 0);
    assert_close(strength, 1, 0);
    memset(m.predicted, 0, sizeof m.predicted); // no highlight anywhere
    assert_ok(sheen_gloss_fit(&g, &strength, &m.samples, m.predicted, 0.01, false, &err), err);
    assert_int_equal(g.n, 0);
    sheen_lamp_samples_release(&m.samples);
}

// What colours predict better by less than a fifth is not believed of an object that turned.
static void errors_of_albedo_are_no_gloss(void **state)
{
    (void)state;
    static const double alike[PAINTS] = {1, 0.992, 1, 0.992, 1}, several[PAINTS] = {1, 0.5, 0.2, 0.5, 0};
    made m;
    sheen_gloss g;
    sheen_err err;
    double strength;
    make(&m, alike, 0);
    assert_ok(sheen_gloss_fit(&g, &strength, &m.samples, m.predicted, 0.01, false, &err), err);
    assert_true(g.n > 1);
    assert_ok(sheen_gloss_fit(&g, &strength, &m.samples, m.predicted, 0.01, true, &err), err);
    assert_int_equal(g.n, 0);
    sheen_lamp_samples_release(&m.samples);
    make(&m, several, 0);
    assert_ok(sheen_gloss_fit(&g, &strength, &m.samples, m.predicted, 0.01, true, &err), err);
    for (int paint = 0; paint < PAINTS; paint++)
        assert_close(strength * gloss_of(&g, paint, 1), several[paint], 0.05);
    sheen_lamp_samples_release(&m.samples);
}

static void weights_are_those_of_the_formula(void **state)
{
    (void)state;
    const sheen_gloss g = {2, 0.1f, {{0.2f, 0.3f, 0.4f}, {0.4f, 0.3f, 0.4f}}, {1, 0.25f}};
    const float at[3] = {0.25f * 0.25f, 0.09f, 0.16f}, far[3] = {100, 100, 100};
    const double a = exp(-0.05 * 0.05 / 0.02), b = exp(-0.15 * 0.15 / 0.02);
    assert_close((double)sheen_gloss_at(&g, at), (a + 0.25 * b) / (a + b), 1e-6);
    assert_true(isfinite(sheen_gloss_at(&g, far)));
    const float root[3] = {0.25f, 0.3f, 0.4f};
    assert_close((double)sheen_gloss_at_root(&g, root), (double)sheen_gloss_at(&g, at), 1e-6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(paints_of_several_glosses),
        cmocka_unit_test(one_gloss_stays_one),
        cmocka_unit_test(errors_of_albedo_are_no_gloss),
        cmocka_unit_test(weights_are_those_of_the_formula),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// SPDX-License-Identifier: Apache-2.0
// test_turned.c - the steps for an object that turned, where nothing turned: they reduce to the paper's model. Photographs of a
// camera in the hand, one frame for the lights: there is one diffuse colour a texel, and E of irradiance.h is 1.
#include <math.h>
#include <string.h>

#include "fit/method.h"
#include "tests/fit/exact_score.h"
#include "tests/support.h"

static void fit(sheen_paper_fit *f, exact_score *e, exact_scene *s, sheen_fit_method method,
                sheen_moving moving)
{
    sheen_err err;
    const sheen_paper_options o = {
        .keep_poses = true, .keep_exposures = true, .max_samples = 3000, .frequency = 24};
    assert_ok(sheen_fit_make(f, method, moving, &s->mesh, &s->inputs, &o, &err), err);
    exact_score_model(e, s, &f->model);
    exact_score_print(stdout, moving == SHEEN_MOVING_OBJECT ? "as if turned" : "in the hand",
                      sheen_fit_method_name(method), e);
}

static double most_departure_from_1(const sheen_irradiance *e)
{
    double most = 0;
    uint64_t seed = 3;
    for (int i = 0; i < 500; i++) {
        float n[3], rgb[3];
        double sum[3];
        for (int k = 0; k < 3; k++)
            n[k] = (float)test_random_normal(&seed);
        const float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (int k = 0; k < 3; k++)
            n[k] /= length;
        sheen_irradiance_ambient(rgb, e, n);
        for (int c = 0; c < 3; c++) {
            sum[c] = (double)rgb[c];
            for (int j = 0; j < e->n_lamps; j++) {
                const float *l = e->lamps[j].l_world;
                sum[c] += e->lamps[j].rgb[c] * (double)fmaxf(0, n[0] * l[0] + n[1] * l[1] + n[2] * l[2]);
            }
            most = fmax(most, fabs(sum[c] - 1));
        }
    }
    return most;
}

static void where_nothing_turned_it_is_the_papers_model(void **state)
{
    (void)state;
    exact_options o;
    exact_scene s;
    exact_score turned, paper;
    sheen_paper_fit as_turned, in_hand;
    assert_true(exact_scene_options(&o, "far", 17));
    o.size = 0.25;
    o.n_inputs = 6;
    o.n_tests = 1;
    exact_scene_make(&s, &o);
    exact_score_print_heading(stdout);
    fit(&in_hand, &paper, &s, SHEEN_FIT_PAPER, SHEEN_MOVING_CAMERA);
    fit(&as_turned, &turned, &s, SHEEN_FIT_REFINED, SHEEN_MOVING_OBJECT);
    assert_true(most_departure_from_1(&as_turned.model.irradiance) < 1e-3);
    assert_true(turned.composite_db > paper.composite_db - 1);
    sheen_paper_fit_release(&in_hand);
    sheen_paper_fit_release(&as_turned);
    exact_scene_release(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(where_nothing_turned_it_is_the_papers_model)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// SPDX-License-Identifier: Apache-2.0
// test_recorded.c - hand-held sessions come out as they were recorded to: what is done for turned objects, or for anything
// else, does not change them unnoticed. Who changes them on purpose records the new figures, which this prints, and says why.
#include <math.h>

#include "fit/method.h"
#include "support.h"
#include "tests/fit/exact_score.h"

// Of each fit. Tolerances are those of another compiler's arithmetic, not of another method.
typedef struct recorded {
    const char *scene;
    uint64_t seed;
    sheen_fit_method method;
    double sigma_rad;
    size_t n_lamps;
    double specular_db, composite_db;
} recorded;

static const recorded fits[] = {
    {"far", 41, SHEEN_FIT_PAPER, 0.031123, 0, 30.01, 28.48},
    {"far", 41, SHEEN_FIT_REFINED, 0.029876, 6, 67.19, 34.61},
    {"near", 42, SHEEN_FIT_REFINED, 0.029774, 6, 65.66, 34.87},
    {"everything", 43, SHEEN_FIT_REFINED, 0.034820, 6, 40.82, 34.47},
};

static void a_camera_in_the_hand_gives_what_it_gave(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof fits / sizeof *fits; i++) {
        const recorded *r = &fits[i];
        const sheen_paper_options fo = {0};
        exact_options o;
        exact_scene s;
        exact_score e;
        sheen_paper_fit f;
        sheen_err err;
        assert_true(exact_scene_options(&o, r->scene, r->seed));
        o.size = 0.25;
        o.n_inputs = 6;
        o.n_tests = 2;
        exact_scene_make(&s, &o);
        assert_ok(sheen_fit_make(&f, r->method, SHEEN_MOVING_CAMERA, &s.mesh, &s.inputs, &fo, &err), err);
        exact_score_model(&e, &s, &f.model);
        print_message("{\"%s\", %d, %s, %.6f, %zu, %.2f, %.2f},\n", r->scene, (int)r->seed,
                      sheen_fit_method_name(r->method), f.model.sigma_rad, f.model.n_lamps, e.specular_db,
                      e.composite_db);
        assert_false(f.model.irradiance.present); // one light frame: the texture holds its light
        assert_int_equal(f.model.n_lamps, r->n_lamps);
        assert_close(f.model.sigma_rad / r->sigma_rad, 1, 0.01);
        assert_close(e.specular_db, r->specular_db, 0.4);
        assert_close(e.composite_db, r->composite_db, 0.15);
        sheen_paper_fit_release(&f);
        exact_scene_release(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_camera_in_the_hand_gives_what_it_gave)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

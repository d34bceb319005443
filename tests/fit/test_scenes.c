// SPDX-License-Identifier: Apache-2.0
// test_scenes.c - what each method must reach on exact scenes; bench_scenes prints the whole table.
#include "fit/method.h"
#include "support.h"
#include "tests/fit/exact_score.h"

static void fit(exact_score *out, const char *scene, uint64_t seed, sheen_fit_method method)
{
    exact_options o;
    exact_scene s;
    sheen_paper_fit f;
    sheen_err err;
    const sheen_paper_options fo = {0};
    assert_true(exact_scene_options(&o, scene, seed));
    exact_scene_make(&s, &o);
    assert_ok(sheen_fit_make(&f, method, SHEEN_MOVING_CAMERA, &s.mesh, &s.inputs, &fo, &err), err);
    exact_score_model(out, &s, &f.model);
    exact_score_print_heading(stdout);
    exact_score_print(stdout, scene, sheen_fit_method_name(method), out);
    sheen_paper_fit_release(&f);
    exact_scene_release(&s);
}

// Far lights, and sigma started above the truth: the paper's own ground.
static void the_paper_on_its_own_ground(void **state)
{
    (void)state;
    for (uint64_t seed = 11; seed < 14; seed++) {
        exact_score e;
        fit(&e, "far", seed, SHEEN_FIT_PAPER);
        assert_close(e.sigma_error, 0, 0.12);
        assert_int_equal(e.n_found, EXACT_LIGHTS);
        assert_true(e.direction_deg < 0.2);
        assert_true(e.specular_db > 52);
        assert_true(e.composite_db > e.true_specular_db - 0.5);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_paper_on_its_own_ground),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

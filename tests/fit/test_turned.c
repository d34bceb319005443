// SPDX-License-Identifier: Apache-2.0
// test_turned.c - an object that turned under its lights, fitted by the same code as one that stood still.
//
// Where nothing turned (photographs of a camera in the hand, one frame for the lights) the steps for turned objects find a light of
// 1 everywhere and the same model; where it did, the lamps are found as in the hand, with one height of the camera or two.
#include <math.h>
#include <string.h>

#include "fit/method.h"
#include "tests/fit/exact_score.h"
#include "tests/support.h"

static void fit(sheen_paper_fit *f, exact_score *e, exact_scene *s, sheen_fit_method method,
                sheen_moving moving)
{
    sheen_err err;
    const sheen_paper_options o = {.keep_poses = true,
                                   .keep_exposures = true,
                                   .max_samples = 3000,
                                   .without = 1u << SHEEN_EXTENSION_NORMALS,
                                   .frequency = method == SHEEN_FIT_PAPER ? 24 : 0};
    assert_ok(sheen_fit_make(f, method, moving, &s->mesh, &s->inputs, &o, &err), err);
    exact_score_model(e, s, &f->model);
    exact_score_print(stdout, moving == SHEEN_MOVING_OBJECT ? "turned" : "in the hand",
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

static void make(exact_scene *s, const char *name, uint64_t seed, double size, size_t n_inputs,
                 size_t n_heights)
{
    exact_options o;
    assert_true(exact_scene_options(&o, name, seed));
    o.size = size;
    o.n_inputs = n_inputs;
    o.n_tests = 2;
    o.n_heights = n_heights;
    exact_scene_make(s, &o);
}

// Root mean square difference of two textures of the same photographs.
static double texture_difference(const sheen_texture *a, const sheen_texture *b)
{
    const size_t n = a->n_triangles * sheen_texels_per_triangle(a->texels_per_edge);
    double sum = 0;
    size_t count = 0;
    assert_int_equal(a->texels_per_edge, b->texels_per_edge);
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < 3 && a->n_views[i] > 1; c++, count++)
            sum += pow((double)(a->rgb[3 * i + c] - b->rgb[3 * i + c]), 2);
    return sqrt(sum / (double)count);
}

static void where_nothing_turned_it_is_the_papers_model(void **state)
{
    (void)state;
    exact_scene s;
    exact_score turned, still, paper;
    sheen_paper_fit as_turned, in_hand, literal;
    make(&s, "far", 17, 0.25, 6, 0);
    exact_score_print_heading(stdout);
    fit(&literal, &paper, &s, SHEEN_FIT_PAPER, SHEEN_MOVING_CAMERA);
    fit(&in_hand, &still, &s, SHEEN_FIT_REFINED, SHEEN_MOVING_CAMERA);
    fit(&as_turned, &turned, &s, SHEEN_FIT_REFINED, SHEEN_MOVING_OBJECT);
    const double texture = texture_difference(&as_turned.model.texture, &in_hand.model.texture);
    printf("light differs from 1 by %.2g, textures by %.2g, sigma by %.2g\n",
           most_departure_from_1(&as_turned.model.irradiance), texture,
           as_turned.model.sigma_rad / in_hand.model.sigma_rad - 1);
    assert_false(in_hand.model.irradiance.present);
    assert_true(most_departure_from_1(&as_turned.model.irradiance) < 1e-3);
    assert_int_equal(as_turned.model.n_lamps, in_hand.model.n_lamps);
    assert_close(as_turned.model.sigma_rad / in_hand.model.sigma_rad, 1, 0.015);
    assert_close(turned.composite_db, still.composite_db, 0.3);
    assert_true(texture < 0.005);
    assert_true(turned.composite_db > paper.composite_db - 1);
    sheen_paper_fit_release(&literal);
    sheen_paper_fit_release(&in_hand);
    sheen_paper_fit_release(&as_turned);
    exact_scene_release(&s);
}

// Twelve steps of a table, and the same object and lights photographed eight times by hand.
static void lamps_are_found_as_in_the_hand(void **state)
{
    (void)state;
    static const char *const names[] = {"far", "near"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        exact_scene in_hand, on_table;
        exact_score hand, table;
        sheen_paper_fit f;
        make(&in_hand, names[i], 1, 0.25, 8, 0);
        make(&on_table, names[i], 1, 0.25, 12, 1);
        fit(&f, &hand, &in_hand, SHEEN_FIT_REFINED, SHEEN_MOVING_CAMERA);
        sheen_paper_fit_release(&f);
        fit(&f, &table, &on_table, SHEEN_FIT_REFINED, SHEEN_MOVING_OBJECT);
        assert_int_equal(table.n_found, EXACT_LIGHTS);
        assert_int_equal(f.model.n_lamps, EXACT_LIGHTS);
        assert_true(table.direction_deg < 0.2);
        assert_true(table.specular_db > 50);
        assert_true(table.composite_db > table.true_specular_db - 0.3);
        assert_true(table.composite_db > hand.composite_db - 1);
        // One height: 0.2 to 0.9 % low on near, seeds 1 to 5 (bench_scenes --turned 1 --views 12)
        assert_true(fabs(table.sigma_error) < 0.012);
        sheen_paper_fit_release(&f);
        exact_scene_release(&in_hand);
        exact_scene_release(&on_table);
    }
}

// Six steps, the camera put 20 degrees higher, and six steps more: one object, one set of lights in the world.
static void two_heights_are_one_fit(void **state)
{
    (void)state;
    exact_scene s;
    exact_score e;
    sheen_paper_fit f;
    make(&s, "near", 3, 0.25, 12, 2);
    fit(&f, &e, &s, SHEEN_FIT_REFINED, SHEEN_MOVING_OBJECT);
    assert_int_equal(e.n_found, EXACT_LIGHTS);
    assert_true(e.direction_deg < 0.2);
    assert_true(e.distance_error < 0.05);
    assert_true(e.specular_db > 48);
    assert_true(e.composite_db > e.true_specular_db - 0.3);
    assert_true(fabs(e.sigma_error) < 0.08);
    sheen_paper_fit_release(&f);
    exact_scene_release(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(where_nothing_turned_it_is_the_papers_model),
                                       cmocka_unit_test(lamps_are_found_as_in_the_hand),
                                       cmocka_unit_test(two_heights_are_one_fit)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

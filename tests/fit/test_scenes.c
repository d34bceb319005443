// SPDX-License-Identifier: Apache-2.0
// test_scenes.c - what each method must reach on exact scenes; bench_scenes prints the whole table.
#include "fit/method.h"
#include "support.h"
#include "tests/fit/exact_score.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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

// The lamps there are and no others, where a texel is wider than the paint's edges and misplaced paint looks like highlights.
static void no_lamp_too_few_or_too_many(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        uint64_t seed;
        double size, specular_db;
    } cases[] = {
        {"far", 1, 0.33, 60},         {"near", 21, 0.4, 60},     {"discs", 22, 0.4, 55},
        {"sigma-.0114", 23, 0.4, 60}, {"sigma-.1", 2, 0.33, 60}, // whose wide highlights poses were moved for
        {"sigma-.1", 5, 0.33, 60}, // which one lobe for all lamps nearly explains
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        exact_options o;
        exact_scene s;
        exact_score e;
        sheen_paper_fit f;
        sheen_err err;
        const sheen_paper_options fo = {0};
        assert_true(exact_scene_options(&o, cases[i].name, cases[i].seed));
        o.size = cases[i].size;
        exact_scene_make(&s, &o);
        assert_ok(sheen_fit_make(&f, SHEEN_FIT_REFINED, SHEEN_MOVING_CAMERA, &s.mesh, &s.inputs, &fo, &err),
                  err);
        exact_score_model(&e, &s, &f.model);
        exact_score_print(stdout, cases[i].name, "refined", &e);
        assert_int_equal(e.n_found, EXACT_LIGHTS);
        assert_int_equal(f.model.n_lamps, EXACT_LIGHTS);
        assert_close(e.sigma_error, 0, 0.06);
        assert_true(e.specular_db > cases[i].specular_db);
        assert_true(e.composite_db > e.true_specular_db - 0.5);
        sheen_paper_fit_release(&f);
        exact_scene_release(&s);
    }
}

// Nothing shines: no lamp, or hardly any light, and photographs predicted no worse than by the minimum texture.
static void a_matte_object_gets_no_highlights(void **state)
{
    (void)state;
    exact_options o;
    exact_scene s;
    exact_score e[2];
    sheen_err err;
    assert_true(exact_scene_options(&o, "matte", 31));
    o.size = 0.33;
    exact_scene_make(&s, &o);
    for (int i = 0; i < 2; i++) {
        sheen_paper_fit f;
        const sheen_paper_options fo = {.stop_after = i ? SHEEN_PAPER_TEXTURE : SHEEN_PAPER_ALL};
        assert_ok(sheen_fit_make(&f, i ? SHEEN_FIT_PAPER : SHEEN_FIT_REFINED, SHEEN_MOVING_CAMERA, &s.mesh,
                                 &s.inputs, &fo, &err),
                  err);
        if (i)
            f.model.sigma_rad = 0.1; // of no light
        exact_score_model(&e[i], &s, &f.model);
        exact_score_print(stdout, i ? "minimum" : "matte", "", &e[i]);
        if (!i)
            print_message("%zu lamps, k_S %.4f, surroundings %d\n", f.model.n_lamps, f.model.k_s,
                          f.model.surroundings.present);
        sheen_paper_fit_release(&f);
    }
    assert_true(e[0].specular_db > 55);
    assert_true(e[0].composite_db >= e[1].composite_db);
    exact_scene_release(&s);
}

// Darkens a round spot of each photograph by a share, elsewhere in each: the shadow of who took it. Less than 0: a torch's beam.
static void pass_shadows(sheen_photos *photos, double share)
{
    for (size_t v = 0; v < photos->count; v++) {
        sheen_image *image = &photos->photos[v].image;
        const double turn = 2.4 * (double)v, h = image->height_px;
        const double x0 = 0.5 * image->width_px + 0.2 * h * cos(turn), y0 = h * (0.5 + 0.2 * sin(turn));
        for (int y = 0; y < image->height_px; y++)
            for (int x = 0; x < image->width_px; x++) {
                const double d2 = ((x - x0) * (x - x0) + (y - y0) * (y - y0)) / (0.12 * 0.12 * h * h);
                const float left = (float)(1 - share / (1 + exp(20 * (sqrt(d2) - 1))));
                for (int c = 0; c < 3; c++)
                    sheen_image_at(image, x, y)[c] *= left;
            }
    }
}

// What moves between photographs of a matte object need be no highlight: the texture alone does no better than the model.
static void passing_shadows_are_no_highlights(void **state)
{
    (void)state;
    static const double shares[] = {0.6, -0.5, -1.5};
    for (size_t i = 0; i < sizeof shares / sizeof *shares; i++) {
        exact_options o;
        exact_scene s;
        exact_score e;
        sheen_paper_fit f;
        sheen_err err;
        const sheen_paper_options fo = {0};
        assert_true(exact_scene_options(&o, "matte", 33));
        o.size = 0.25;
        exact_scene_make(&s, &o);
        pass_shadows(&s.inputs, shares[i]);
        assert_ok(sheen_fit_make(&f, SHEEN_FIT_REFINED, SHEEN_MOVING_CAMERA, &s.mesh, &s.inputs, &fo, &err),
                  err);
        exact_score_model(&e, &s, &f.model);
        exact_score_print(stdout, "shadows", "refined", &e);
        print_message("%zu lamps, k_S %.4f, surroundings %d, refuted %d\n", f.model.n_lamps, f.model.k_s,
                      f.model.surroundings.present, f.lights_refuted);
        assert_true(e.composite_db >= e.true_specular_db - 0.1);
        sheen_paper_fit_release(&f);
        exact_scene_release(&s);
    }
}

// White is a lower bound: lamps whose highlights are cut off at 1 to 5 % of the object's pixels are as strong as they are.
static void clipped_highlights_keep_their_lamps(void **state)
{
    (void)state;
    exact_options o;
    exact_scene s;
    exact_score e;
    sheen_paper_fit f;
    sheen_err err;
    const sheen_paper_options fo = {0};
    assert_true(exact_scene_options(&o, "saturated", 42));
    o.brightness = 60;
    o.size = 0.33;
    exact_scene_make(&s, &o);
    assert_ok(sheen_fit_make(&f, SHEEN_FIT_REFINED, SHEEN_MOVING_CAMERA, &s.mesh, &s.inputs, &fo, &err), err);
    exact_score_model(&e, &s, &f.model);
    exact_score_print(stdout, "saturated", "refined", &e);
    print_message("%.1f %% of the pixels clipped\n", 100 * s.clipped_share);
    assert_true(s.clipped_share > 0.01 && s.clipped_share < 0.05);
    assert_int_equal(e.n_found, EXACT_LIGHTS);
    assert_true(e.strength_error < 0.08);
    assert_true(e.specular_db > 59);
    sheen_paper_fit_release(&f);
    exact_scene_release(&s);
}

// Mean luminance of the texels that were seen.
static double mean_luminance(const sheen_texture *t)
{
    const size_t n_texels = t->n_triangles * sheen_texels_per_triangle(t->texels_per_edge);
    double sum = 0;
    size_t n = 0;
    for (size_t i = 0; i < n_texels; i++)
        if (t->n_views[i]) {
            sum += (double)sheen_luminance(t->rgb + 3 * i);
            n++;
        }
    return n ? sum / (double)n : 0;
}

// What every photograph shows of a metal is light reflected at its surface: none of it is the base's.
static void a_metal_has_no_base(void **state)
{
    (void)state;
    exact_options o;
    exact_scene s;
    exact_score e;
    double base[2];
    sheen_err err;
    assert_true(exact_scene_options(&o, "metal", 32));
    o.size = 0.33;
    exact_scene_make(&s, &o);
    for (int i = 0; i < 2; i++) {
        sheen_paper_fit f;
        const sheen_paper_options fo = {.stop_after = i ? SHEEN_PAPER_ALL : SHEEN_PAPER_TEXTURE};
        assert_ok(sheen_fit_make(&f, i ? SHEEN_FIT_REFINED : SHEEN_FIT_PAPER, SHEEN_MOVING_CAMERA, &s.mesh,
                                 &s.inputs, &fo, &err),
                  err);
        base[i] = mean_luminance(&f.model.texture);
        if (i)
            exact_score_model(&e, &s, &f.model);
        sheen_paper_fit_release(&f);
    }
    exact_score_print(stdout, "metal", "refined", &e);
    print_message("base %.4f, by the minimum %.4f\n", base[1], base[0]);
    assert_true(base[1] < 0.005);
    assert_true(e.composite_db > e.true_specular_db - 1);
    exact_scene_release(&s);
}

// Texture, lamps, gloss and surroundings of a fit with one thread and with three: the same to the bit.
static void threads_do_not_change_the_answer(void **state)
{
    (void)state;
    exact_options o;
    exact_scene s;
    sheen_paper_fit f[2];
    sheen_err err;
    assert_true(exact_scene_options(&o, "everything", 3));
    o.size = 0.2;
    exact_scene_make(&s, &o);
    sheen_photo *given = malloc(s.inputs.count * sizeof *given);
    assert_non_null(given);
    memcpy(given, s.inputs.photos, s.inputs.count * sizeof *given);
    for (int i = 0; i < 2; i++) {
        const sheen_paper_options fo = {.n_threads = i ? 3 : 1};
        memcpy(s.inputs.photos, given, s.inputs.count * sizeof *given); // the fit corrects poses
        assert_ok(
            sheen_fit_make(&f[i], SHEEN_FIT_REFINED, SHEEN_MOVING_CAMERA, &s.mesh, &s.inputs, &fo, &err),
            err);
    }
    const sheen_model *a = &f[0].model, *b = &f[1].model;
    const size_t n = a->texture.n_triangles * sheen_texels_per_triangle(a->texture.texels_per_edge);
    assert_int_equal(a->n_lamps, b->n_lamps);
    assert_true(a->n_lamps > 0);
    assert_memory_equal(a->lamps, b->lamps, a->n_lamps * sizeof *a->lamps);
    assert_memory_equal(&a->gloss, &b->gloss, sizeof a->gloss);
    assert_memory_equal(a->texture.rgb, b->texture.rgb, 3 * n * sizeof *a->texture.rgb);
    assert_close(a->sigma_rad, b->sigma_rad, 0);
    assert_close(a->lobe_tail, b->lobe_tail, 0);
    assert_close(a->surroundings.f0, b->surroundings.f0, 0);
    for (int i = 0; i < 2; i++)
        sheen_paper_fit_release(&f[i]);
    free(given);
    exact_scene_release(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_paper_on_its_own_ground),
        cmocka_unit_test(no_lamp_too_few_or_too_many),
        cmocka_unit_test(a_matte_object_gets_no_highlights),
        cmocka_unit_test(passing_shadows_are_no_highlights),
        cmocka_unit_test(clipped_highlights_keep_their_lamps),
        cmocka_unit_test(a_metal_has_no_base),
        cmocka_unit_test(threads_do_not_change_the_answer),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

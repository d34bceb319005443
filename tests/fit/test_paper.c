// SPDX-License-Identifier: Apache-2.0
// test_paper.c - the paper's method on scenes with known truth, from photographs to held-out pictures.
#include <math.h>
#include <string.h>

#include "fit/evaluate.h"
#include "fit/paper.h"
#include "photo_scene.h"
#include "support.h"

static const photo_scene_options figure = {.bumpy = 1,
                                           .width_px = 300,
                                           .height_px = 250,
                                           .n_inputs = 8,
                                           .n_tests = 2,
                                           .n_lights = 6,
                                           .sigma_rad = 0.05,
                                           .noise = 0.003};

static void report(const sheen_paper_fit *f, const sheen_evaluation *e, double sigma_rad)
{
    const sheen_score ours = sheen_evaluation_mean(e, 0),
                      least = sheen_evaluation_mean(e, 1 + SHEEN_BASELINE_MINIMUM);
    print_message(
        "sigma %.4f (%+.1f %%), nodes %zu kept, %zu lit; object %.1f dB (minimum %.1f), highlights %.1f dB "
        "(minimum %.1f)\n",
        f->refined.sigma_rad, 100 * (f->refined.sigma_rad / sigma_rad - 1), f->combined.n_assigned,
        f->refined.n_nodes_left, ours.object.srgb_db, least.object.srgb_db, ours.highlights.linear_db,
        least.highlights.linear_db);
}

static void predicts_views_it_has_not_seen(void **state)
{
    (void)state;
    photo_scene s;
    sheen_paper_fit f;
    sheen_evaluation e;
    sheen_err err;
    photo_scene_make(&s, &figure);
    const sheen_paper_options o = {.frequency = 40};
    assert_ok(sheen_paper_fit_make(&f, &s.truth.mesh, &s.inputs, &o, &err), err);
    sheen_model model = f.model;
    model.mesh = s.truth.mesh; // lent
    const sheen_evaluate_options eo = {0};
    assert_ok(sheen_evaluate(&e, &model, &s.inputs, &s.tests, NULL, &eo, &err), err);
    report(&f, &e, figure.sigma_rad);
    assert_close(f.refined.sigma_rad / figure.sigma_rad, 1, 0.12);
    assert_true(f.refined.converged);
    const sheen_score ours = sheen_evaluation_mean(&e, 0);
    for (int m = 1; m < SHEEN_EVALUATION_METHODS; m++) {
        const sheen_score other = sheen_evaluation_mean(&e, m);
        assert_true(ours.highlights.linear_db > other.highlights.linear_db + 10);
        assert_true(ours.object.srgb_db > other.object.srgb_db + 3);
    }
    assert_true(ours.object.srgb_db > 32);
    sheen_evaluation_release(&e);
    sheen_paper_fit_release(&f);
    photo_scene_release(&s);
}

// Every true light has lit nodes about it whose centre is within 0.5 degrees, and there is little anywhere else.
static void finds_the_lights(void **state)
{
    (void)state;
    photo_scene s;
    sheen_paper_fit f;
    sheen_err err;
    photo_scene_options o = figure;
    o.bumpy = 0;
    o.noise = 0;
    photo_scene_make(&s, &o);
    const sheen_paper_options po = {.frequency = 40};
    assert_ok(sheen_paper_fit_make(&f, &s.truth.mesh, &s.inputs, &po, &err), err);
    const sheen_lights *l = &f.model.lights;
    double near_lights = 0, all = 0;
    for (size_t i = 0; i < l->count; i++)
        all += (double)l->weight[i];
    for (int k = 0; k < o.n_lights; k++) {
        double v[3], c[3] = {0, 0, 0}, sum = 0;
        photo_scene_light(v, k);
        for (size_t i = 0; i < l->count; i++) {
            const double d[3] = {(double)l->dx[i], (double)l->dy[i], (double)l->dz[i]};
            if (sheen_dot(d, v) < cos(0.15))
                continue;
            sum += (double)l->weight[i];
            for (int a = 0; a < 3; a++)
                c[a] += (double)l->weight[i] * d[a];
        }
        sheen_normalize(c);
        near_lights += sum;
        assert_true(acos(fmin(1, sheen_dot(c, v))) < 0.5 * 3.14159265 / 180);
        assert_close(sum * f.model.k_s, s.truth.lights.weight[k], 0.2 * (double)s.truth.lights.weight[k]);
    }
    assert_true(near_lights > 0.97 * all);
    sheen_paper_fit_release(&f);
    photo_scene_release(&s);
}

static void threads_do_not_change_the_result(void **state)
{
    (void)state;
    photo_scene s;
    sheen_paper_fit a, b;
    sheen_err err;
    photo_scene_options o = figure;
    o.width_px = 240;
    o.height_px = 200;
    o.n_inputs = 5;
    photo_scene_make(&s, &o);
    const sheen_paper_options one = {.frequency = 24, .n_threads = 1},
                              three = {.frequency = 24, .n_threads = 3};
    assert_ok(sheen_paper_fit_make(&a, &s.truth.mesh, &s.inputs, &one, &err), err);
    assert_ok(sheen_paper_fit_make(&b, &s.truth.mesh, &s.inputs, &three, &err), err);
    assert_true(a.refined.sigma_rad == b.refined.sigma_rad);
    assert_true(a.refined.k_s == b.refined.k_s);
    assert_int_equal(a.model.lights.count, b.model.lights.count);
    assert_memory_equal(a.model.radiance, b.model.radiance, a.model.lights.count * sizeof(float));
    const size_t n = a.model.texture.n_triangles * sheen_texels_per_triangle(a.model.texture.texels_per_edge);
    assert_memory_equal(a.model.texture.rgb, b.model.texture.rgb, 3 * n * sizeof(float));
    sheen_paper_fit_release(&a);
    sheen_paper_fit_release(&b);
    photo_scene_release(&s);
}

// The texture is the diffuse part: the minimum lies at most a little noise below it, and above it only where every
// view that sees a texel sees a highlight there.
static void texture_is_the_diffuse_part(void **state)
{
    (void)state;
    photo_scene s;
    sheen_paper_fit f;
    sheen_err err;
    photo_scene_options o = figure;
    o.bumpy = 0;
    o.noise = 0;
    photo_scene_make(&s, &o);
    const sheen_paper_options po = {.frequency = 20, .texels_per_edge = 5};
    assert_ok(sheen_paper_fit_make(&f, &s.truth.mesh, &s.inputs, &po, &err), err);
    const sheen_texture *got = &f.model.texture, *want = &s.truth.texture;
    const size_t n = want->n_triangles * sheen_texels_per_triangle(5);
    size_t n_often = 0, n_close = 0;
    for (size_t i = 0; i < n; i++) {
        if (got->n_views[i] < 3)
            continue;
        const float d = sheen_luminance(got->rgb + 3 * i) - sheen_luminance(want->rgb + 3 * i);
        assert_true(d > -0.02f);
        n_often++;
        n_close += d < 0.02f;
    }
    print_message("%zu texels seen 3 times or more, %.2f %% within 0.02 of the truth\n", n_often,
                  100 * (double)n_close / (double)n_often);
    assert_true(n_often > n / 4);
    assert_true((double)n_close > 0.97 * (double)n_often);
    sheen_paper_fit_release(&f);
    photo_scene_release(&s);
}

static void says_what_is_missing(void **state)
{
    (void)state;
    photo_scene s;
    sheen_paper_fit f;
    sheen_err err;
    photo_scene_options o = figure;
    o.width_px = 240;
    o.height_px = 200;
    o.n_lights = 0;
    o.noise = 0.002;
    photo_scene_make(&s, &o);
    const sheen_paper_options po = {.frequency = 20};
    assert_fails(sheen_paper_fit_make(&f, &s.truth.mesh, &s.inputs, &po, &err), err, SHEEN_EDATA,
                 "no highlight");
    const size_t n = s.inputs.count;
    s.inputs.count = 1;
    assert_fails(sheen_paper_fit_make(&f, &s.truth.mesh, &s.inputs, &po, &err), err, SHEEN_EDATA, "too few");
    s.inputs.count = 0;
    assert_fails(sheen_paper_fit_make(&f, &s.truth.mesh, &s.inputs, &po, &err), err, SHEEN_EDATA, "too few");
    s.inputs.count = n;
    for (size_t i = 0; i < n; i++)
        s.inputs.photos[i].rt_cam_obj[5] -= 5; // behind the camera
    assert_fails(sheen_paper_fit_make(&f, &s.truth.mesh, &s.inputs, &po, &err), err, SHEEN_EDATA,
                 "no photograph sees any part of the mesh");
    photo_scene_release(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(predicts_views_it_has_not_seen),
        cmocka_unit_test(finds_the_lights),
        cmocka_unit_test(threads_do_not_change_the_result),
        cmocka_unit_test(texture_is_the_diffuse_part),
        cmocka_unit_test(says_what_is_missing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

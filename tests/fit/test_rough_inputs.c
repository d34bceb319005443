// SPDX-License-Identifier: Apache-2.0
// test_rough_inputs.c - meshes and sets of photographs as they come: the fit holds, or says what is wrong.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/mesh_repair.h"
#include "fit/method.h"
#include "support.h"
#include "support_scene.h"
#include "tests/fit/exact_score.h"

static void make(exact_scene *s, size_t n_inputs)
{
    exact_options o;
    assert_true(exact_scene_options(&o, "far", 21));
    o.sigma_rad = 0.05;
    o.size = 0.3;
    o.n_inputs = n_inputs;
    o.n_tests = 1;
    exact_scene_make(s, &o);
}

static void score(exact_score *e, exact_scene *s, const char *what, sheen_fit_method method)
{
    sheen_paper_fit f;
    sheen_err err;
    const sheen_paper_options o = {.frequency = 40};
    assert_ok(sheen_fit_make(&f, method, SHEEN_MOVING_CAMERA, &s->mesh, &s->inputs, &o, &err), err);
    exact_score_model(e, s, &f.model);
    exact_score_print(stdout, what, sheen_fit_method_name(method), e);
    sheen_paper_fit_release(&f);
}

static void turn(sheen_mesh *mesh, size_t triangle)
{
    uint32_t *c = mesh->triangles + 3 * triangle;
    const uint32_t second = c[1];
    c[1] = c[2];
    c[2] = second;
}

// A fifth of the faces turned, some twice there, some gone, normals pointing anywhere: mended, all but the holes is as good as new.
static void a_damaged_mesh_is_as_good_as_new(void **state)
{
    (void)state;
    exact_scene s;
    exact_score good, mended;
    sheen_mesh_repairs r;
    sheen_err err;
    uint64_t seed = 4;
    make(&s, 6);
    score(&good, &s, "as it should be", SHEEN_FIT_PAPER);
    const size_t n = s.mesh.n_triangles, n_double = n / 10, n_gone = n / 50;
    s.mesh.triangles = realloc(s.mesh.triangles, 3 * (n + n_double) * sizeof *s.mesh.triangles);
    assert_non_null(s.mesh.triangles);
    memcpy(s.mesh.triangles + 3 * n, s.mesh.triangles, 3 * n_double * sizeof *s.mesh.triangles);
    s.mesh.n_triangles = n + n_double;
    for (size_t t = 0; t < s.mesh.n_triangles; t += 5)
        turn(&s.mesh, t);
    for (size_t i = 0; i < n_gone; i++)
        memcpy(s.mesh.triangles + 3 * (n / 2 + i), s.mesh.triangles,
               3 * sizeof *s.mesh.triangles); // doubles of the first
    for (size_t v = 0; v < s.mesh.n_vertices; v++)
        test_direction(s.mesh.n_obj + 3 * v, &seed);
    assert_ok(sheen_mesh_repair(&r, &s.mesh, &err), err);
    assert_true(r.n_doubles >= n_double + n_gone - 1 && r.n_turned > n / 10);
    score(&mended, &s, "damaged and mended", SHEEN_FIT_PAPER);
    assert_true(mended.specular_db > good.specular_db - 3);
    assert_true(mended.composite_db > good.composite_db - 1);
    exact_scene_release(&s);
}

// A hull of 500 triangles: its normals are degrees off, and the paper's method takes every misplaced edge of the paint for a
// highlight. It must end, with finite numbers; that they are good nobody can ask.
static void a_coarse_mesh_is_fitted(void **state)
{
    (void)state;
    exact_scene s;
    exact_score e;
    make(&s, 6);
    sheen_mesh_release(&s.mesh);
    test_figure(&s.mesh, 5, 0.078f, 0.024f);
    assert_int_equal(s.mesh.n_triangles, 500);
    for (int m = 0; m < SHEEN_FIT_METHOD_COUNT; m++) {
        score(&e, &s, "500 triangles", (sheen_fit_method)m);
        assert_true(isfinite(e.composite_db) && e.composite_db > 15);
    }
    exact_scene_release(&s);
}

static void three_photographs_and_some_masks(void **state)
{
    (void)state;
    exact_scene s;
    exact_score e;
    sheen_err err;
    make(&s, 3);
    sheen_image *mask = &s.inputs.photos[1].mask;
    assert_ok(sheen_image_init(mask, s.inputs.cam.width_px, s.inputs.cam.height_px, 1, &err), err);
    for (size_t i = 0; i < (size_t)mask->width_px * (size_t)mask->height_px; i++)
        mask->data[i] = 1;
    for (int m = 0; m < SHEEN_FIT_METHOD_COUNT; m++) {
        score(&e, &s, "three photographs", (sheen_fit_method)m);
        assert_true(isfinite(e.composite_db) && e.composite_db > 15);
    }
    exact_scene_release(&s);
}

// The mesh of another object, or one that stands elsewhere.
static void a_wrong_mesh_is_said_or_survived(void **state)
{
    (void)state;
    exact_scene s;
    sheen_paper_fit f;
    sheen_err err = {0};
    const sheen_paper_options o = {.frequency = 20};
    make(&s, 4);
    for (size_t i = 0; i < 3 * s.mesh.n_vertices; i++)
        s.mesh.p_obj[i] = 0.4f * s.mesh.p_obj[i] + (i % 3 == 0 ? 5.0f : 0.0f);
    for (int m = 0; m < SHEEN_FIT_METHOD_COUNT; m++)
        assert_fails(
            sheen_fit_make(&f, (sheen_fit_method)m, SHEEN_MOVING_CAMERA, &s.mesh, &s.inputs, &o, &err), err,
            SHEEN_EDATA, "no photograph sees any part of the mesh");
    exact_scene_release(&s);
}

static void fit_refined(sheen_paper_fit *f, exact_scene *s, int n_threads)
{
    sheen_err err;
    const sheen_paper_options o = {.keep_poses = true, .keep_exposures = true, .n_threads = n_threads};
    assert_ok(sheen_fit_make(f, SHEEN_FIT_REFINED, SHEEN_MOVING_CAMERA, &s->mesh, &s->inputs, &o, &err), err);
}

// The strongest lamp's light, roughness and a texel in a hundred.
static double difference(const sheen_model *a, const sheen_model *b)
{
    const size_t n = a->texture.n_triangles * sheen_texels_per_triangle(a->texture.texels_per_edge);
    double worst = fabs(a->sigma_rad / b->sigma_rad - 1) + fabs(a->k_s / b->k_s - 1);
    assert_int_equal(a->texture.texels_per_edge, b->texture.texels_per_edge);
    for (size_t i = 0; i < 3 * n; i += 100)
        worst = fmax(worst, fabs((double)a->texture.rgb[i] - (double)b->texture.rgb[i]));
    return worst;
}

static void threads_and_order_do_not_matter(void **state)
{
    (void)state;
    exact_scene s;
    sheen_paper_fit one, two, turned;
    make(&s, 5);
    fit_refined(&one, &s, 1);
    fit_refined(&two, &s, 3);
    assert_true(difference(&one.model, &two.model) == 0);
    for (size_t i = 0; i < s.inputs.count / 2; i++) {
        const sheen_photo first = s.inputs.photos[i];
        s.inputs.photos[i] = s.inputs.photos[s.inputs.count - 1 - i];
        s.inputs.photos[s.inputs.count - 1 - i] = first;
    }
    fit_refined(&turned, &s, 2);
    const double d = difference(&one.model, &turned.model);
    printf("photographs in another order: sigma, k_S or a texel differ by %.2g\n", d);
    assert_true(d < 0.02); // samples are drawn in their order: others are looked at
    assert_int_equal(one.model.n_lamps, turned.model.n_lamps);
    sheen_paper_fit_release(&one);
    sheen_paper_fit_release(&two);
    sheen_paper_fit_release(&turned);
    exact_scene_release(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_damaged_mesh_is_as_good_as_new),
        cmocka_unit_test(a_coarse_mesh_is_fitted),
        cmocka_unit_test(three_photographs_and_some_masks),
        cmocka_unit_test(a_wrong_mesh_is_said_or_survived),
        cmocka_unit_test(threads_and_order_do_not_matter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

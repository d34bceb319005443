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

static void score(exact_score *e, exact_scene *s, const char *what)
{
    sheen_paper_fit f;
    sheen_err err;
    const sheen_paper_options o = {.frequency = 40};
    assert_ok(sheen_fit_make(&f, SHEEN_FIT_PAPER, SHEEN_MOVING_CAMERA, &s->mesh, &s->inputs, &o, &err), err);
    exact_score_model(e, s, &f.model);
    exact_score_print(stdout, what, "paper", e);
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
    score(&good, &s, "as it should be");
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
    score(&mended, &s, "damaged and mended");
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
    score(&e, &s, "500 triangles");
    assert_true(isfinite(e.composite_db) && e.composite_db > 15);
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
    score(&e, &s, "three photographs");
    assert_true(isfinite(e.composite_db) && e.composite_db > 15);
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
    assert_fails(sheen_fit_make(&f, SHEEN_FIT_PAPER, SHEEN_MOVING_CAMERA, &s.mesh, &s.inputs, &o, &err), err,
                 SHEEN_EDATA, "no photograph sees any part of the mesh");
    exact_scene_release(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_damaged_mesh_is_as_good_as_new),
        cmocka_unit_test(a_coarse_mesh_is_fitted),
        cmocka_unit_test(three_photographs_and_some_masks),
        cmocka_unit_test(a_wrong_mesh_is_said_or_survived),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// SPDX-License-Identifier: Apache-2.0
// test_normals.c - normals that the mesh has wrong come right by highlights, and by shading where the object turned; normals that are right
// stay as they are.
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "fit/method.h"
#include "fit/normal_grid.h"
#include "tests/fit/exact_score.h"
#include "tests/support.h"
#include "tests/support_scene.h"

static exact_score fit_scene(const exact_scene *s, int keep_normals, int n_threads, sheen_texture *normals)
{
    sheen_paper_fit f;
    sheen_err err;
    exact_score score;
    const sheen_paper_options o = {.without = keep_normals ? 1u << SHEEN_EXTENSION_NORMALS : 0,
                                   .keep_poses = true,
                                   .keep_exposures = true,
                                   .n_threads = n_threads};
    sheen_photos inputs = s->inputs;
    const sheen_moving moving = s->o.n_heights ? SHEEN_MOVING_OBJECT : SHEEN_MOVING_CAMERA;
    assert_ok(sheen_fit_make(&f, SHEEN_FIT_REFINED, moving, &s->mesh, &inputs, &o, &err), err);
    exact_score_model(&score, s, &f.model);
    *normals = f.model.normals;
    f.model.normals = (sheen_texture){0};
    sheen_paper_fit_release(&f);
    return score;
}

static void make_scene(exact_scene *s, const char *name)
{
    exact_options o;
    assert_true(exact_scene_options(&o, name, 1));
    o.size = 0.3;
    exact_scene_make(s, &o);
}

// The normals scene is off by 1 degree in waves of 2 to 5 cm.
static void one_degree_comes_right(void **state)
{
    (void)state;
    exact_scene s;
    sheen_texture normals, none, again;
    make_scene(&s, "normals");
    const exact_score without = fit_scene(&s, 1, 0, &none), with = fit_scene(&s, 0, 0, &normals);
    print_message("specular %.1f dB without, %.1f with; composite %.1f, %.1f\n", without.specular_db,
                  with.specular_db, without.composite_db, with.composite_db);
    assert_true(with.specular_db > without.specular_db + 2);
    assert_true(with.composite_db > without.composite_db + 0.3);
    assert_int_equal(none.n_triangles, 0);
    assert_int_equal(normals.n_triangles, s.mesh.n_triangles);
    // The same for any number of threads
    fit_scene(&s, 0, 1, &again);
    assert_memory_equal(again.rgb, normals.rgb,
                        3 * sizeof(float) * normals.n_triangles *
                            sheen_texels_per_triangle(normals.texels_per_edge));
    sheen_texture_release(&normals);
    sheen_texture_release(&again);
    exact_scene_release(&s);
}

// What a map adds where the mesh's normals are right must not cost anything.
static void right_normals_lose_nothing(void **state)
{
    (void)state;
    exact_scene s;
    sheen_texture normals, none;
    make_scene(&s, "far");
    const exact_score without = fit_scene(&s, 1, 0, &none), with = fit_scene(&s, 0, 0, &normals);
    print_message("specular %.1f dB without, %.1f with; composite %.1f, %.1f; %s\n", without.specular_db,
                  with.specular_db, without.composite_db, with.composite_db,
                  normals.n_triangles ? "a map" : "no map");
    assert_true(with.composite_db > without.composite_db - 0.2);
    sheen_texture_release(&normals);
    exact_scene_release(&s);
}

// Ten steps of a table; a relief of 8 to 16 mm waves and 6 degrees (rms) that the mesh has not.
static void a_relief_that_turned_comes_right(void **state)
{
    (void)state;
    exact_scene s;
    exact_options o;
    sheen_texture normals, none;
    assert_true(exact_scene_options(&o, "embossed", 1));
    o.size = 0.3;
    o.relief_m = 0.008;
    o.n_inputs = 10;
    o.n_heights = 1;
    exact_scene_make(&s, &o);
    const exact_score without = fit_scene(&s, 1, 0, &none), with = fit_scene(&s, 0, 0, &normals);
    print_message("turned: specular %.1f dB without, %.1f with; composite %.1f, %.1f\n", without.specular_db,
                  with.specular_db, without.composite_db, with.composite_db);
    assert_int_equal(normals.n_triangles, s.mesh.n_triangles);
    assert_true(with.specular_db > without.specular_db + 3);
    assert_true(with.composite_db > without.composite_db + 2);
    sheen_texture_release(&normals);
    exact_scene_release(&s);
}

static void right_normals_that_turned_lose_nothing(void **state)
{
    (void)state;
    exact_scene s;
    exact_options o;
    sheen_texture normals, none;
    assert_true(exact_scene_options(&o, "near", 5));
    o.size = 0.25;
    o.n_inputs = 10;
    o.n_heights = 1;
    exact_scene_make(&s, &o);
    const exact_score without = fit_scene(&s, 1, 0, &none), with = fit_scene(&s, 0, 0, &normals);
    print_message("turned: specular %.1f dB without, %.1f with; composite %.1f, %.1f; %s\n",
                  without.specular_db, with.specular_db, without.composite_db, with.composite_db,
                  normals.n_triangles ? "a map" : "no map");
    assert_true(with.composite_db > without.composite_db - 0.2);
    sheen_texture_release(&normals);
    exact_scene_release(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_degree_comes_right),
        cmocka_unit_test(right_normals_lose_nothing),
        cmocka_unit_test(a_relief_that_turned_comes_right),
        cmocka_unit_test(right_normals_that_turned_lose_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

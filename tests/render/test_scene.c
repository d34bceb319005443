// SPDX-License-Identifier: Apache-2.0
// test_scene.c - ray tracing against every triangle tried in turn.
#include "render/scene.h"
#include "tests/support.h"
#include "tests/support_scene.h"

#include <math.h>
#include <stdlib.h>

#include "base/vec.h"

static void build(sheen_scene **scene, const sheen_mesh *mesh)
{
    sheen_err err = {0};
    assert_ok(sheen_scene_new(scene, mesh, &err), err);
}

static void random_ray(float origin[3], float v[3], uint64_t *seed)
{
    float target[3];
    test_direction(origin, seed);
    test_direction(target, seed);
    for (int k = 0; k < 3; k++) {
        origin[k] *= 0.4f;
        v[k] = 0.1f * target[k] - origin[k];
    }
    sheen_normalizef(v);
}

enum { N_RAYS = 3000 };

static void first_hits_agree_with_brute_force(void **state)
{
    (void)state;
    static float origin[3 * N_RAYS], v[3 * N_RAYS];
    static sheen_hit hits[N_RAYS];
    uint64_t seed = 2;
    sheen_mesh mesh;
    sheen_scene *scene;
    test_figure(&mesh, 8, 0.1f, 0.04f);
    build(&scene, &mesh);
    for (size_t i = 0; i < N_RAYS; i++)
        random_ray(origin + 3 * i, v + 3 * i, &seed);
    sheen_scene_first_hits(scene, hits, origin, 0, v, N_RAYS);
    size_t n_hits = 0, n_ties = 0;
    for (size_t i = 0; i < N_RAYS; i++) {
        const double o[3] = {(double)origin[3 * i], (double)origin[3 * i + 1], (double)origin[3 * i + 2]};
        const double d[3] = {(double)v[3 * i], (double)v[3 * i + 1], (double)v[3 * i + 2]};
        const sheen_hit want = test_first_hit(&mesh, o, d);
        n_hits += want.triangle != SHEEN_NO_HIT;
        n_ties += sheen_scene_blocked(scene, origin + 3 * i, v + 3 * i) != (want.triangle != SHEEN_NO_HIT);
        if (hits[i].triangle != want.triangle) { // only where a ray grazes an edge
            n_ties++;
            continue;
        }
        if (want.triangle == SHEEN_NO_HIT)
            continue;
        assert_close(hits[i].b1, want.b1, 2e-4);
        assert_close(hits[i].b2, want.b2, 2e-4);
        assert_close(hits[i].t_m, want.t_m, 2e-6);
    }
    assert_in_range(n_hits, N_RAYS / 4, N_RAYS);
    assert_in_range(n_ties, 0, 3);
    sheen_scene_free(&scene);
    assert_null(scene);
    sheen_scene_free(&scene);
    sheen_mesh_release(&mesh);
}

// From inside a closed mesh no ray may slip out between two triangles. Aimed at the very corner where several
// meet, one in a few hundred may.
static void rays_do_not_slip_through(void **state)
{
    (void)state;
    sheen_mesh mesh;
    sheen_scene *scene;
    const float origin[3] = {0, 0, 0}, centre[3] = {0, 0, 0};
    test_sphere(&mesh, 16, centre, 0.1f);
    build(&scene, &mesh);
    size_t n_slipped = 0;
    for (size_t t = 0; t < mesh.n_triangles; t++) {
        float v[9];
        sheen_hit hits[3];
        for (size_t c = 0; c < 3; c++) { // at the corner, and at the middle of a side
            const float *a = mesh.p_obj + 3 * (size_t)mesh.triangles[3 * t + c];
            const float *b = mesh.p_obj + 3 * (size_t)mesh.triangles[3 * t + (c + 1) % 3];
            for (size_t k = 0; k < 3; k++)
                v[3 * c + k] = c ? a[k] + b[k] : a[k];
            sheen_normalizef(v + 3 * c);
        }
        sheen_scene_first_hits(scene, hits, origin, 1, v, 3);
        for (size_t c = 0; c < 3; c++) {
            n_slipped += hits[c].triangle == SHEEN_NO_HIT;
            assert_true(c == 0 || hits[c].triangle != SHEEN_NO_HIT);
            assert_true(hits[c].b1 >= 0 && hits[c].b2 >= 0 && hits[c].b1 + hits[c].b2 <= 1.000001f);
        }
    }
    assert_in_range(n_slipped, 0, mesh.n_triangles / 200);
    sheen_scene_free(&scene);
    sheen_mesh_release(&mesh);
}

static void a_direction_that_is_not_finite_hits_nothing(void **state)
{
    (void)state;
    sheen_mesh mesh;
    sheen_scene *scene;
    const float origin[3] = {0, 0, 0}, centre[3] = {0, 0, 0};
    test_sphere(&mesh, 2, centre, 0.1f);
    build(&scene, &mesh);
    float v[9] = {0, 0, 1, (float)NAN, (float)NAN, (float)NAN, 0, 1, 0};
    sheen_hit hits[3];
    sheen_scene_first_hits(scene, hits, origin, 1, v, 3);
    assert_true(hits[0].triangle != SHEEN_NO_HIT);
    assert_true(hits[1].triangle == SHEEN_NO_HIT);
    assert_true(hits[2].triangle != SHEEN_NO_HIT);
    sheen_scene_free(&scene);
    sheen_mesh_release(&mesh);
}

// A point of a convex body is visible exactly where its triangle faces the target.
static void occlusion_on_a_sphere(void **state)
{
    (void)state;
    sheen_mesh mesh;
    sheen_scene *scene;
    const float centre[3] = {0.02f, -0.01f, 0.03f}, target[3] = {0.3f, 0.2f, 0.4f};
    test_sphere(&mesh, 12, centre, 0.1f);
    build(&scene, &mesh);
    size_t n_hidden = 0;
    float *p = malloc(mesh.n_triangles * 3 * sizeof *p);
    uint8_t *occluded = malloc(mesh.n_triangles), *facing = malloc(mesh.n_triangles);
    assert_true(p && occluded && facing);
    for (size_t t = 0; t < mesh.n_triangles; t++) {
        const float *corner[3];
        float e1[3], e2[3], n[3], to[3];
        for (size_t c = 0; c < 3; c++)
            corner[c] = mesh.p_obj + 3 * (size_t)mesh.triangles[3 * t + c];
        for (size_t k = 0; k < 3; k++)
            p[3 * t + k] = (corner[0][k] + corner[1][k] + corner[2][k]) / 3;
        sheen_subf(e1, corner[1], corner[0]);
        sheen_subf(e2, corner[2], corner[0]);
        sheen_crossf(n, e1, e2);
        sheen_subf(to, target, p + 3 * t);
        sheen_normalizef(n);
        sheen_normalizef(to);
        const float cosine = sheen_dotf(n, to);
        facing[t] = cosine > 0.02f ? 1 : cosine < -0.02f ? 0 : 2; // 2: edge on, either answer
    }
    sheen_scene_occluded(scene, occluded, p, mesh.n_triangles, target, 1e-5f);
    for (size_t t = 0; t < mesh.n_triangles; t++) {
        if (facing[t] != 2)
            assert_int_equal(occluded[t], !facing[t]);
        n_hidden += occluded[t];
    }
    assert_in_range(n_hidden, mesh.n_triangles / 2, mesh.n_triangles * 3 / 4);
    free(p);
    free(occluded);
    free(facing);
    sheen_scene_free(&scene);
    sheen_mesh_release(&mesh);
}

// Both ends are pulled in: what lies within the offset of either does not count, what lies between does.
static void offsets_at_both_ends(void **state)
{
    (void)state;
    static const float wall[9] = {-1, -1, 0, 1, -1, 0, 0, 2, 0};
    sheen_mesh mesh;
    sheen_scene *scene;
    test_triangles(&mesh, wall, 1);
    build(&scene, &mesh);
    const float above[3] = {0, 0, 1}, just_above[3] = {0, 0, 0.005f};
    const float p[9] = {0, 0, 0, 0, 0, -0.5f, 0, 0, -0.005f};
    uint8_t occluded[3];
    sheen_scene_occluded(scene, occluded, p, 3, above, 0.01f);
    assert_int_equal(occluded[0], 0); // on the wall itself
    assert_int_equal(occluded[1], 1); // behind it
    assert_int_equal(occluded[2], 0); // behind, within the offset
    sheen_scene_occluded(scene, occluded, p, 3, just_above, 0.01f);
    assert_int_equal(occluded[1], 0); // the wall is within the offset of the target
    sheen_scene_free(&scene);
    sheen_mesh_release(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(first_hits_agree_with_brute_force),
        cmocka_unit_test(rays_do_not_slip_through),
        cmocka_unit_test(a_direction_that_is_not_finite_hits_nothing),
        cmocka_unit_test(occlusion_on_a_sphere),
        cmocka_unit_test(offsets_at_both_ends),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

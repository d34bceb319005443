// SPDX-License-Identifier: Apache-2.0
// test_mesh_repair.c - meshes as scanners leave them come out as they should have been, and good ones are left alone.
#include "base/mesh_repair.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "support.h"
#include "support_scene.h"

static const float middle[3] = {0.3f, -0.2f, 0.1f};

static void ball(sheen_mesh *mesh)
{
    test_sphere(mesh, 6, middle, 0.1f);
}

static void turn(sheen_mesh *mesh, size_t triangle)
{
    uint32_t *c = mesh->triangles + 3 * triangle;
    const uint32_t second = c[1];
    c[1] = c[2];
    c[2] = second;
}

static void mend(sheen_mesh_repairs *r, sheen_mesh *mesh)
{
    sheen_err err;
    assert_ok(sheen_mesh_repair(r, mesh, &err), err);
}

// Every triangle and every normal looks away from the middle.
static void check_outward(const sheen_mesh *mesh)
{
    for (size_t t = 0; t < mesh->n_triangles; t++) {
        const float *p[3];
        float a[3], b[3], n[3], out[3];
        for (size_t k = 0; k < 3; k++)
            p[k] = mesh->p_obj + 3 * (size_t)mesh->triangles[3 * t + k];
        sheen_subf(a, p[1], p[0]);
        sheen_subf(b, p[2], p[0]);
        sheen_crossf(n, a, b);
        sheen_subf(out, p[0], middle);
        assert_true(sheen_dotf(n, out) > 0);
        assert_true(sheen_dotf(mesh->n_obj + 3 * (size_t)mesh->triangles[3 * t], out) > 0);
    }
}

static void a_good_mesh_is_left_alone(void **state)
{
    (void)state;
    sheen_mesh a, b;
    sheen_mesh_repairs r;
    ball(&a);
    ball(&b);
    mend(&r, &a);
    assert_true(!r.n_doubles && !r.n_turned && !r.n_normals);
    assert_int_equal(a.n_triangles, b.n_triangles);
    assert_memory_equal(a.triangles, b.triangles, 3 * b.n_triangles * sizeof *b.triangles);
    assert_memory_equal(a.n_obj, b.n_obj, 3 * b.n_vertices * sizeof *b.n_obj);
    sheen_mesh_release(&a);
    sheen_mesh_release(&b);
    test_figure(&a, 8, 0.08f, 0.024f);
    mend(&r, &a);
    assert_true(!r.n_doubles && !r.n_turned && !r.n_normals);
    sheen_mesh_release(&a);
}

static void inside_out_comes_right(void **state)
{
    (void)state;
    sheen_mesh mesh;
    sheen_mesh_repairs r;
    ball(&mesh);
    for (size_t t = 0; t < mesh.n_triangles; t++)
        turn(&mesh, t);
    for (size_t i = 0; i < 3 * mesh.n_vertices; i++)
        mesh.n_obj[i] = -mesh.n_obj[i];
    mend(&r, &mesh);
    assert_int_equal(r.n_turned, mesh.n_triangles);
    check_outward(&mesh);
    for (size_t t = 0; t < mesh.n_triangles; t += 3) // a third of them, here and there
        turn(&mesh, t);
    mend(&r, &mesh);
    assert_int_equal(r.n_turned, (mesh.n_triangles + 2) / 3);
    check_outward(&mesh);
    sheen_mesh_release(&mesh);
}

// A seam in the vertices (every triangle with corners of its own) hides nothing.
static void corners_at_one_place_are_one(void **state)
{
    (void)state;
    sheen_mesh mesh, ball_mesh;
    sheen_mesh_repairs r;
    ball(&ball_mesh);
    float *corners = malloc(9 * ball_mesh.n_triangles * sizeof *corners);
    assert_non_null(corners);
    for (size_t i = 0; i < 3 * ball_mesh.n_triangles; i++)
        memcpy(corners + 3 * i, ball_mesh.p_obj + 3 * (size_t)ball_mesh.triangles[i], 3 * sizeof *corners);
    test_triangles(&mesh, corners, ball_mesh.n_triangles);
    for (size_t t = 1; t < mesh.n_triangles; t += 2)
        turn(&mesh, t);
    mend(&r, &mesh);
    assert_int_equal(r.n_turned, mesh.n_triangles / 2);
    check_outward(&mesh);
    free(corners);
    sheen_mesh_release(&mesh);
    sheen_mesh_release(&ball_mesh);
}

static void doubles_go(void **state)
{
    (void)state;
    sheen_mesh mesh;
    sheen_mesh_repairs r;
    ball(&mesh);
    const size_t n = mesh.n_triangles, size_bytes = 3 * n * sizeof *mesh.triangles;
    mesh.triangles = realloc(mesh.triangles, 2 * size_bytes);
    assert_non_null(mesh.triangles);
    memcpy(mesh.triangles + 3 * n, mesh.triangles, size_bytes);
    mesh.n_triangles = 2 * n;
    for (size_t t = n; t < 2 * n; t += 2) // both ways round
        turn(&mesh, t);
    mend(&r, &mesh);
    assert_int_equal(r.n_doubles, n);
    assert_int_equal(mesh.n_triangles, n);
    assert_int_equal(r.n_turned, 0);
    check_outward(&mesh);
    sheen_mesh_release(&mesh);
}

static void bad_normals_are_replaced(void **state)
{
    (void)state;
    sheen_mesh mesh;
    sheen_mesh_repairs r;
    uint64_t seed = 3;
    ball(&mesh);
    for (size_t i = 0; i < 3; i++)
        mesh.n_obj[3 * 7 + i] = -mesh.n_obj[3 * 7 + i];
    float before[3];
    memcpy(before, mesh.n_obj, sizeof before);
    mend(&r, &mesh);
    assert_int_equal(r.n_normals, 1);
    assert_memory_equal(before, mesh.n_obj, sizeof before);
    check_outward(&mesh);
    for (size_t v = 0; v < mesh.n_vertices; v++)
        test_direction(mesh.n_obj + 3 * v, &seed);
    mend(&r, &mesh);
    assert_int_equal(r.n_normals, mesh.n_vertices);
    check_outward(&mesh);
    sheen_mesh_release(&mesh);
}

// A sheet has no inside: the majority decides. One with a hole, and one triangle, are no trouble.
static void open_parts_follow_their_majority(void **state)
{
    (void)state;
    static const float sheet[4][9] = {{0, 0, 0, 1, 0, 0, 1, 1, 0},
                                      {0, 0, 0, 1, 1, 0, 0, 1, 0},
                                      {1, 0, 0, 2, 0, 0, 2, 1, 0},
                                      {1, 0, 0, 1, 1, 0, 2, 1, 0}}; // the last one is turned over
    sheen_mesh mesh;
    sheen_mesh_repairs r;
    test_triangles(&mesh, sheet[0], 4);
    mend(&r, &mesh);
    assert_int_equal(r.n_turned, 1);
    for (size_t v = 0; v < mesh.n_vertices; v++)
        assert_true(mesh.n_obj[3 * v + 2] > 0.9f);
    sheen_mesh_release(&mesh);
    test_triangles(&mesh, sheet[0], 1);
    mend(&r, &mesh);
    assert_true(!r.n_turned && mesh.n_triangles == 1);
    sheen_mesh_release(&mesh);
    ball(&mesh);
    mesh.n_triangles -= 40; // a hole
    for (size_t t = 0; t < mesh.n_triangles; t++)
        turn(&mesh, t);
    mend(&r, &mesh);
    assert_int_equal(r.n_turned, mesh.n_triangles);
    check_outward(&mesh);
    sheen_mesh_release(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_good_mesh_is_left_alone),    cmocka_unit_test(inside_out_comes_right),
        cmocka_unit_test(corners_at_one_place_are_one), cmocka_unit_test(doubles_go),
        cmocka_unit_test(bad_normals_are_replaced),     cmocka_unit_test(open_parts_follow_their_majority),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// SPDX-License-Identifier: Apache-2.0
// test_normal_grid.c - the lattice of offsets: shared points are one, and its equations are solved.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "fit/normal_grid.h"
#include "tests/support.h"
#include "tests/support_scene.h"

// Texels at one place have one number, others have different ones: V + E (T - 2) + F (T - 2)(T - 3) / 2 in all.
static void shared_points_are_one(void **state)
{
    (void)state;
    sheen_mesh mesh;
    test_figure(&mesh, 3, 0.1f, 0.02f);
    for (int T = 2; T <= 6; T++) {
        sheen_normal_grid g;
        sheen_err err;
        assert_ok(sheen_normal_grid_init(&g, &mesh, T, &err), err);
        const size_t per_triangle = sheen_texels_per_triangle(T), n_sides = mesh.n_triangles * 3 / 2;
        const size_t inside = (size_t)((T - 2) * (T - 3) / 2), on_side = (size_t)(T - 2);
        assert_int_equal(g.n_nodes, mesh.n_vertices + n_sides * on_side + mesh.n_triangles * inside);
        float *place = malloc(3 * g.n_nodes * sizeof *place), p[3 * 21];
        uint8_t *known = calloc(g.n_nodes, 1);
        assert_true(place && known);
        for (size_t f = 0; f < mesh.n_triangles; f++) {
            sheen_texture_lattice(&mesh, f, T, p, NULL);
            for (size_t k = 0; k < per_triangle; k++) {
                const uint32_t node = g.node[f * per_triangle + k];
                assert_true(node < g.n_nodes);
                for (size_t c = 0; c < 3 && known[node]; c++)
                    assert_close(place[3 * node + c], p[3 * k + c], 1e-6);
                memcpy(place + 3 * node, p + 3 * k, 3 * sizeof *p);
                known[node] = 1;
            }
        }
        for (size_t i = 0; i < g.n_nodes; i++)
            assert_true(known[i]);
        free(place);
        free(known);
        sheen_normal_grid_release(&g);
    }
    sheen_mesh_release(&mesh);
}

// Rows that ask for one offset everywhere, weakly opposed, are followed; a row pulls its surroundings with it.
static void rows_are_followed(void **state)
{
    (void)state;
    sheen_mesh mesh;
    sheen_normal_grid g;
    sheen_err err;
    test_figure(&mesh, 3, 0.1f, 0.02f);
    assert_ok(sheen_normal_grid_init(&g, &mesh, 4, &err), err);
    float *d = calloc(3 * g.n_nodes, sizeof *d);
    assert_non_null(d);
    // One row: 1e6 (dx - (0.02, 0, -0.01))^2
    sheen_normal_row row = {
        .H = {1e6f, 0, 1e6f, 0, 0, 1e6f}, .b = {2e4f, 0, -1e4f}, .weight = {0.5f, 0.25f, 0.25f}};
    for (int k = 0; k < 3; k++)
        row.node[k] = g.node[k];
    const sheen_normal_prior prior = {100, 20};
    assert_ok(sheen_normal_grid_solve(d, &g, &row, 1, &prior, 2, &err), err);
    assert_close(0.5f * d[3 * row.node[0]] + 0.25f * d[3 * row.node[1]] + 0.25f * d[3 * row.node[2]], 0.02,
                 5e-4);
    size_t n_pulled = 0;
    for (size_t i = 0; i < g.n_nodes; i++) {
        assert_true(d[3 * i] > -1e-4f && d[3 * i] < 0.03f);
        assert_close(d[3 * i + 1], 0, 1e-6);
        assert_close(d[3 * i + 2], -0.5f * d[3 * i], 2e-4);
        n_pulled += d[3 * i] > 0.005f;
    }
    assert_true(n_pulled > g.n_nodes / 2);
    free(d);
    sheen_normal_grid_release(&g);
    sheen_mesh_release(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shared_points_are_one),
        cmocka_unit_test(rows_are_followed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

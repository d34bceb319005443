// SPDX-License-Identifier: Apache-2.0
// test_normal_map.c - offsets on the mesh's normals: in files, in pictures, and across edges.
#include "render/normal_map.h"
#include "tests/support.h"
#include "tests/support_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "render/draw.h"
#include "render/draw_geometry.h"

enum { T = 5, PER_TRIANGLE = T * (T + 1) / 2 };

// A smooth field of offsets, square to the mesh's normals.
static void ripple(sheen_texture *map, const sheen_mesh *mesh)
{
    sheen_err err;
    float p[3 * PER_TRIANGLE], m[3 * PER_TRIANGLE];
    assert_ok(sheen_normal_map_init(map, mesh->n_triangles, T, &err), err);
    for (size_t f = 0; f < mesh->n_triangles; f++) {
        sheen_texture_lattice(mesh, f, T, p, m);
        for (size_t k = 0; k < PER_TRIANGLE; k++) {
            const float wave[3] = {0.2f * sinf(90 * p[3 * k + 1]), 0.2f * sinf(70 * p[3 * k + 2]),
                                   0.2f * cosf(80 * p[3 * k])};
            const float along = sheen_dotf(wave, m + 3 * k);
            for (size_t c = 0; c < 3; c++)
                map->rgb[3 * (f * PER_TRIANGLE + k) + c] = wave[c] - along * m[3 * k + c];
        }
    }
}

static void tangents_are_a_frame(void **state)
{
    (void)state;
    uint64_t seed = 4;
    for (int i = 0; i < 1000; i++) {
        float m[3], a[3], b[3], turn[3];
        test_direction(m, &seed);
        if (i < 6) {
            memset(m, 0, sizeof m);
            m[i / 2] = i % 2 ? -1 : 1;
        }
        sheen_axes_aboutf(a, b, m);
        sheen_crossf(turn, a, b);
        assert_close(sheen_dotf(a, a), 1, 1e-6);
        assert_close(sheen_dotf(a, m), 0, 1e-6);
        for (int k = 0; k < 3; k++)
            assert_close(turn[k], m[k], 1e-6);
    }
}

static void two_numbers_a_texel_suffice(void **state)
{
    (void)state;
    sheen_mesh mesh;
    sheen_texture map;
    test_figure(&mesh, 4, 0.1f, 0.03f);
    ripple(&map, &mesh);
    const size_t n = mesh.n_triangles * PER_TRIANGLE;
    float *before = malloc(3 * n * sizeof *before);
    assert_non_null(before);
    memcpy(before, map.rgb, 3 * n * sizeof *before);
    sheen_normal_map_to_tangents(&map, &mesh);
    for (size_t i = 0; i < n; i++)
        assert_true(map.rgb[3 * i + 2] == 0);
    sheen_normal_map_from_tangents(&map, &mesh);
    for (size_t i = 0; i < 3 * n; i++)
        assert_close(map.rgb[i], before[i], 1e-6);
    free(before);
    sheen_texture_release(&map);
    sheen_mesh_release(&mesh);
}

// At a texel the normal is m + d at unit length, whatever the lattice that asks.
static void bends_where_the_texel_is(void **state)
{
    (void)state;
    sheen_mesh mesh;
    sheen_texture map;
    test_figure(&mesh, 3, 0.1f, 0.03f);
    ripple(&map, &mesh);
    enum { FINE = 2 * T - 1 };
    float p[3 * FINE * (FINE + 1) / 2], n[3 * FINE * (FINE + 1) / 2], q[3 * PER_TRIANGLE],
        m[3 * PER_TRIANGLE];
    for (size_t f = 0; f < mesh.n_triangles; f++) {
        sheen_normal_map_lattice(&mesh, &map, f, FINE, p, n);
        sheen_texture_lattice(&mesh, f, T, q, m);
        for (int j = 0; j < T; j++)
            for (int i = 0; i + j < T; i++) {
                const size_t coarse = sheen_texel_index(T, i, j),
                             fine = sheen_texel_index(FINE, 2 * i, 2 * j);
                float want[3];
                for (size_t k = 0; k < 3; k++)
                    want[k] = m[3 * coarse + k] + map.rgb[3 * (f * PER_TRIANGLE + coarse) + k];
                sheen_normalizef(want);
                for (size_t k = 0; k < 3; k++)
                    assert_close(n[3 * fine + k], want[k], 1e-5);
            }
    }
    sheen_texture_release(&map);
    sheen_mesh_release(&mesh);
}

// A sphere under one lamp, and the same with wrong normals and a map that puts them right.
typedef struct pair {
    sheen_model right, mended; // all but normals is right's
} pair;

static void make_pair(pair *w)
{
    static const float origin[3] = {0, 0, 0};
    static const sheen_lamp lamp = {{0.6f, 0, 0.8f}, 0, 0, {0.5f, 0.6f, 0.7f}};
    sheen_err err;
    sheen_mesh *mesh = &w->right.mesh;
    sheen_model_init(&w->right);
    test_sphere(mesh, 12, origin, 0.1f);
    assert_ok(sheen_texture_init(&w->right.texture, mesh->n_triangles, 2, &err), err);
    memset(w->right.texture.n_views, 1, mesh->n_triangles * 3);
    assert_ok(sheen_model_set_lamps(&w->right, &lamp, 1, &err), err);
    w->right.sigma_rad = 0.1;
    w->mended = w->right;
    w->mended.mesh.n_obj = malloc(3 * mesh->n_vertices * sizeof(float));
    assert_non_null(w->mended.mesh.n_obj);
    for (size_t i = 0; i < mesh->n_vertices; i++) {
        const float *p = mesh->p_obj + 3 * i;
        float *n = w->mended.mesh.n_obj + 3 * i;
        memcpy(n, mesh->n_obj + 3 * i, 3 * sizeof *n);
        n[0] += 0.15f * sinf(60 * p[2]);
        n[1] += 0.15f * sinf(60 * p[0]);
        sheen_normalizef(n);
    }
    assert_ok(sheen_normal_map_init(&w->mended.normals, mesh->n_triangles, T, &err), err);
    for (size_t f = 0; f < mesh->n_triangles; f++) { // d = n / (m.n) - m, which is square to m
        float p[3 * PER_TRIANGLE], n[3 * PER_TRIANGLE], m[3 * PER_TRIANGLE];
        sheen_texture_lattice(mesh, f, T, p, n);
        sheen_texture_lattice(&w->mended.mesh, f, T, p, m);
        for (size_t i = 0; i < 3 * PER_TRIANGLE; i++) {
            const size_t k = i / 3 * 3;
            w->mended.normals.rgb[3 * f * PER_TRIANGLE + i] = n[i] / sheen_dotf(n + k, m + k) - m[i];
        }
    }
}

static void free_pair(pair *w)
{
    free(w->mended.mesh.n_obj);
    sheen_texture_release(&w->mended.normals);
    sheen_model_release(&w->right);
}

// The specular layer and the normals of a model.
static void look(sheen_layers *layers, sheen_geometry *geometry, const sheen_model *m)
{
    sheen_drawing *drawing;
    sheen_camera cam;
    sheen_err err;
    double rt_cam_obj[6];
    test_camera(&cam, 120, 100, 300, 0);
    test_look(rt_cam_obj, 0.1, 0.25, 0.35);
    assert_ok(sheen_drawing_new(&drawing, m, &err), err);
    assert_ok(sheen_draw(layers, drawing, &cam, rt_cam_obj, NULL, NULL, &err), err);
    assert_ok(sheen_draw_geometry(geometry, drawing, &cam, rt_cam_obj, 0, &err), err);
    sheen_drawing_free(&drawing);
}

static double worst_of(const sheen_image *a, const sheen_image *b)
{
    const size_t n = (size_t)a->width_px * (size_t)a->height_px * 3;
    double worst = 0;
    for (size_t i = 0; i < n; i++)
        worst = fmax(worst, fabs((double)(a->data[i] - b->data[i])));
    return worst;
}

// shadows 0: all samples of a tile are shaded together; 1: one after another.
static void a_map_mends_a_mesh(void **state)
{
    (void)state;
    pair w;
    make_pair(&w);
    for (int shadows = 0; shadows < 2; shadows++) {
        sheen_layers want, got, without;
        sheen_geometry n_want, n_got, n_without;
        sheen_model unmended = w.mended;
        unmended.normals = (sheen_texture){0};
        w.right.shadows = w.mended.shadows = unmended.shadows = shadows;
        look(&want, &n_want, &w.right);
        look(&got, &n_got, &w.mended);
        look(&without, &n_without, &unmended);
        assert_true(worst_of(&got.specular, &want.specular) < 0.01);
        assert_true(worst_of(&without.specular, &want.specular) > 0.2);
        assert_true(worst_of(&n_got.n_cam, &n_want.n_cam) < 0.01);
        assert_true(worst_of(&n_without.n_cam, &n_want.n_cam) > 0.1);
        sheen_layers *const layers[] = {&want, &got, &without};
        sheen_geometry *const geometry[] = {&n_want, &n_got, &n_without};
        for (int i = 0; i < 3; i++) {
            sheen_layers_release(layers[i]);
            sheen_geometry_release(geometry[i]);
        }
    }
    free_pair(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tangents_are_a_frame),
        cmocka_unit_test(two_numbers_a_texel_suffice),
        cmocka_unit_test(bends_where_the_texel_is),
        cmocka_unit_test(a_map_mends_a_mesh),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

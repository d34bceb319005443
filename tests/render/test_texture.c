// SPDX-License-Identifier: Apache-2.0
// test_texture.c - the global texture: lattice, interpolation, seams, atlas.
#include "base/cpu_level.h"
#include "render/texture.h"
#include "tests/support.h"
#include "tests/support_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"

// A linear function of the place: linear interpolation must give it back exactly.
static void colour_at(float rgb[3], const float p[3])
{
    rgb[0] = 0.5f + 2 * p[0] - p[1];
    rgb[1] = 0.3f + p[2];
    rgb[2] = 0.7f - 3 * p[1] + p[2];
}

static void paint(sheen_texture *t, const sheen_mesh *mesh, int texels_per_edge)
{
    sheen_err err = {0};
    assert_ok(sheen_texture_init(t, mesh->n_triangles, texels_per_edge, &err), err);
    const size_t n = sheen_texels_per_triangle(texels_per_edge);
    float p[3 * 64 * 65 / 2], normal[3 * 64 * 65 / 2];
    for (size_t f = 0; f < mesh->n_triangles; f++) {
        sheen_texture_lattice(mesh, f, texels_per_edge, p, normal);
        for (size_t k = 0; k < n; k++) {
            colour_at(t->rgb + 3 * (f * n + k), p + 3 * k);
            t->n_views[f * n + k] = (uint8_t)(1 + (f + k) % 255);
        }
    }
}

static void place(float p[3], const sheen_mesh *mesh, const sheen_hit *hit)
{
    const float b[3] = {1 - hit->b1 - hit->b2, hit->b1, hit->b2};
    for (int k = 0; k < 3; k++) {
        p[k] = 0;
        for (int c = 0; c < 3; c++)
            p[k] +=
                b[c] *
                mesh->p_obj[3 * (size_t)mesh->triangles[3 * (size_t)hit->triangle + (size_t)c] + (size_t)k];
    }
}

static void figure(sheen_mesh *mesh)
{
    test_figure(mesh, 4, 0.1f, 0.03f);
}

static void interpolation_is_linear(void **state)
{
    (void)state;
    static const int sizes[] = {2, 3, 8, 20, 64};
    uint64_t seed = 1;
    sheen_mesh mesh;
    figure(&mesh);
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        sheen_texture t;
        paint(&t, &mesh, sizes[s]);
        for (int rep = 0; rep < 20000; rep++) {
            sheen_hit hit = {.triangle = (uint32_t)(test_random(&seed) * (double)mesh.n_triangles)};
            hit.b1 = (float)test_random(&seed);
            hit.b2 = (float)test_random(&seed) * (1 - hit.b1);
            if (rep % 5 == 0) // on the edges and corners
                hit.b1 = rep % 2 ? 0 : 1 - hit.b2;
            if (rep % 35 == 0)
                hit.b2 = 0;
            float p[3], want[3], got[3];
            place(p, &mesh, &hit);
            colour_at(want, p);
            assert_close(sheen_texture_sample(&t, &hit, got), 1, 1e-6);
            for (int k = 0; k < 3; k++)
                assert_close(got[k], want[k], 2e-6);
        }
        sheen_texture_release(&t);
    }
    sheen_mesh_release(&mesh);
}

// Whole vectors and a rest, with places on edges and texels that no photograph saw, at every instruction set.
static void many_samples_are_those_of_each(void **state)
{
    (void)state;
    enum { N = 16 * 20 + 5, T = 8 };
    static sheen_hit hits[N];
    static float rgb[N][3], seen[N];
    sheen_mesh mesh;
    sheen_texture t;
    uint64_t seed = 5;
    figure(&mesh);
    paint(&t, &mesh, T);
    for (size_t i = 0; i < mesh.n_triangles * sheen_texels_per_triangle(T); i += 3)
        t.n_views[i] = 0;
    for (int i = 0; i < N; i++) {
        hits[i].triangle = (uint32_t)(test_random(&seed) * (double)mesh.n_triangles);
        hits[i].b1 = i % 7 ? (float)test_random(&seed) : 0;
        hits[i].b2 = i % 5 ? (float)test_random(&seed) * (1 - hits[i].b1) : 1 - hits[i].b1;
    }
    for (int level = 0; level <= sheen_cpu_level(); level++) {
        sheen_texture_samples_level(rgb[0], seen, &t, hits, N, level);
        for (int i = 0; i < N; i++) {
            float want[3];
            assert_close(seen[i], sheen_texture_sample(&t, &hits[i], want), 1e-5);
            for (int k = 0; k < 3; k++)
                assert_close(rgb[i][k], want[k], 1e-5);
        }
    }
    sheen_texture_release(&t);
    sheen_mesh_release(&mesh);
}

// The lattice is what sheen_texel_index says, with the mesh's own points and unit normals.
static void lattice_is_in_the_order_of_texels(void **state)
{
    (void)state;
    sheen_mesh mesh;
    figure(&mesh);
    enum { T = 7 };
    float p[3 * T * (T + 1) / 2], n[3 * T * (T + 1) / 2];
    sheen_texture_lattice(&mesh, 11, T, p, n);
    for (int j = 0; j < T; j++)
        for (int i = 0; i + j < T; i++) {
            const sheen_hit hit = {.triangle = 11, .b1 = (float)i / (T - 1), .b2 = (float)j / (T - 1)};
            float want[3];
            place(want, &mesh, &hit);
            const size_t k = sheen_texel_index(T, i, j);
            assert_true(k < sheen_texels_per_triangle(T));
            for (size_t c = 0; c < 3; c++)
                assert_close(p[3 * k + c], want[c], 1e-7);
            assert_close(sheen_dotf(n + 3 * k, n + 3 * k), 1, 1e-6);
        }
    sheen_mesh_release(&mesh);
}

// Random texels, but the same on both sides of every edge: the picture must not jump across.
static void no_seam_across_edges(void **state)
{
    (void)state;
    enum { T = 5 };
    static const float two[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, /* shares (1,0,0)-(0,1,0) */ 1,
                                  1, 0, 0, 1, 0, 1, 0, 0};
    sheen_mesh mesh;
    test_triangles(&mesh, two, 2);
    sheen_texture t;
    assert_int_equal(sheen_texture_init(&t, 2, T, NULL), SHEEN_OK);
    uint64_t seed = 8;
    const size_t n = sheen_texels_per_triangle(T);
    for (size_t k = 0; k < 2 * n; k++) {
        t.n_views[k] = 1;
        for (size_t c = 0; c < 3; c++)
            t.rgb[3 * k + c] = (float)test_random(&seed);
    }
    for (int i = 0; i < T; i++) { // the hypotenuse: (i, T-1-i) of the first is (T-1-i, i) of the second
        const size_t a = sheen_texel_index(T, i, T - 1 - i), b = n + sheen_texel_index(T, T - 1 - i, i);
        memcpy(t.rgb + 3 * b, t.rgb + 3 * a, 3 * sizeof *t.rgb);
    }
    for (int step = 0; step <= 100; step++) {
        const float along = (float)step / 100;
        const sheen_hit first = {.triangle = 0, .b1 = along, .b2 = 1 - along};
        const sheen_hit second = {.triangle = 1, .b1 = 1 - along, .b2 = along};
        float a[3], b[3];
        sheen_texture_sample(&t, &first, a);
        sheen_texture_sample(&t, &second, b);
        for (int c = 0; c < 3; c++)
            assert_close(a[c], b[c], 1e-5);
    }
    sheen_texture_release(&t);
    sheen_mesh_release(&mesh);
}

static void unseen_texels_have_no_part(void **state)
{
    (void)state;
    sheen_texture t;
    assert_int_equal(sheen_texture_init(&t, 1, 2, NULL), SHEEN_OK);
    const sheen_hit hit = {.b1 = 0.25f, .b2 = 0.25f};
    float rgb[3] = {9, 9, 9};
    assert_true(sheen_texture_sample(&t, &hit, rgb) == 0); // nothing seen: a hole
    assert_true(rgb[0] == 0 && rgb[1] == 0 && rgb[2] == 0);
    t.n_views[1] = 3;
    t.rgb[3] = 0.8f;
    t.rgb[0] = 100; // not seen: must not shine through
    assert_close(sheen_texture_sample(&t, &hit, rgb), 0.25, 1e-6);
    assert_close(rgb[0], 0.8, 1e-6);
    sheen_texture_release(&t);
}

static void atlas_round_trip(void **state)
{
    (void)state;
    sheen_err err = {0};
    for (int T = 2; T < 24; T += 7)
        for (size_t n_triangles = 1; n_triangles < 40; n_triangles += 3) {
            sheen_texture t, back;
            sheen_image atlas;
            assert_ok(sheen_texture_init(&t, n_triangles, T, &err), err);
            const size_t n = n_triangles * sheen_texels_per_triangle(T);
            for (size_t k = 0; k < n; k++) {
                t.n_views[k] = (uint8_t)(k % 256);
                for (size_t c = 0; c < 3; c++)
                    t.rgb[3 * k + c] = (float)(3 * k + c + 1);
            }
            assert_ok(sheen_texture_to_atlas(&atlas, &t, &err), err);
            assert_ok(sheen_texture_from_atlas(&back, &atlas, n_triangles, T, &err), err);
            assert_memory_equal(back.rgb, t.rgb, 3 * n * sizeof *t.rgb);
            assert_memory_equal(back.n_views, t.n_views, n);
            sheen_texture_release(&t);
            sheen_texture_release(&back);
            sheen_image_release(&atlas);
        }
}

static void refuses_what_does_not_fit(void **state)
{
    (void)state;
    sheen_err err = {0};
    sheen_texture t;
    assert_fails(sheen_texture_init(&t, 10, 1, &err), err, SHEEN_EARG, "1 texels an edge");
    assert_fails(sheen_texture_init(&t, 10, 65, &err), err, SHEEN_EARG, "2 to 64");
    assert_fails(sheen_texture_init(&t, 0, 20, &err), err, SHEEN_EARG, "0 triangles");
    sheen_image atlas;
    assert_ok(sheen_image_init(&atlas, 20, 21, 4, &err), err);
    assert_fails(sheen_texture_from_atlas(&t, &atlas, 5, 20, &err), err, SHEEN_EFORMAT, "20 x 21");
    assert_fails(sheen_texture_from_atlas(&t, &atlas, 5, 1, &err), err, SHEEN_EFORMAT, "out of range");
    assert_ok(sheen_texture_from_atlas(&t, &atlas, 2, 20, &err), err);
    sheen_texture_release(&t);
    atlas.data[5] = (float)NAN;
    assert_fails(sheen_texture_from_atlas(&t, &atlas, 2, 20, &err), err, SHEEN_EFORMAT, "not a colour");
    atlas.data[5] = 0;
    atlas.data[7] = 1.5f; // as a number of views
    assert_fails(sheen_texture_from_atlas(&t, &atlas, 2, 20, &err), err, SHEEN_EFORMAT, "not a colour");
    sheen_image_release(&atlas);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(many_samples_are_those_of_each),    cmocka_unit_test(interpolation_is_linear),
        cmocka_unit_test(lattice_is_in_the_order_of_texels), cmocka_unit_test(no_seam_across_edges),
        cmocka_unit_test(unseen_texels_have_no_part),        cmocka_unit_test(atlas_round_trip),
        cmocka_unit_test(refuses_what_does_not_fit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// SPDX-License-Identifier: Apache-2.0
// test_texture_resample.c - other numbers of texels: what is linear stays, seams stay closed, holes stay holes.
#include "render/texture.h"
#include "tests/support.h"
#include "tests/support_scene.h"

#include <math.h>
#include <string.h>

enum { OLD = 9, MAX_TEXELS = 64 * 65 / 2 };

static void paint(sheen_texture *t, const sheen_mesh *mesh, float (*value)(const float p[3]))
{
    sheen_err err = {0};
    float p[3 * MAX_TEXELS];
    const size_t n = sheen_texels_per_triangle(OLD);
    assert_ok(sheen_texture_init(t, mesh->n_triangles, OLD, &err), err);
    for (size_t f = 0; f < mesh->n_triangles; f++) {
        sheen_texture_lattice(mesh, f, OLD, p, NULL);
        for (size_t k = 0; k < n; k++) {
            for (size_t c = 0; c < 3; c++)
                t->rgb[3 * (f * n + k) + c] = value(p + 3 * k) + (float)c;
            t->n_views[f * n + k] = 3;
        }
    }
}

static float linear(const float p[3])
{
    return 1 + 2 * p[0] - p[1] + 0.5f * p[2];
}

// Changes within a texel, and is the same wherever the place is.
static float noise(const float p[3])
{
    return 0.5f + 0.5f * sinf(900 * p[0]) * cosf(700 * p[1] + 800 * p[2]);
}

static void a_linear_texture_stays(void **state)
{
    (void)state;
    static const int sizes[] = {2, 3, 4, 5, 7, 8, 9, 13, 20};
    sheen_err err = {0};
    sheen_mesh mesh;
    sheen_texture t, other;
    float p[3 * MAX_TEXELS];
    test_figure(&mesh, 3, 0.1f, 0.02f);
    paint(&t, &mesh, linear);
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        const size_t n = sheen_texels_per_triangle(sizes[s]);
        assert_ok(sheen_texture_resample(&other, &t, sizes[s], &err), err);
        for (size_t f = 0; f < mesh.n_triangles; f++) {
            sheen_texture_lattice(&mesh, f, sizes[s], p, NULL);
            for (size_t k = 0; k < n; k++) {
                assert_close(other.rgb[3 * (f * n + k) + 1], linear(p + 3 * k) + 1, 2e-5);
                assert_int_equal(other.n_views[f * n + k], 3);
            }
        }
        sheen_texture_release(&other);
    }
    sheen_texture_release(&t);
    sheen_mesh_release(&mesh);
}

static void seams_stay_closed_and_noise_goes(void **state)
{
    (void)state;
    enum { NEW = 4 };
    sheen_err err = {0};
    sheen_mesh mesh;
    sheen_texture t, other;
    float p[2][3 * MAX_TEXELS];
    size_t n_shared = 0;
    test_figure(&mesh, 2, 0.1f, 0.02f);
    paint(&t, &mesh, noise);
    assert_ok(sheen_texture_resample(&other, &t, NEW, &err), err);
    const size_t n = sheen_texels_per_triangle(NEW);
    for (size_t f = 0; f < mesh.n_triangles; f++)
        for (size_t g = f + 1; g < mesh.n_triangles; g++) {
            sheen_texture_lattice(&mesh, f, NEW, p[0], NULL);
            sheen_texture_lattice(&mesh, g, NEW, p[1], NULL);
            for (size_t a = 0; a < n; a++)
                for (size_t b = 0; b < n; b++) {
                    const float *x = p[0] + 3 * a, *y = p[1] + 3 * b;
                    if (fabsf(x[0] - y[0]) + fabsf(x[1] - y[1]) + fabsf(x[2] - y[2]) > 1e-6f)
                        continue;
                    n_shared++;
                    assert_close(other.rgb[3 * (f * n + a)], other.rgb[3 * (g * n + b)], 1e-3);
                }
        }
    assert_true(n_shared > 3 * mesh.n_triangles);
    sheen_texture_release(&other);
    sheen_texture_release(&t);
    sheen_mesh_release(&mesh);
}

static void holes_stay_holes(void **state)
{
    (void)state;
    sheen_err err = {0};
    sheen_mesh mesh;
    sheen_texture t, other;
    test_figure(&mesh, 2, 0.1f, 0.02f);
    paint(&t, &mesh, linear);
    const size_t n = sheen_texels_per_triangle(OLD);
    memset(t.n_views + 2 * n, 0, n);                                     // a triangle
    t.n_views[5 * n + sheen_texel_index(OLD, 1, 1)] = 0;                 // one texel
    t.rgb[3 * (5 * n + sheen_texel_index(OLD, 1, 1))] = (float)INFINITY; // must not be looked at
    assert_ok(sheen_texture_resample(&other, &t, 5, &err), err);
    for (size_t f = 0; f < mesh.n_triangles; f++)
        for (size_t k = 0; k < sheen_texels_per_triangle(5); k++) {
            const size_t texel = f * sheen_texels_per_triangle(5) + k;
            assert_int_equal(other.n_views[texel] > 0, f != 2);
            assert_true(isfinite(other.rgb[3 * texel]));
        }
    sheen_texture_release(&other);
    assert_ok(sheen_texture_resample(&other, &t, OLD, &err), err); // the same lattice: the same holes
    for (size_t i = 0; i < mesh.n_triangles * n; i++)
        assert_int_equal(other.n_views[i], t.n_views[i]);
    sheen_texture_release(&other);
    assert_fails(sheen_texture_resample(&other, &t, 1, &err), err, SHEEN_EARG, "out of range");
    sheen_texture_release(&t);
    sheen_mesh_release(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_linear_texture_stays),
        cmocka_unit_test(seams_stay_closed_and_noise_goes),
        cmocka_unit_test(holes_stay_holes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// SPDX-License-Identifier: Apache-2.0
// test_simpler_model.c - a model on fewer triangles: colours and normals stay where they are.
#include "render/simpler_model.h"
#include "tests/support.h"
#include "tests/support_scene.h"

#include <math.h>

#include "base/vec.h"

enum { TEXELS = 5 };

// A ball whose colours are a smooth function of the place; one cap of it was never seen.
static void make_model(sheen_model *m)
{
    sheen_err err = {0};
    const float centre[3] = {0, 0, 0};
    sheen_model_init(m);
    test_sphere(&m->mesh, 16, centre, 0.1f);
    assert_ok(sheen_texture_init(&m->texture, m->mesh.n_triangles, TEXELS, &err), err);
    const size_t per_triangle = sheen_texels_per_triangle(TEXELS);
    for (size_t f = 0; f < m->mesh.n_triangles; f++) {
        float p[3 * 15], n[3 * 15];
        sheen_texture_lattice(&m->mesh, f, TEXELS, p, n);
        for (size_t i = 0; i < per_triangle; i++) {
            m->texture.n_views[f * per_triangle + i] = p[3 * i + 2] < 0.08f ? 3 : 0;
            for (size_t c = 0; c < 3; c++)
                m->texture.rgb[3 * (f * per_triangle + i) + c] = 0.5f + 0.4f * n[3 * i + c];
        }
    }
}

static void colours_and_normals_stay(void **state)
{
    (void)state;
    sheen_err err = {0};
    sheen_model m, simpler;
    double moved_m, colour = 0, normal = 0;
    make_model(&m);
    assert_ok(sheen_simpler_model_make(&simpler, &m, m.mesh.n_triangles / 6, &moved_m, &err), err);
    assert_in_range(simpler.mesh.n_triangles, m.mesh.n_triangles / 12, m.mesh.n_triangles / 6 + 8);
    assert_int_equal(simpler.texture.n_triangles, simpler.mesh.n_triangles);
    assert_int_equal(simpler.normals.n_triangles, simpler.mesh.n_triangles);
    assert_true(moved_m > 0 && moved_m < 0.005);
    const size_t n = simpler.mesh.n_triangles * sheen_texels_per_triangle(simpler.texture.texels_per_edge);
    size_t n_seen = 0;
    for (size_t i = 0; i < n; i++) {
        static const double nowhere[3] = {0, 0, 1};
        const sheen_hit at = sheen_texel_hit(simpler.texture.texels_per_edge, i);
        float p[3], bent[3], v[3], unit[3];
        sheen_normal_map_surface(&simpler.mesh, &simpler.normals, &at, nowhere, p, bent, v);
        for (int k = 0; k < 3; k++)
            unit[k] = p[k];
        sheen_normalizef(unit);
        if (fabsf(p[2] - 0.08f) > 0.006f)
            assert_int_equal(simpler.texture.n_views[i] > 0, p[2] < 0.08f);
        if (!simpler.texture.n_views[i])
            continue;
        n_seen++;
        normal = fmax(normal, acos(fmin(1, (double)sheen_dotf(bent, unit))));
        for (size_t c = 0; c < 3; c++)
            colour = fmax(colour, fabs((double)(simpler.texture.rgb[3 * i + c] - 0.5f - 0.4f * unit[c])));
    }
    print_message("%zu triangles from %zu: colours off by up to %.4f, normals by %.4f rad\n",
                  simpler.mesh.n_triangles, m.mesh.n_triangles, colour, normal);
    assert_true(n_seen > n / 2 && colour < 0.02 && normal < 0.05);
    sheen_simpler_model_release(&simpler);
    sheen_model_release(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(colours_and_normals_stay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// SPDX-License-Identifier: Apache-2.0
// test_surroundings.c - what is mirrored besides the lights, and lights that the mesh hides.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "render/shade.h"
#include "support.h"
#include "support_scene.h"

static void fresnel_is_schlicks(void **state)
{
    (void)state;
    assert_close(sheen_fresnel(0.04, 1), 0.04, 1e-7);
    assert_close(sheen_fresnel(0.04, 0), 1, 1e-7);
    assert_close(sheen_fresnel(0.04, 0.5f), 0.04 + 0.96 / 32, 1e-7);
    assert_close(sheen_fresnel(0.04, -0.3f), 1, 1e-7);
}

// Integrals over the sphere of products of the harmonics are 1 or 0.
static void ambient_basis_is_orthonormal(void **state)
{
    (void)state;
    double sum[SHEEN_AMBIENT_TERMS][SHEEN_AMBIENT_TERMS] = {{0}};
    enum { N = 200 };
    for (int i = 0; i < N; i++)
        for (int k = 0; k < 2 * N; k++) {
            const double z = -1 + 2 * (i + 0.5) / N, phi = 3.14159265358979 * (k + 0.5) / N,
                         r = sqrt(1 - z * z);
            const float v[3] = {(float)(r * cos(phi)), (float)(r * sin(phi)), (float)z};
            double b[SHEEN_AMBIENT_TERMS];
            sheen_ambient_basis(b, v);
            for (int m = 0; m < SHEEN_AMBIENT_TERMS; m++)
                for (int n = 0; n < SHEEN_AMBIENT_TERMS; n++)
                    sum[m][n] += b[m] * b[n] * 4 * 3.14159265358979 / (2.0 * N * N);
        }
    for (int m = 0; m < SHEEN_AMBIENT_TERMS; m++)
        for (int n = 0; n < SHEEN_AMBIENT_TERMS; n++)
            assert_close(sum[m][n], m == n, 1e-3);
}

// A board of 4 x 2 pixels of 10 cm, the first at (-0.15, -0.05); pixel (x, y) has radiance (x, y, 1).
static void make_board(sheen_surroundings *s)
{
    sheen_err err;
    *s = (sheen_surroundings){
        .present = 1, .f0 = 0.04, .board_x0_m = -0.15, .board_y0_m = -0.05, .board_pitch_m = 0.1};
    assert_ok(sheen_image_init(&s->board, 4, 2, 3, &err), err);
    for (int y = 0; y < 2; y++)
        for (int x = 0; x < 4; x++) {
            const float rgb[3] = {(float)x, (float)y, 1};
            memcpy(sheen_image_at(&s->board, x, y), rgb, sizeof rgb);
        }
    s->table_rgb[0] = 9;
}

static void the_board_is_where_the_mirrored_ray_meets_it(void **state)
{
    (void)state;
    sheen_surroundings s;
    make_board(&s);
    const float p[3] = {0, 0, 0.1f}, down[3] = {0, 0, -1}, slanted[3] = {0.70710678f, 0, -0.70710678f};
    const float far[3] = {0.999f, 0, -0.0447f}, up[3] = {0, 0, 1};
    float rgb[3];
    sheen_surroundings_radiance(rgb, &s, p, down); // (0, 0): between pixels 1 and 2, between rows 0 and 1
    assert_close(rgb[0], 1.5, 1e-5);
    assert_close(rgb[1], 0.5, 1e-5);
    sheen_surroundings_radiance(rgb, &s, p, slanted); // (0.1, 0)
    assert_close(rgb[0], 2.5, 1e-5);
    sheen_surroundings_radiance(rgb, &s, p, far); // past the picture: the table
    assert_close(rgb[0], 9, 1e-5);
    sheen_surroundings_radiance(rgb, &s, p, up); // no ambient light given
    assert_close(rgb[0], 0, 1e-7);
    s.ambient_rgb[0][1] = 2;
    sheen_surroundings_radiance(rgb, &s, p, up);
    assert_close(rgb[1], 2 * 0.28209479, 1e-6);
    s.ambient_rgb[0][1] = -2;
    sheen_surroundings_radiance(rgb, &s, p, up);
    assert_close(rgb[1], 0, 0); // never negative
    sheen_surroundings_release(&s);
    assert_null(s.board.data);
}

typedef struct shaded {
    sheen_model m;
    sheen_scene *scene;
    sheen_light_cells *cells;
    sheen_shading shading;
} shaded;

// A small triangle facing up at z = 0, and a large one 1 m above it that faces down and hides the sky on the side x > 0.
static void set_up(shaded *s)
{
    static const float corners[18] = {-0.1f, -0.1f, 0, 0.1f, -0.1f, 0, 0, 0.1f, 0,
                                      0.2f,  -5,    1, 0.2f, 5,     1, 9, 0,    1};
    static const double identity[6] = {0};
    sheen_err err;
    sheen_model_init(&s->m);
    test_triangles(&s->m.mesh, corners, 2);
    assert_ok(sheen_texture_init(&s->m.texture, 2, 2, &err), err);
    for (size_t i = 0; i < 6; i++) {
        s->m.texture.n_views[i] = 2;
        s->m.texture.rgb[3 * i] = i < 3 ? 0.1f : 0.7f;
    }
    assert_ok(sheen_model_set_lights(&s->m, 2, &err), err);
    for (int i = 0; i < 2; i++) { // one light on either side
        s->m.lights.dx[i] = i ? -0.6f : 0.6f;
        s->m.lights.dz[i] = 0.8f;
        s->m.lights.weight[i] = 1;
    }
    s->m.k_s = 1;
    s->m.sigma_rad = 0.05;
    assert_ok(sheen_scene_new(&s->scene, &s->m.mesh, &err), err);
    assert_ok(sheen_light_cells_new(&s->cells, &s->m.lights, 0.05f, &err), err);
    sheen_shading_init(&s->shading, &s->m, s->scene, s->cells, NULL, identity);
}

static void tear_down(shaded *s)
{
    sheen_light_cells_free(&s->cells);
    sheen_scene_free(&s->scene);
    sheen_model_release(&s->m);
}

static void the_mesh_hides_lights_where_it_may(void **state)
{
    (void)state;
    shaded s;
    set_up(&s);
    const float p[3] = {0, 0, 0}, n[3] = {0, 0, 1}, from_left[3] = {-0.6f, 0, 0.8f},
                from_right[3] = {0.6f, 0, 0.8f};
    float rgb[3];
    for (int shadows = 0; shadows < 2; shadows++) {
        s.m.shadows = shadows;
        sheen_shade_lights(rgb, &s.shading, p, n,
                           from_left); // mirrors the light on the right, behind the triangle
        assert_close(rgb[0], shadows ? 0 : 1 / 0.8, 1e-3);
        sheen_shade_lights(rgb, &s.shading, p, n, from_right); // the free one
        assert_close(rgb[0], 1 / 0.8, 1e-3);
    }
    assert_int_equal(sheen_shade_hidden(&s.shading, p, n, from_right), 1);
    assert_int_equal(sheen_shade_hidden(&s.shading, p, n, from_left), 0);
    tear_down(&s);
}

static void the_object_mirrors_itself_else_the_room(void **state)
{
    (void)state;
    shaded s;
    set_up(&s);
    const float p[3] = {0, 0, 0}, n[3] = {0, 0, 1}, from_left[3] = {-0.6f, 0, 0.8f},
                from_right[3] = {0.6f, 0, 0.8f};
    float rgb[3], above[3], gloss = 1;
    sheen_shade_mirrored(rgb, &s.shading, p, n, from_left, 1);
    assert_close(rgb[0], 0, 0); // the model has no surroundings
    s.m.surroundings.present = 1;
    s.m.surroundings.f0 = 0.5;
    s.m.surroundings.ambient_rgb[0][0] = 1 / 0.28209479;
    sheen_shade_mirrored(rgb, &s.shading, p, n, from_left, 1);
    assert_close(rgb[0], 0.7, 1e-6); // the other triangle's texture
    sheen_shade_mirrored(rgb, &s.shading, p, n, from_right, 1);
    assert_close(rgb[0], 1, 1e-6); // the room
    sheen_shade_split(rgb, above, &s.shading, p, n, from_right, 1);
    assert_close(rgb[0], 0, 0);
    assert_close(above[0], -0.6, 1e-6);
    sheen_shade(rgb, &s.shading, &gloss, p, n, from_right, 1); // lobe plus F times the room
    assert_close(rgb[0], 1 / 0.8 + (double)sheen_fresnel(0.5, 0.8f), 1e-3);
    tear_down(&s);
}

// An edge between black and white, 10 cm below: spread by a Gaussian it is the error function.
static void a_rough_surface_mirrors_the_board_blurred(void **state)
{
    (void)state;
    sheen_surroundings s = {.board_x0_m = -0.2, .board_y0_m = -0.2, .board_pitch_m = 0.001};
    sheen_err err;
    float rgb[3];
    const float down[3] = {0, 0, -1};
    assert_ok(sheen_image_init(&s.board, 401, 401, 3, &err), err);
    for (int y = 0; y < 401; y++)
        for (int x = 201; x < 401; x++)
            sheen_image_at(&s.board, x, y)[0] = 1;
    for (int k = -2; k <= 2; k++) {
        const double off = 0.02 * k, want = 0.5 * erfc(-k / sqrt(2.0));
        const float p[3] = {(float)off, 0.03f, 0.1f};
        sheen_surroundings_plane(rgb, &s, p, down, 0.2f);
        assert_close(rgb[0], want, 0.08);
        sheen_surroundings_plane(rgb, &s, p, down, 0);
        if (k)
            assert_close(rgb[0], k > 0, 1e-6);
    }
    // Hardly below the horizon: what the spread takes above it does not count
    const float flat[3] = {0.9999f, 0, -0.014f}, p[3] = {0, 0, 0.1f};
    s.ambient_rgb[0][1] = 100;
    sheen_surroundings_plane(rgb, &s, p, flat, 0.1f);
    assert_close(rgb[1], 0, 0);
    sheen_surroundings_release(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fresnel_is_schlicks),
        cmocka_unit_test(ambient_basis_is_orthonormal),
        cmocka_unit_test(the_board_is_where_the_mirrored_ray_meets_it),
        cmocka_unit_test(a_rough_surface_mirrors_the_board_blurred),
        cmocka_unit_test(the_mesh_hides_lights_where_it_may),
        cmocka_unit_test(the_object_mirrors_itself_else_the_room),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

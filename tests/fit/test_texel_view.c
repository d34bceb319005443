// SPDX-License-Identifier: Apache-2.0
// test_texel_view.c - which texels a photograph sees: turned away, hidden, near an edge, masked out.
#include <math.h>
#include <string.h>

#include "base/pose3.h"
#include "fit/global_texture.h"
#include "photo_scene.h"
#include "render/draw.h"
#include "support.h"
#include "support_scene.h"

static const photo_scene_options sphere = {
    .width_px = 240, .height_px = 200, .n_inputs = 4, .n_tests = 0, .n_lights = 0, .sigma_rad = 0.05};

typedef struct seen {
    photo_scene s;
    sheen_scene *rays;
    sheen_gbuffer g;
    sheen_texel_view v;
    int edge;
} seen;

static void look(seen *out, const photo_scene_options *o, int edge)
{
    sheen_err err;
    photo_scene_make(&out->s, o);
    out->edge = edge;
    const sheen_photos *p = &out->s.inputs;
    assert_ok(sheen_scene_new(&out->rays, &out->s.truth.mesh, &err), err);
    assert_ok(sheen_gbuffer_make(&out->g, out->rays, &out->s.truth.mesh, &p->cam, p->photos[0].rt_cam_obj, 1,
                                 1, &err),
              err);
    assert_ok(sheen_texel_view_init(&out->v, out->s.truth.mesh.n_triangles, edge, &err), err);
    sheen_texel_view_fill(&out->v, &out->s.truth.mesh, out->rays, &out->g, &p->cam, &p->photos[0], edge, 2);
}

static void release(seen *s)
{
    sheen_texel_view_release(&s->v);
    sheen_gbuffer_release(&s->g);
    sheen_scene_free(&s->rays);
    photo_scene_release(&s->s);
}

// On a sphere a texel is seen where n.v >= 0.2 and nowhere else; what is seen has the paint's colour.
static void a_sphere_shows_what_faces_the_camera(void **state)
{
    (void)state;
    seen s;
    look(&s, &sphere, 5);
    const size_t per_triangle = sheen_texels_per_triangle(5);
    size_t n_facing = 0, n_seen = 0;
    float p[3 * 15], n[3 * 15];
    for (size_t f = 0; f < s.s.truth.mesh.n_triangles; f++) {
        sheen_texture_lattice(&s.s.truth.mesh, f, 5, p, n);
        for (size_t k = 0; k < per_triangle; k++) {
            const size_t i = f * per_triangle + k;
            double v[3];
            for (int c = 0; c < 3; c++)
                v[c] = s.g.p_camera_obj[c] - (double)p[3 * k + (size_t)c];
            sheen_normalize(v);
            const double nd[3] = {(double)n[3 * k], (double)n[3 * k + 1], (double)n[3 * k + 2]};
            const double cosine = sheen_dot(nd, v);
            n_facing += cosine > 0.3;
            n_seen += cosine > 0.3 && s.v.seen[i];
            if (cosine < 0.199)
                assert_int_equal(s.v.seen[i], 0);
            if (s.v.seen[i])
                for (size_t c = 0; c < 3; c++)
                    assert_close(s.v.rgb[3 * i + c], s.s.truth.texture.rgb[3 * i + c], 0.03);
        }
    }
    assert_true(n_seen == n_facing);
    release(&s);
}

// On a figure whose bumps hide one another no seen texel is behind anything: checked by trying every triangle.
static void nothing_is_seen_through_the_figure(void **state)
{
    (void)state;
    seen s;
    photo_scene_options o = sphere;
    o.bumpy = 1;
    look(&s, &o, 3);
    const size_t per_triangle = sheen_texels_per_triangle(3);
    float p[3 * 6];
    size_t n_tried = 0;
    for (size_t f = 0; f < s.s.truth.mesh.n_triangles; f += 9) {
        sheen_texture_lattice(&s.s.truth.mesh, f, 3, p, NULL);
        for (size_t k = 0; k < per_triangle; k++) {
            if (!s.v.seen[f * per_triangle + k])
                continue;
            double v[3], from[3] = {s.g.p_camera_obj[0], s.g.p_camera_obj[1], s.g.p_camera_obj[2]};
            for (int c = 0; c < 3; c++)
                v[c] = (double)p[3 * k + (size_t)c] - from[c];
            const double distance_m = sheen_normalize(v);
            const sheen_hit h = test_first_hit(&s.s.truth.mesh, from, v);
            assert_true(h.triangle == SHEEN_NO_HIT || (double)h.t_m > distance_m - 1e-4);
            n_tried++;
        }
    }
    assert_true(n_tried > 100);
    release(&s);
}

static void a_mask_and_the_image_edge_are_respected(void **state)
{
    (void)state;
    seen s;
    sheen_err err;
    look(&s, &sphere, 3);
    size_t before = 0, after = 0;
    for (size_t i = 0; i < s.v.n_texels; i++)
        before += s.v.seen[i];
    sheen_photo *photo = &s.s.inputs.photos[0];
    assert_ok(sheen_image_init(&photo->mask, 240, 200, 1, &err), err); // left half: object
    for (int y = 0; y < 200; y++)
        for (int x = 0; x < 120; x++)
            *sheen_image_at(&photo->mask, x, y) = 1;
    sheen_texel_view_fill(&s.v, &s.s.truth.mesh, s.rays, &s.g, &s.s.inputs.cam, photo, 3, 1);
    for (size_t i = 0; i < s.v.n_texels; i++)
        after += s.v.seen[i];
    assert_true(after > before / 4 && after < before * 3 / 4);
    release(&s);
}

static void texels_are_as_fine_as_the_pictures(void **state)
{
    (void)state;
    seen s;
    look(&s, &sphere, 3);
    sheen_photos *p = &s.s.inputs;
    const int edge = sheen_texels_per_edge_for(&s.s.truth.mesh, p);
    assert_true(edge >= 5 && edge <= 14); // sides of about 1/10 radian of a sphere of 60 px
    p->cam.intrinsics[0] *= 2;
    const int finer = sheen_texels_per_edge_for(&s.s.truth.mesh, p);
    assert_true(finer > edge && finer <= 2 * edge);
    p->cam.intrinsics[0] *= 1000;
    assert_int_equal(sheen_texels_per_edge_for(&s.s.truth.mesh, p), SHEEN_TEXTURE_MAX_EDGE);
    p->cam.intrinsics[0] /= 1e7;
    assert_int_equal(sheen_texels_per_edge_for(&s.s.truth.mesh, p), SHEEN_TEXTURE_MIN_EDGE);
    release(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sphere_shows_what_faces_the_camera),
        cmocka_unit_test(nothing_is_seen_through_the_figure),
        cmocka_unit_test(a_mask_and_the_image_edge_are_respected),
        cmocka_unit_test(texels_are_as_fine_as_the_pictures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

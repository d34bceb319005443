// SPDX-License-Identifier: Apache-2.0
// test_draw.c - pictures of a model against a plain renderer, and against what a mirrored sphere must look
// like.
#include "render/draw.h"
#include "render/draw_geometry.h"
#include "tests/support.h"
#include "tests/support_scene.h"

#include <math.h>
#include <string.h>

#include "base/pose3.h"
#include "base/vec.h"
#include "render/gbuffer.h"

static void make_lights(sheen_model *m, size_t n)
{
    uint64_t seed = 9;
    sheen_err err = {0};
    assert_ok(sheen_model_set_lights(m, n, &err), err);
    for (size_t i = 0; i < n; i++) {
        float d[3];
        do
            test_direction(d, &seed);
        while (d[2] < 0);
        m->lights.dx[i] = d[0];
        m->lights.dy[i] = d[1];
        m->lights.dz[i] = d[2];
        m->lights.weight[i] = (float)(0.2 + test_random(&seed));
    }
}

static void paint(sheen_model *m, int texels_per_edge)
{
    sheen_err err = {0};
    uint64_t seed = 6;
    assert_ok(sheen_texture_init(&m->texture, m->mesh.n_triangles, texels_per_edge, &err), err);
    const size_t n = m->mesh.n_triangles * sheen_texels_per_triangle(texels_per_edge);
    for (size_t i = 0; i < n; i++) {
        // single texels that were not seen, and whole triangles
        m->texture.n_views[i] = i % 7 && i / sheen_texels_per_triangle(texels_per_edge) % 5 ? 2 : 0;
        for (size_t c = 0; c < 3; c++)
            m->texture.rgb[3 * i + c] = (float)test_random(&seed);
    }
}

static void make_model(sheen_model *m)
{
    sheen_model_init(m);
    test_figure(&m->mesh, 4, 0.1f, 0.04f);
    paint(m, 4);
    make_lights(m, 40);
    m->k_s = 0.7;
    m->sigma_rad = 0.08;
    m->light_rgb[0] = 1.2;
    m->light_rgb[2] = 0.8;
    m->rt_world_obj[1] = 0.3;
    m->rt_world_obj[4] = 2;
    memcpy(m->method, "paper", 6);
}

// One sample as the header describes it, by the plain ray tracer and the sum in double precision.
static void sample_ref(double out[8], const sheen_model *m, const sheen_draw_options *o,
                       const double origin[3], const double v[3])
{
    memset(out, 0, 8 * sizeof *out);
    const sheen_hit hit = test_first_hit(&m->mesh, origin, v);
    if (hit.triangle == SHEEN_NO_HIT)
        return;
    out[6] = 1;
    float rgb[3], n_obj[3], v_obj[3];
    if (sheen_texture_sample(&m->texture, &hit, rgb) == 0) {
        out[7] = 1;
        if (o->mark_holes)
            memcpy(rgb, o->hole_rgb, sizeof rgb);
    }
    sheen_hit_surface(&m->mesh, &hit, origin, NULL, n_obj, v_obj);
    const double cosine = (double)sheen_dotf(n_obj, v_obj);
    if (cosine < 0.01) { // bent towards the camera
        float across[3];
        for (int k = 0; k < 3; k++)
            across[k] = n_obj[k] - (float)cosine * v_obj[k];
        sheen_normalizef(across);
        for (int k = 0; k < 3; k++)
            n_obj[k] = across[k] * sqrtf(1 - 1e-4f) + 0.01f * v_obj[k];
    }
    sheen_Rt Rt;
    sheen_Rt_from_rt(&Rt, m->rt_world_obj);
    const double nd[3] = {(double)n_obj[0], (double)n_obj[1], (double)n_obj[2]};
    const double vd[3] = {(double)v_obj[0], (double)v_obj[1], (double)v_obj[2]};
    double n_world[3], v_world[3];
    sheen_Rt_direction(n_world, &Rt, nd);
    sheen_Rt_direction(v_world, &Rt, vd);
    const float n_f[3] = {(float)n_world[0], (float)n_world[1], (float)n_world[2]};
    const float v_f[3] = {(float)v_world[0], (float)v_world[1], (float)v_world[2]};
    const double sum = sheen_lobe_sum_ref(&m->lights, n_f, v_f, (float)m->sigma_rad);
    for (int c = 0; c < 3; c++) {
        out[c] = (double)rgb[c];
        out[3 + c] = m->k_s * m->light_rgb[c] * sum;
    }
}

static void pixel_ref(double out[8], const sheen_model *m, const sheen_camera *cam,
                      const sheen_Rt *Rt_obj_cam, const sheen_draw_options *o, int x, int y)
{
    const int n = o->samples_per_side;
    memset(out, 0, 8 * sizeof *out);
    for (int sy = 0; sy < n; sy++)
        for (int sx = 0; sx < n; sx++) {
            const double q[2] = {x + (sx + 0.5) / n - 0.5, y + (sy + 0.5) / n - 0.5};
            double v[3], one[8];
            assert_int_equal(sheen_camera_unproject(cam, v, q, 1, NULL), SHEEN_OK);
            sheen_Rt_direction(v, Rt_obj_cam, v);
            sample_ref(one, m, o, Rt_obj_cam->t, v);
            for (int k = 0; k < 8; k++)
                out[k] += one[k] / (n * n);
        }
}

// Pixels that a triangle's edge crosses may differ where a ray goes to the other side; count those.
static size_t compare_pixel(const sheen_layers *l, const double want[8], const sheen_draw_options *o, int x,
                            int y)
{
    double worst = 0;
    for (int c = 0; c < 3; c++) {
        const double composite = want[c] + want[3 + c] + (1 - want[6]) * (double)o->background_rgb[c];
        worst = fmax(worst, fabs((double)sheen_image_at(&l->diffuse, x, y)[c] - want[c]));
        worst = fmax(worst,
                     fabs((double)sheen_image_at(&l->specular, x, y)[c] - want[3 + c]) / (1 + want[3 + c]));
        worst = fmax(worst,
                     fabs((double)sheen_image_at(&l->composite, x, y)[c] - composite) / (1 + composite));
    }
    worst = fmax(worst, fabs((double)*sheen_image_at(&l->coverage, x, y) - want[6]));
    worst = fmax(worst, fabs((double)*sheen_image_at(&l->holes, x, y) - want[7]));
    return worst > 4e-3;
}

static void agrees_with_a_plain_renderer(void **state)
{
    (void)state;
    sheen_model m;
    sheen_drawing *d;
    sheen_camera cam;
    sheen_layers l;
    sheen_err err = {0};
    double rt_cam_obj[6];
    make_model(&m);
    test_camera(&cam, 64, 50, 80, 1);
    test_look(rt_cam_obj, 0.25, -0.2, 0.22);
    const sheen_draw_options o = {
        .samples_per_side = 2, .hole_rgb = {1, 0, 1}, .mark_holes = 1, .background_rgb = {0.1f, 0.2f, 0.3f}};
    assert_ok(sheen_drawing_new(&d, &m, &err), err);
    assert_ok(sheen_draw(&l, d, &cam, rt_cam_obj, NULL, &o, &err), err);
    sheen_Rt Rt_cam_obj, Rt_obj_cam;
    sheen_Rt_from_rt(&Rt_cam_obj, rt_cam_obj);
    sheen_Rt_invert(&Rt_obj_cam, &Rt_cam_obj);
    size_t n_off = 0, n_object = 0, n_holes = 0;
    double brightest = 0;
    for (int y = 0; y < cam.height_px; y++)
        for (int x = 0; x < cam.width_px; x++) {
            double want[8];
            pixel_ref(want, &m, &cam, &Rt_obj_cam, &o, x, y);
            n_off += compare_pixel(&l, want, &o, x, y);
            n_object += want[6] > 0;
            n_holes += want[7] > 0;
            brightest = fmax(brightest, want[3]);
        }
    print_message("%zu of %zu pixels differ, %zu with holes, highlights to %.2f\n", n_off, n_object, n_holes,
                  brightest);
    assert_true(n_object > 800 && n_holes > 10 && brightest > 0.3);
    assert_in_range(n_off, 0, n_object / 200);
    sheen_layers_release(&l);
    sheen_drawing_free(&d);
    sheen_model_release(&m);
}

// One light, one white sphere far away: the brightest point must lie where the normal halves the directions
// to the camera and to the light, and nowhere else.
static void highlight_lies_in_the_mirror_direction(void **state)
{
    (void)state;
    static const float centre[3] = {0.01f, -0.02f, 0.015f};
    sheen_model m;
    sheen_err err = {0};
    sheen_model_init(&m);
    test_sphere(&m.mesh, 40, centre, 0.1f);
    paint(&m, 2);
    make_lights(&m, 1);
    m.k_s = 1;
    m.sigma_rad = 0.02;
    m.rt_world_obj[2] = 0.7; // the object stands turned under the light
    const float light_world[3] = {0.48f, 0.6f, 0.64f};
    m.lights.dx[0] = light_world[0];
    m.lights.dy[0] = light_world[1];
    m.lights.dz[0] = light_world[2];
    m.lights.weight[0] = 1;
    sheen_camera cam;
    double rt_cam_obj[6];
    test_camera(&cam, 320, 240, 900, 1);
    test_look(rt_cam_obj, 0.3, 0.6, 0.5);
    sheen_drawing *d;
    sheen_layers l;
    assert_ok(sheen_drawing_new(&d, &m, &err), err);
    assert_ok(sheen_draw(&l, d, &cam, rt_cam_obj, NULL, NULL, &err), err);

    double sum = 0, at[2] = {0, 0};
    for (int y = 0; y < cam.height_px; y++)
        for (int x = 0; x < cam.width_px; x++) {
            const double s = (double)sheen_image_at(&l.specular, x, y)[0];
            sum += s;
            at[0] += s * x;
            at[1] += s * y;
        }
    assert_true(sum > 5);
    // The mirror point on the sphere by iteration: n halves v and l, and v depends on the point.
    sheen_Rt Rt_world_obj, Rt_obj_world, Rt_cam_obj, Rt_obj_cam;
    sheen_Rt_from_rt(&Rt_world_obj, m.rt_world_obj);
    sheen_Rt_invert(&Rt_obj_world, &Rt_world_obj);
    sheen_Rt_from_rt(&Rt_cam_obj, rt_cam_obj);
    sheen_Rt_invert(&Rt_obj_cam, &Rt_cam_obj);
    double light[3] = {(double)light_world[0], (double)light_world[1], (double)light_world[2]},
           n[3] = {0, 0, 1};
    sheen_Rt_direction(light, &Rt_obj_world, light);
    double p[3], q[2];
    for (int i = 0; i < 50; i++) {
        double v[3];
        for (int k = 0; k < 3; k++) {
            p[k] = (double)centre[k] + 0.1 * n[k];
            v[k] = Rt_obj_cam.t[k] - p[k];
        }
        sheen_normalize(v);
        for (int k = 0; k < 3; k++)
            n[k] = v[k] + light[k];
        sheen_normalize(n);
    }
    sheen_Rt_point(p, &Rt_cam_obj, p);
    assert_ok(sheen_camera_project(&cam, q, NULL, p, 1, &err), err);
    assert_close(at[0] / sum, q[0], 0.15);
    assert_close(at[1] / sum, q[1], 0.15);
    sheen_layers_release(&l);
    sheen_drawing_free(&d);
    sheen_model_release(&m);
}

// Every pixel of a lit sphere's outline is lit: no black specks where interpolated normals face away.
static void no_specks_along_the_outline(void **state)
{
    (void)state;
    static const float centre[3] = {0, 0, 0};
    sheen_model m;
    sheen_err err = {0};
    sheen_model_init(&m);
    test_sphere(&m.mesh, 6, centre, 0.1f);
    paint(&m, 2);
    make_lights(&m, 1000);
    m.k_s = 1;
    m.sigma_rad = 0.5; // light from everywhere above
    sheen_camera cam;
    double rt_cam_obj[6];
    test_camera(&cam, 200, 160, 300, 0);
    test_look(rt_cam_obj, 0.1, 0.05, 0.4);
    sheen_drawing *d;
    sheen_layers l;
    assert_ok(sheen_drawing_new(&d, &m, &err), err);
    assert_ok(sheen_draw(&l, d, &cam, rt_cam_obj, NULL, NULL, &err), err);
    size_t n_edge = 0;
    for (int y = 0; y < cam.height_px; y++)
        for (int x = 0; x < cam.width_px; x++) {
            const float coverage = *sheen_image_at(&l.coverage, x, y);
            if (coverage == 0)
                continue;
            assert_true(sheen_image_at(&l.specular, x, y)[0] > 1 * coverage);
            n_edge += coverage < 1;
        }
    assert_true(n_edge > 100);
    sheen_layers_release(&l);
    sheen_drawing_free(&d);
    sheen_model_release(&m);
}

// A red half of the highlights, of nodes and lamps alike.
static void scaled_highlights_are_scaled(void **state)
{
    (void)state;
    sheen_model m;
    sheen_camera cam;
    sheen_drawing *d;
    sheen_layers layers[2];
    sheen_err err = {0};
    double rt_cam_obj[6];
    const sheen_lamp lamp = {.direction_world = {0, 0, 1}, .inverse_distance_per_m = 0.3f, .rgb = {3, 2, 1}};
    make_model(&m);
    assert_ok(sheen_model_set_lamps(&m, &lamp, 1, &err), err);
    test_camera(&cam, 60, 50, 70, 0);
    test_look(rt_cam_obj, 0.4, 0.5, 0.3);
    const double half[3] = {0.5, 0, 0};
    for (int i = 0; i < 2; i++) {
        if (i)
            sheen_model_scale_highlights(&m, half);
        assert_ok(sheen_drawing_new(&d, &m, &err), err);
        assert_ok(sheen_draw(&layers[i], d, &cam, rt_cam_obj, NULL, NULL, &err), err);
        sheen_drawing_free(&d);
    }
    double brightest = 0;
    for (size_t i = 0; i < (size_t)60 * 50; i++) {
        const float *was = layers[0].specular.data + 3 * i, *is = layers[1].specular.data + 3 * i;
        brightest = fmax(brightest, (double)was[0]);
        assert_close((double)is[0], 0.5 * (double)was[0], 1e-3); // what adds next to nothing may be left out
        assert_close((double)is[1] + (double)is[2], 0, 1e-9);
    }
    assert_true(brightest > 0.5);
    sheen_layers_release(&layers[0]);
    sheen_layers_release(&layers[1]);
    sheen_model_release(&m);
}

static void threads_change_nothing(void **state)
{
    (void)state;
    sheen_model m;
    sheen_drawing *d;
    sheen_camera cam;
    sheen_layers one, four;
    sheen_err err = {0};
    double rt_cam_obj[6];
    make_model(&m);
    test_camera(&cam, 120, 90, 140, 1);
    test_look(rt_cam_obj, 0.25, -0.2, 0.22);
    assert_ok(sheen_drawing_new(&d, &m, &err), err);
    sheen_draw_options o = {.n_threads = 1};
    assert_ok(sheen_draw(&one, d, &cam, rt_cam_obj, NULL, &o, &err), err);
    o.n_threads = 4;
    assert_ok(sheen_draw(&four, d, &cam, rt_cam_obj, NULL, &o, &err), err);
    assert_memory_equal(one.composite.data, four.composite.data, 120 * 90 * 3 * sizeof(float));
    assert_memory_equal(one.holes.data, four.holes.data, 120 * 90 * sizeof(float));
    sheen_layers_release(&one);
    sheen_layers_release(&four);
    sheen_drawing_free(&d);
    sheen_model_release(&m);
}

// A second picture in the layers of a first is the same as a fresh one; layers not asked for stay empty.
static void drawn_again_is_the_same(void **state)
{
    (void)state;
    sheen_model m;
    sheen_drawing *d;
    sheen_camera cam;
    sheen_layers fresh, again = {0};
    sheen_err err = {0};
    double rt_first[6], rt_second[6];
    make_model(&m);
    test_camera(&cam, 120, 90, 140, 0);
    test_look(rt_first, 0.25, -0.2, 0.22);
    test_look(rt_second, -0.3, 0.25, 0.3);
    assert_ok(sheen_drawing_new(&d, &m, &err), err);
    const sheen_draw_options o = {.background_rgb = {0.25f, 0.5f, 0.75f}};
    assert_ok(sheen_draw(&fresh, d, &cam, rt_second, NULL, &o, &err), err);
    assert_ok(sheen_redraw(&again, d, &cam, rt_first, NULL, &o, &err), err);
    const float *kept = again.composite.data;
    assert_ok(sheen_redraw(&again, d, &cam, rt_second, NULL, &o, &err), err);
    assert_ptr_equal(again.composite.data, kept);
    assert_memory_equal(fresh.composite.data, again.composite.data, 120 * 90 * 3 * sizeof(float));
    assert_memory_equal(fresh.diffuse.data, again.diffuse.data, 120 * 90 * 3 * sizeof(float));
    assert_memory_equal(fresh.coverage.data, again.coverage.data, 120 * 90 * sizeof(float));
    sheen_draw_options one = o;
    one.layers = SHEEN_LAYER_SPECULAR;
    assert_ok(sheen_redraw(&again, d, &cam, rt_second, NULL, &one, &err), err);
    assert_null(again.composite.data);
    assert_memory_equal(fresh.specular.data, again.specular.data, 120 * 90 * 3 * sizeof(float));
    sheen_layers_release(&again);
    sheen_layers_release(&fresh);
    sheen_drawing_free(&d);
    sheen_model_release(&m);
}

// Depth, normal and mask of a sphere, which has formulas for them.
static void geometry_of_a_sphere(void **state)
{
    (void)state;
    static const float centre[3] = {0.01f, 0.02f, 0.03f};
    sheen_model m;
    sheen_drawing *d;
    sheen_camera cam;
    sheen_geometry g;
    sheen_err err = {0};
    double rt_cam_obj[6], centre_cam[3] = {(double)centre[0], (double)centre[1], (double)centre[2]};
    sheen_model_init(&m);
    test_sphere(&m.mesh, 60, centre, 0.1f);
    paint(&m, 2);
    make_lights(&m, 10);
    m.k_s = 1;
    m.sigma_rad = 0.1;
    test_camera(&cam, 200, 160, 300, 1);
    test_look(rt_cam_obj, 0.1, 0.05, 0.4);
    sheen_Rt Rt_cam_obj;
    sheen_Rt_from_rt(&Rt_cam_obj, rt_cam_obj);
    sheen_Rt_point(centre_cam, &Rt_cam_obj, centre_cam);
    assert_ok(sheen_drawing_new(&d, &m, &err), err);
    assert_ok(sheen_draw_geometry(&g, d, &cam, rt_cam_obj, 0, &err), err);
    size_t n = 0;
    for (int y = 0; y < cam.height_px; y++)
        for (int x = 0; x < cam.width_px; x++) {
            const double q_px[2] = {x, y};
            double v[3], across[3];
            assert_int_equal(sheen_camera_unproject(&cam, v, q_px, 1, NULL), SHEEN_OK);
            sheen_cross(across, v, centre_cam);
            const double miss_m = sheen_norm(across), half2 = 0.01 - miss_m * miss_m;
            const float mask = *sheen_image_at(&g.mask, x, y);
            if (fabs(miss_m - 0.1) > 2e-4)
                assert_close(mask, half2 > 0, 0);
            if (half2 < 1e-3 || mask == 0)
                continue;
            const double t_m = sheen_dot(v, centre_cam) - sqrt(half2);
            const float *normal = sheen_image_at(&g.n_cam, x, y);
            assert_close(*sheen_image_at(&g.depth_m, x, y), t_m * v[2], 3e-5);
            for (int k = 0; k < 3; k++)
                assert_close(normal[k], (t_m * v[k] - centre_cam[k]) / 0.1, 2e-3);
            n++;
        }
    assert_true(n > 3000);
    sheen_geometry_release(&g);
    sheen_drawing_free(&d);
    sheen_model_release(&m);
}

static void nothing_in_view_is_background(void **state)
{
    (void)state;
    sheen_model m;
    sheen_drawing *d;
    sheen_camera cam;
    sheen_layers l;
    sheen_err err = {0};
    const double rt_cam_obj[6] = {0, 0, 0, 0, 0, -1};
    make_model(&m);
    test_camera(&cam, 20, 10, 20, 0);
    assert_ok(sheen_drawing_new(&d, &m, &err), err);
    const sheen_draw_options o = {.background_rgb = {0.25f, 0.5f, 0.75f}};
    assert_ok(sheen_draw(&l, d, &cam, rt_cam_obj, NULL, &o, &err), err);
    for (int i = 0; i < 200; i++) {
        assert_close(l.composite.data[3 * i + 1], 0.5, 0);
        assert_close(l.coverage.data[i], 0, 0);
    }
    sheen_layers_release(&l);
    sheen_drawing_free(&d);
    sheen_model_release(&m);
}

static void says_what_is_wrong(void **state)
{
    (void)state;
    sheen_model m;
    sheen_drawing *d;
    sheen_camera cam;
    sheen_layers l;
    sheen_err err = {0};
    double rt[6] = {0, 0, 0, 0, 0, 1}, bad[6] = {0, (double)INFINITY, 0, 0, 0, 0};
    make_model(&m);
    test_camera(&cam, 20, 10, 20, 0);
    assert_ok(sheen_drawing_new(&d, &m, &err), err);
    assert_fails(sheen_draw(&l, d, &cam, bad, NULL, NULL, &err), err, SHEEN_EARG, "not finite");
    assert_fails(sheen_draw(&l, d, &cam, rt, bad, NULL, &err), err, SHEEN_EARG, "not finite");
    const sheen_draw_options o = {.samples_per_side = 99};
    assert_fails(sheen_draw(&l, d, &cam, rt, NULL, &o, &err), err, SHEEN_EARG, "99 samples");
    sheen_drawing_free(&d);
    m.sigma_rad = 0;
    assert_fails(sheen_drawing_new(&d, &m, &err), err, SHEEN_EARG, "roughness");
    m.sigma_rad = 1;
    m.texture.n_triangles--;
    assert_fails(sheen_drawing_new(&d, &m, &err), err, SHEEN_EARG, "triangles");
    assert_null(d);
    sheen_model_release(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(agrees_with_a_plain_renderer),
        cmocka_unit_test(highlight_lies_in_the_mirror_direction),
        cmocka_unit_test(no_specks_along_the_outline),
        cmocka_unit_test(scaled_highlights_are_scaled),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(drawn_again_is_the_same),
        cmocka_unit_test(geometry_of_a_sphere),
        cmocka_unit_test(nothing_in_view_is_background),
        cmocka_unit_test(says_what_is_wrong),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

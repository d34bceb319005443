// SPDX-License-Identifier: Apache-2.0
// test_gltf.c - charts, the panorama and the glTF file of a small figure: what other programs rely on.
#include "render/gltf.h"
#include "tests/support.h"
#include "tests/support_scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "render/draw.h"
#include "render/gltf_surface.h"
#include "render/gltf_view.h"
#include "render/panorama.h"
#include "render/simplify.h"
#include "render/surface_picture.h"

static const double no_turn[6] = {0};

static void make_model(sheen_model *m)
{
    sheen_err err = {0};
    sheen_model_init(m);
    test_figure(&m->mesh, 6, 0.1f, 0.02f);
    memcpy(m->method, "paper", sizeof "paper");
    m->frequency = 3;
    m->n_hemisphere = 46;
    m->k_s = 2;
    m->sigma_rad = 0.1;
    assert_ok(sheen_model_set_lights(m, 2, &err), err);
    for (size_t i = 0; i < 2; i++) {
        m->node[i] = (uint32_t)i;
        m->radiance[i] = 1;
        m->lights.weight[i] = (float)(2 * 3.14159265358979323846 / 46);
        m->lights.dz[i] = i ? 0 : 1;
        m->lights.dx[i] = i ? 1 : 0;
    }
    assert_ok(sheen_texture_init(&m->texture, m->mesh.n_triangles, 4, &err), err);
    for (size_t i = 0; i < m->mesh.n_triangles * 10; i++) {
        m->texture.n_views[i] = i % 29 != 0;
        for (size_t c = 0; c < 3; c++)
            m->texture.rgb[3 * i + c] = 0.1f + 0.1f * (float)c;
    }
}

// No pixel shows two places, every triangle has its corners where the picture says, and nothing leaves the picture.
static void charts_lie_side_by_side(void **state)
{
    (void)state;
    sheen_err err = {0};
    sheen_mesh mesh;
    sheen_charts c;
    test_figure(&mesh, 8, 0.1f, 0.03f);
    assert_ok(sheen_charts_make(&c, &mesh, 0.002, 1024, &err), err);
    assert_int_equal(c.n_triangles, mesh.n_triangles);
    assert_true(c.n_vertices >= mesh.n_vertices);
    double area_px = 0;
    for (size_t i = 0; i < 3 * c.n_triangles; i++)
        assert_int_equal(c.vertex[c.triangles[i]], mesh.triangles[i]);
    for (size_t i = 0; i < 2 * c.n_vertices; i++)
        assert_true(c.q_px[i] >= 1 && c.q_px[i] <= (float)c.side_px - 1);
    for (size_t i = 0; i < c.n_triangles; i++) {
        const float *a = c.q_px + 2 * (size_t)c.triangles[3 * i],
                    *b = c.q_px + 2 * (size_t)c.triangles[3 * i + 1],
                    *d = c.q_px + 2 * (size_t)c.triangles[3 * i + 2];
        area_px += 0.5 * fabs((double)((b[0] - a[0]) * (d[1] - a[1]) - (b[1] - a[1]) * (d[0] - a[0])));
    }
    const size_t n = (size_t)c.side_px * (size_t)c.side_px;
    sheen_chart_place *places = malloc(n * sizeof *places);
    assert_non_null(places);
    sheen_charts_places(places, &c);
    double covered_px = 0;
    for (size_t i = 0; i < n; i++)
        covered_px += places[i].triangle != SHEEN_CHART_EMPTY;
    assert_close(covered_px / area_px, 1, 0.02); // overlaps would cover less than the triangles' area
    free(places);
    sheen_charts_release(&c);
    sheen_mesh_release(&mesh);
}

static void a_light_stands_in_the_panorama_with_its_power(void **state)
{
    (void)state;
    sheen_err err = {0};
    sheen_model m;
    sheen_image sky;
    double R[3][3] = {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};
    make_model(&m);
    assert_ok(sheen_panorama_make(&sky, &m, no_turn, R, 64, &err), err);
    assert_ok(sheen_panorama_add_lights(&sky, &m, no_turn, R, 0.04, &err), err);
    const double want = 8 * 3.14159265358979323846 * 0.01 * 2 / 0.04 * (double)m.lights.weight[0];
    double power = 0, at_zenith = 0;
    for (int y = 0; y < sky.height_px; y++)
        for (int x = 0; x < sky.width_px; x++) {
            const double light = (double)sheen_image_at(&sky, x, y)[1] * sheen_panorama_pixel_sr(&sky, y);
            power += light;
            at_zenith += y < 8 ? light : 0;
        }
    assert_close(power / (2 * want), 1, 0.1);
    assert_close(at_zenith / want, 1, 0.2);
    assert_true(sheen_image_at(&sky, sky.width_px / 2, sky.height_px / 2)[0] > 0); // +x is in the middle
    // What falls on a surface that faces the light at +x.
    const float n[6] = {1, 0, 0, -1, 0, 0};
    float E[6];
    assert_ok(sheen_panorama_irradiance(E, n, 2, &sky, &err), err);
    assert_close((double)E[1] / want, 1, 0.1);
    assert_close((double)E[4] / want, 0, 0.06); // the other light, at the zenith, is a wide disc
    sheen_image_release(&sky);
    sheen_model_release(&m);
}

static sheen_gltf_options options_of(size_t max_triangles, int n_lights)
{
    return (sheen_gltf_options){.title = "a \"figure\"",
                                .rt_board_obj = no_turn,
                                .rt_world_obj = no_turn,
                                .max_triangles = max_triangles,
                                .max_side_px = 512,
                                .jpeg_quality = 90,
                                .n_lights = n_lights};
}

// A lamp a metre from the object's middle, two from the origin that it is stated from, and one far away.
static void add_lamps(sheen_model *m)
{
    sheen_err err = {0};
    float centre[3], radius_m;
    sheen_mesh_sphere(&m->mesh, centre, &radius_m);
    const sheen_lamp lamps[2] = {
        {.direction_world = {1, 0, 0}, .inverse_distance_per_m = 0.5f, .radius_rad = 0.1f, .rgb = {3, 2, 1}},
        {.direction_world = {0, 0, 1}, .rgb = {1, 1, 1}}};
    m->lobe_tail = 0.5;
    assert_ok(sheen_model_set_lights(m, 0, &err), err);
    assert_ok(sheen_model_set_lamps(m, lamps, 2, &err), err);
    // The object's middle is halfway between the lamps' origin and the first lamp.
    for (int k = 0; k < 3; k++)
        m->lamp_origin_world[k] = (double)centre[k] - (k == 0 ? 1 : 0);
}

static void a_near_lamp_shines_in_the_panorama_as_on_the_middle(void **state)
{
    (void)state;
    sheen_err err = {0};
    sheen_model m;
    sheen_image sky;
    double R[3][3] = {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};
    make_model(&m);
    add_lamps(&m);
    assert_ok(sheen_panorama_make(&sky, &m, no_turn, R, 128, &err), err);
    assert_ok(sheen_panorama_add_lights(&sky, &m, no_turn, R, 0.04, &err), err);
    const double gain = 8 * 3.14159265358979323846 * 0.01 * 1.5 / 0.04;
    double power[3] = {0};
    for (int y = 20; y < sky.height_px; y++) // the other is at the zenith
        for (int x = 0; x < sky.width_px; x++)
            for (int c = 0; c < 3; c++)
                power[c] += (double)sheen_image_at(&sky, x, y)[c] * sheen_panorama_pixel_sr(&sky, y);
    // At half the distance it is four times as bright, and twice as wide.
    for (int c = 0; c < 3; c++)
        assert_close(power[c] / (4 * gain * (3 - c)), 1, 1e-4);
    assert_true(sheen_image_at(&sky, 128, 64 + 6)[0] > 0);
    assert_true(sheen_image_at(&sky, 128, 64 + 10)[0] <= 0);
    sheen_image_release(&sky);
    sheen_model_release(&m);
}

// The node's translation says where a near lamp stands, its intensity is in candela.
static void a_near_lamp_is_a_point_light(void **state)
{
    (void)state;
    sheen_err err = {0};
    sheen_model m;
    sheen_gltf g;
    const char *text;
    double at[3] = {0}, candela = 0;
    make_model(&m);
    add_lamps(&m);
    const sheen_gltf_options o = options_of(m.mesh.n_triangles, 4);
    assert_ok(sheen_gltf_make(&g, &m, &o, &err), err);
    assert_int_equal(g.n_lights, 2);
    assert_close(g.roughness, sqrt(1.66 * 0.1), 1e-9);
    char json[8192] = {0};
    memcpy(json, g.glb + 20, sizeof json - 1 < g.glb_bytes - 20 ? sizeof json - 1 : g.glb_bytes - 20);
    assert_non_null(text = strstr(json, "\"translation\""));
    assert_int_equal(sscanf(strchr(text, '[') + 1, "%lf,%lf,%lf", at, at + 1, at + 2), 3);
    assert_close(at[0] - g.middle_gltf[0], 1, 1e-5);
    assert_close(at[1] - g.middle_gltf[1], 0, 1e-5);
    assert_close(at[2] - g.middle_gltf[2], 0, 1e-5);
    assert_non_null(text = strstr(json, "\"point\""));
    assert_non_null(text = strstr(text, "\"intensity\""));
    assert_int_equal(sscanf(strchr(text, ':') + 1, "%lf", &candela), 1);
    assert_close(candela / (4 * 3 * 8 * 3.14159265358979323846 * 0.01 * 1.5 / 0.04), 1, 1e-4);
    assert_non_null(strstr(json, "\"directional\""));
    sheen_gltf_release(&g);
    sheen_model_release(&m);
}

static void fewer_triangles_stay_near(void **state)
{
    (void)state;
    sheen_err err = {0};
    sheen_mesh mesh, simple;
    double moved_m;
    const float centre[3] = {0, 0, 0};
    test_sphere(&mesh, 16, centre, 0.1f);
    assert_ok(sheen_mesh_simplify(&simple, &mesh, mesh.n_triangles / 4, &moved_m, &err), err);
    assert_in_range(simple.n_triangles, mesh.n_triangles / 8, mesh.n_triangles / 4 + 8);
    assert_true(moved_m > 0 && moved_m < 0.01);
    for (size_t i = 0; i < simple.n_vertices; i++)
        assert_close(sqrtf(sheen_dotf(simple.p_obj + 3 * i, simple.p_obj + 3 * i)), 0.1, 1e-3);
    sheen_mesh_release(&simple);
    sheen_mesh_release(&mesh);
}

static void our_own_reader_reads_the_file(void **state)
{
    (void)state;
    sheen_err err = {0};
    sheen_model m;
    sheen_gltf g;
    sheen_mesh back;
    float low[3], high[3], was_low[3], was_high[3];
    make_model(&m);
    sheen_mesh_bounds(&m.mesh, was_low, was_high);
    const size_t budgets[2] = {m.mesh.n_triangles, m.mesh.n_triangles / 2};
    for (int i = 0; i < 2; i++) {
        const sheen_gltf_options o = options_of(budgets[i], i ? 4 : 0);
        assert_ok(sheen_gltf_make(&g, &m, &o, &err), err);
        assert_int_equal(g.n_lights, i ? 2 : 0);
        assert_ok(sheen_mesh_parse(&back, g.glb, g.glb_bytes, "x.glb", &err), err);
        assert_true(back.n_triangles <= budgets[i] + 8);
        sheen_mesh_bounds(&back, low, high);
        // y up, the foot at the origin.
        assert_close(low[1], 0, 2e-3);
        assert_close(high[1] - low[1], was_high[2] - was_low[2], 4e-3);
        assert_close(low[0] + high[0], 0, 4e-3);
        assert_close(g.clipped, 0, 0.05);
        sheen_mesh_release(&back);
        sheen_gltf_release(&g);
    }
    sheen_model_release(&m);
}

static const double from_above[6] = {3.14159265358979323846, 0, 0, 0, 0, 0.6}; // 0.6 m over it, looking down
static const float black[3] = {0};

static void view_from_above(sheen_image *out, const sheen_gltf *g, sheen_camera *cam)
{
    sheen_err err = {0};
    const double fxycxy[4] = {150, 150, 47.5, 35.5};
    assert_ok(sheen_camera_opencv(cam, 96, 72, fxycxy, NULL, 0, &err), err);
    assert_ok(sheen_gltf_view(out, g, cam, from_above, black, 1, &err), err);
}

// A white surface under light that is the same from everywhere cannot be told from it: no light is lost or made.
static void white_in_a_white_world_is_white(void **state)
{
    (void)state;
    sheen_err err = {0};
    sheen_model m;
    sheen_gltf g;
    sheen_image shown;
    sheen_camera cam;
    make_model(&m);
    const sheen_gltf_options o = options_of(m.mesh.n_triangles, 0);
    assert_ok(sheen_gltf_make(&g, &m, &o, &err), err);
    g.specular_factor = g.specular_colour = 1; // Schlick's term, as a refined model has it
    for (size_t i = 0; i < 3 * (size_t)g.panorama.width_px * (size_t)g.panorama.height_px; i++)
        g.panorama.data[i] = 0.7f;
    for (size_t i = 0; i < 3 * (size_t)g.side_px * (size_t)g.side_px; i++)
        g.surface.rgb.data[i] = 1;
    view_from_above(&shown, &g, &cam);
    size_t n = 0;
    for (size_t i = 0; i < 3 * (size_t)cam.width_px * (size_t)cam.height_px; i++)
        if (shown.data[i] > 0) {
            assert_close(shown.data[i], 0.7, 0.01);
            n++;
        }
    assert_true(n > 300);
    sheen_image_release(&shown);
    sheen_gltf_release(&g);
    sheen_model_release(&m);
}

// Root mean square difference, over the model's drawing where a photograph saw the surface.
static double difference_from(const sheen_layers *model, const sheen_image *shown)
{
    double sum = 0;
    size_t n = 0;
    for (size_t i = 0; i < (size_t)shown->width_px * (size_t)shown->height_px; i++)
        for (size_t c = 0; c < 3; c++)
            if (model->coverage.data[i] > 0.5f && !(model->holes.data[i] > 0)) {
                const double d = (double)(shown->data[3 * i + c] - model->composite.data[3 * i + c]);
                sum += d * d;
                n++;
            }
    assert_true(n > 300);
    return sqrt(sum / (double)n);
}

// The highlight under the panorama is the model's, and is not where the light has gone.
static void what_gltf_shows_is_like_the_model(void **state)
{
    (void)state;
    sheen_err err = {0};
    sheen_model m;
    sheen_gltf g;
    sheen_image shown, dark;
    sheen_layers drawn = {0};
    sheen_drawing *d;
    sheen_camera cam;
    make_model(&m);
    const sheen_gltf_options o = options_of(m.mesh.n_triangles, 0);
    const sheen_draw_options one = {.samples_per_side = 1, .n_threads = 1};
    assert_ok(sheen_gltf_make(&g, &m, &o, &err), err);
    view_from_above(&shown, &g, &cam);
    assert_ok(sheen_drawing_new(&d, &m, &err), err);
    assert_ok(sheen_draw(&drawn, d, &cam, from_above, no_turn, &one, &err), err);
    const double near = difference_from(&drawn, &shown);
    for (size_t i = 0; i < 3 * (size_t)g.panorama.width_px * (size_t)g.panorama.height_px; i++)
        g.panorama.data[i] = 0;
    assert_ok(sheen_gltf_view(&dark, &g, &cam, from_above, black, 1, &err), err);
    const double far = difference_from(&drawn, &dark);
    print_message("difference %.4f, without light %.4f\n", near, far);
    assert_true(near < 0.1 * far);
    sheen_image_release(&dark);
    sheen_image_release(&shown);
    sheen_layers_release(&drawn);
    sheen_drawing_free(&d);
    sheen_gltf_release(&g);
    sheen_model_release(&m);
}

// Interpolated normal, tangents and the picture give back the model's bent normals.
static void a_normal_map_becomes_a_normal_texture(void **state)
{
    (void)state;
    sheen_err err = {0};
    sheen_model m;
    sheen_gltf g;
    make_model(&m);
    assert_ok(sheen_normal_map_init(&m.normals, m.mesh.n_triangles, 4, &err), err);
    for (size_t f = 0; f < m.mesh.n_triangles; f++) {
        float p[3 * 10], n[3 * 10];
        sheen_texture_lattice(&m.mesh, f, 4, p, n);
        for (size_t i = 0; i < 10; i++) {
            const float wave[3] = {0.3f * sinf(60 * p[3 * i + 1]), 0.3f * cosf(50 * p[3 * i]), 0};
            sheen_crossf(m.normals.rgb + 3 * (10 * f + i), wave, n + 3 * i);
        }
    }
    const sheen_gltf_options o = options_of(m.mesh.n_triangles, 0);
    assert_ok(sheen_gltf_make(&g, &m, &o, &err), err);
    double sum = 0, flat = 0;
    size_t count = 0;
    for (size_t i = 0; i < (size_t)g.side_px * (size_t)g.side_px; i++) {
        const float *want = g.surface.n_obj.data + 3 * i;
        float p_obj[3], n_obj[3], plain[3];
        if (!(sheen_dotf(want, want) > 0))
            continue;
        sheen_gltf_surface_at(p_obj, n_obj, &g, &g.surface.places[i]);
        const sheen_image kept = g.normals;
        g.normals.data = NULL;
        sheen_gltf_surface_at(p_obj, plain, &g, &g.surface.places[i]);
        g.normals = kept;
        sum += acos(fmin(1, (double)sheen_dotf(n_obj, want)));
        flat += acos(fmin(1, (double)sheen_dotf(plain, want)));
        count++;
    }
    print_message("normals are off by %.4f with the picture, %.4f without\n", sum / (double)count,
                  flat / (double)count);
    assert_true(count > 1000 && sum < 0.1 * flat);
    char json[8192] = {0};
    memcpy(json, g.glb + 20, sizeof json - 1 < g.glb_bytes - 20 ? sizeof json - 1 : g.glb_bytes - 20);
    assert_non_null(strstr(json, "\"normalTexture\""));
    assert_non_null(strstr(json, "\"TANGENT\""));
    sheen_gltf_release(&g);
    sheen_model_release(&m);
}

// Where the object hides its one light from itself, nothing is mirrored; elsewhere it is.
static void what_lies_in_shadow_mirrors_nothing(void **state)
{
    (void)state;
    sheen_err err = {0};
    sheen_model m;
    sheen_gltf g;
    sheen_scene *scene;
    double sum[2] = {0}, count[2] = {0};
    const float l[3] = {0.96f, 0, 0.28f};
    make_model(&m);
    sheen_mesh_release(&m.mesh);
    test_figure(&m.mesh, 6, 0.1f, 0.09f);
    m.shadows = 1;
    m.lights.weight[0] = 0;
    m.lights.dx[1] = l[0];
    m.lights.dz[1] = l[2];
    const sheen_gltf_options o = options_of(m.mesh.n_triangles, 0);
    assert_ok(sheen_gltf_make(&g, &m, &o, &err), err);
    assert_ok(sheen_scene_new(&scene, &m.mesh, &err), err);
    assert_non_null(g.specular.data);
    const int step = g.side_px / g.specular.width_px;
    for (int y = 0; y < g.specular.height_px; y++)
        for (int x = 0; x < g.specular.width_px; x++) {
            const float w = *sheen_image_at(&g.specular, x, y);
            const size_t place = (size_t)(y * step + step / 2) * (size_t)g.side_px +
                                 (size_t)(x * step + step / 2);
            float p_obj[3], n_obj[3];
            assert_true(w >= 0 && w <= 1); // no Fresnel term: not more
            if (!g.surface.known[place])
                continue;
            sheen_gltf_surface_at(p_obj, n_obj, &g, &g.surface.places[place]);
            for (int k = 0; k < 3; k++)
                p_obj[k] += 1e-3f * n_obj[k];
            if (!(sheen_dotf(n_obj, l) > 0.2f))
                continue;
            const int hidden = sheen_scene_blocked(scene, p_obj, l);
            sum[hidden] += (double)w;
            count[hidden]++;
        }
    print_message("mean weight %.2f in light (%.0f places), %.2f in shadow (%.0f)\n", sum[0] / count[0],
                  count[0], sum[1] / count[1], count[1]);
    assert_true(count[1] > 10 && sum[0] / count[0] > 0.8 && sum[1] / count[1] < 0.4);
    sheen_scene_free(&scene);
    sheen_gltf_release(&g);
    sheen_model_release(&m);
}

static void the_least_model_is_written(void **state)
{
    (void)state;
    static const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    sheen_err err = {0};
    sheen_model m;
    sheen_gltf g;
    sheen_model_init(&m);
    test_triangles(&m.mesh, corners, 1);
    m.sigma_rad = 0.1;
    m.n_hemisphere = 6;
    assert_ok(sheen_texture_init(&m.texture, 1, 2, &err), err);
    const sheen_gltf_options o = options_of(100, 3);
    assert_ok(sheen_gltf_make(&g, &m, &o, &err), err);
    assert_int_equal(g.n_triangles, 1);
    assert_int_equal(g.n_lights, 0);
    sheen_gltf_release(&g);
    sheen_model_release(&m);
}

static void unknown_pixels_take_the_colour_about_them(void **state)
{
    (void)state;
    sheen_err err = {0};
    sheen_image img;
    uint8_t known[8 * 4] = {0};
    assert_ok(sheen_image_init(&img, 8, 4, 3, &err), err);
    assert_ok(sheen_image_fill(&img, known, &err), err); // nothing known: stays as it is
    known[9] = known[14] = 1;
    sheen_image_at(&img, 1, 1)[0] = 1;
    sheen_image_at(&img, 6, 1)[2] = 1;
    assert_ok(sheen_image_fill(&img, known, &err), err);
    assert_close(sheen_image_at(&img, 0, 0)[0], 1, 1e-6);
    assert_close(sheen_image_at(&img, 7, 0)[2], 1, 1e-6);
    assert_close(sheen_image_at(&img, 1, 1)[0], 1, 0);
    sheen_image_release(&img);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(charts_lie_side_by_side),
        cmocka_unit_test(a_light_stands_in_the_panorama_with_its_power),
        cmocka_unit_test(a_near_lamp_shines_in_the_panorama_as_on_the_middle),
        cmocka_unit_test(a_near_lamp_is_a_point_light),
        cmocka_unit_test(fewer_triangles_stay_near),
        cmocka_unit_test(our_own_reader_reads_the_file),
        cmocka_unit_test(white_in_a_white_world_is_white),
        cmocka_unit_test(what_gltf_shows_is_like_the_model),
        cmocka_unit_test(a_normal_map_becomes_a_normal_texture),
        cmocka_unit_test(what_lies_in_shadow_mirrors_nothing),
        cmocka_unit_test(the_least_model_is_written),
        cmocka_unit_test(unknown_pixels_take_the_colour_about_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

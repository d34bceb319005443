// SPDX-License-Identifier: Apache-2.0
// test_model.c - saving and loading a fitted model, and refusing every damaged one.
#include "render/model.h"
#include "tests/support.h"
#include "tests/support_scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/image_file.h"
#include "render/geodesic.h"

// A session with a mesh, and a model of it.
typedef struct world {
    test_scratch scratch;
    sheen_session session;
    char dir[TEST_PATH_MAX], mesh_path[TEST_PATH_MAX], json_path[TEST_PATH_MAX], texture_path[TEST_PATH_MAX];
    sheen_model m;
} world;

static void fill_model(sheen_model *m)
{
    sheen_err err = {0};
    sheen_geodesic g;
    assert_ok(sheen_geodesic_init(&g, 6, &err), err);
    memcpy(m->method, "paper", 6);
    m->moving = SHEEN_MOVING_OBJECT;
    m->frequency = 6;
    m->n_hemisphere = g.n_nodes;
    m->k_s = 626.0 / 3;
    m->sigma_rad = 0.0114;
    for (int i = 0; i < 6; i++)
        m->rt_world_obj[i] = 0.1 / (i + 1);
    assert_ok(sheen_model_set_lights(m, 20, &err), err);
    for (size_t i = 0; i < 20; i++) {
        const size_t node = 7 * i;
        m->node[i] = (uint32_t)node;
        m->radiance[i] = 0.1f * (float)i;
        m->lights.dx[i] = g.v_world[3 * node];
        m->lights.dy[i] = g.v_world[3 * node + 1];
        m->lights.dz[i] = g.v_world[3 * node + 2];
        m->lights.weight[i] = (float)(sheen_geodesic_solid_angle_sr(&g) * (double)m->radiance[i]);
    }
    sheen_geodesic_release(&g);
    const sheen_lamp lamps[2] = {{{0, 0, 1}, 1.5f, 0.125f, {1, 2, 3}}, {{0.6f, 0, 0.8f}, 0, 0, {4, 5, 6}}};
    assert_ok(sheen_model_set_lamps(m, lamps, 2, &err), err);
    m->lobe_tail = 0.25;
    m->lobe_fresnel = 24;
    m->gloss = (sheen_gloss){2, 0.125f, {{0.5f, 0.25f, 0.75f}, {1, 0, 0.5f}}, {1, 0.375f}};
    m->lamp_origin_world[2] = 0.0625;
    assert_ok(sheen_texture_init(&m->texture, m->mesh.n_triangles, 3, &err), err);
    for (size_t i = 0; i < m->mesh.n_triangles * 6; i++) {
        m->texture.n_views[i] = (uint8_t)(i % 9);
        for (size_t c = 0; c < 3; c++)
            m->texture.rgb[3 * i + c] = (float)((3 * i + c) % 256) / 256; // exact in half precision
    }
}

static void make_world(world *w)
{
    sheen_err err = {0};
    char path[TEST_PATH_MAX];
    test_scratch_make(&w->scratch);
    test_scratch_file(path, &w->scratch, "s");
    assert_ok(sheen_session_create(&w->session, path, SHEEN_MOVING_OBJECT, &err), err);
    test_scratch_file(w->dir, &w->scratch, "s/model");
    test_scratch_file(w->mesh_path, &w->scratch, "s/mesh.ply");
    test_scratch_file(w->json_path, &w->scratch, "s/model/model.json");
    test_scratch_file(w->texture_path, &w->scratch, "s/model/texture.exr");
    sheen_model_init(&w->m);
    test_figure(&w->m.mesh, 2, 0.1f, 0.02f);
    assert_ok(sheen_mesh_save_ply(&w->m.mesh, w->mesh_path, &err), err);
    fill_model(&w->m);
}

static void free_world(world *w)
{
    sheen_model_release(&w->m);
    sheen_session_release(&w->session);
    test_scratch_remove(&w->scratch);
}

static void add_report(void *self, sheen_json_writer *w)
{
    sheen_json_put_int(w, "report", *(const int *)self);
}

static void save(const world *w)
{
    sheen_err err = {0};
    int report = 42;
    assert_ok(sheen_model_save(&w->m, &w->session, w->dir, add_report, &report, &err), err);
}

static void comes_back_as_it_was(void **state)
{
    (void)state;
    world w;
    make_world(&w);
    save(&w);
    sheen_model back;
    sheen_err err = {0};
    assert_ok(sheen_model_load(&back, &w.session, &err), err);
    assert_string_equal(back.method, "paper");
    assert_int_equal(back.moving, SHEEN_MOVING_OBJECT);
    assert_int_equal(back.frequency, 6);
    assert_int_equal(back.n_hemisphere, w.m.n_hemisphere);
    assert_close(back.k_s, w.m.k_s, 0);
    assert_close(back.sigma_rad, w.m.sigma_rad, 0);
    for (int i = 0; i < 6; i++)
        assert_close(back.rt_world_obj[i], w.m.rt_world_obj[i], 0);
    for (int c = 0; c < 3; c++)
        assert_close(back.light_rgb[c], w.m.light_rgb[c], 0);
    assert_int_equal(back.lights.count, 20);
    assert_memory_equal(back.node, w.m.node, 20 * sizeof *back.node);
    for (size_t i = 0; i < 20; i++) {
        assert_close(back.radiance[i], w.m.radiance[i], 0);
        assert_close(back.lights.dx[i], w.m.lights.dx[i], 1e-7);
        assert_close(back.lights.dy[i], w.m.lights.dy[i], 1e-7);
        assert_close(back.lights.dz[i], w.m.lights.dz[i], 1e-7);
        assert_close(back.lights.weight[i], w.m.lights.weight[i], 1e-8);
    }
    assert_memory_equal(&back.gloss, &w.m.gloss, sizeof back.gloss);
    assert_int_equal(back.mesh.n_triangles, w.m.mesh.n_triangles);
    const size_t n = w.m.mesh.n_triangles * 6;
    assert_memory_equal(back.texture.rgb, w.m.texture.rgb, 3 * n * sizeof(float));
    assert_memory_equal(back.texture.n_views, w.m.texture.n_views, n);
    sheen_model_release(&back);

    uint8_t *text = test_file_read(w.json_path, NULL);
    assert_non_null(strstr((const char *)text, "\"report\": 42"));
    free(text);
    free_world(&w);
}

// Light brighter than half precision can hold is kept all the same.
static void very_bright_texels(void **state)
{
    (void)state;
    world w;
    make_world(&w);
    w.m.texture.rgb[5] = 1e6f;
    save(&w);
    sheen_model back;
    sheen_err err = {0};
    assert_ok(sheen_model_load(&back, &w.session, &err), err);
    assert_close(back.texture.rgb[5], 1e6, 0);
    sheen_model_release(&back);
    free_world(&w);
}

static sheen_status load_with_normals(world *w, sheen_model *back, const char *normals_file, float offset,
                                      sheen_err *err)
{
    char path[TEST_PATH_MAX];
    test_scratch_file(path, &w->scratch, normals_file);
    size_t size_bytes;
    uint8_t *data = test_file_read(path, &size_bytes);
    sheen_raster raster;
    assert_ok(sheen_exr_parse(&raster, data, size_bytes, err), *err);
    const sheen_image atlas = {raster.data, raster.width_px, raster.height_px, raster.n_channels};
    atlas.data[0] = offset;
    assert_ok(sheen_exr_write(path, &atlas, NULL, true, err), *err);
    sheen_raster_release(&raster);
    free(data);
    return sheen_model_load(back, &w->session, err);
}

// Offsets of normals come back; damaged ones do not.
static void with_a_normal_map(void **state)
{
    (void)state;
    world w;
    make_world(&w);
    sheen_model back;
    sheen_err err = {0};
    assert_ok(sheen_normal_map_init(&w.m.normals, w.m.mesh.n_triangles, 4, &err), err);
    const size_t n = w.m.mesh.n_triangles * 10;
    for (size_t i = 0; i < n; i++) {
        w.m.normals.rgb[3 * i] = 0.25f;
        w.m.normals.rgb[3 * i + 1] = -0.125f;
    }
    sheen_normal_map_from_tangents(&w.m.normals, &w.m.mesh);
    save(&w);
    assert_ok(sheen_model_load(&back, &w.session, &err), err);
    assert_int_equal(back.normals.texels_per_edge, 4);
    for (size_t i = 0; i < 3 * n; i++)
        assert_close(back.normals.rgb[i], w.m.normals.rgb[i], 1e-4);
    sheen_model_release(&back);
    assert_fails(load_with_normals(&w, &back, "s/model/normals.exr", 5, &err), err, SHEEN_EFORMAT,
                 "out of range");
    assert_fails(load_with_normals(&w, &back, "s/model/normals.exr", (float)NAN, &err), err, SHEEN_EFORMAT,
                 "normals.exr");
    w.m.normals.n_triangles--;
    assert_fails(sheen_model_save(&w.m, &w.session, w.dir, NULL, NULL, &err), err, SHEEN_EARG, "normal map");
    w.m.normals.n_triangles++;
    free_world(&w);
}

static void without_lights(void **state)
{
    (void)state;
    world w;
    make_world(&w);
    assert_int_equal(sheen_model_set_lights(&w.m, 0, NULL), SHEEN_OK);
    save(&w);
    sheen_model back;
    sheen_err err = {0};
    assert_ok(sheen_model_load(&back, &w.session, &err), err);
    assert_int_equal(back.lights.count, 0);
    sheen_model_release(&back);
    free_world(&w);
}

static void refuses_to_save_nonsense(void **state)
{
    (void)state;
    world w;
    make_world(&w);
    sheen_err err = {0};
    const sheen_model good = w.m;
    w.m.sigma_rad = (double)NAN;
    assert_fails(sheen_model_save(&w.m, &w.session, w.dir, NULL, NULL, &err), err, SHEEN_EARG, "sigma_rad");
    w.m = good;
    w.m.radiance[3] = -1;
    assert_fails(sheen_model_save(&w.m, &w.session, w.dir, NULL, NULL, &err), err, SHEEN_EARG, "light 3");
    w.m.radiance[3] = 1;
    w.m.texture.rgb[8] = (float)INFINITY;
    assert_fails(sheen_model_save(&w.m, &w.session, w.dir, NULL, NULL, &err), err, SHEEN_EARG,
                 "not a colour");
    assert_false(sheen_file_exists(w.json_path));
    free_world(&w);
}

static void says_that_there_is_no_model(void **state)
{
    (void)state;
    world w;
    make_world(&w);
    sheen_model back;
    sheen_err err = {0};
    assert_fails(sheen_model_load(&back, &w.session, &err), err, SHEEN_EDATA, "has no model yet");
    free_world(&w);
}

static void refuses_another_mesh(void **state)
{
    (void)state;
    world w;
    make_world(&w);
    save(&w);
    sheen_model back;
    sheen_mesh other;
    sheen_err err = {0};
    test_figure(&other, 2, 0.1f, 0.021f);
    assert_ok(sheen_mesh_save_ply(&other, w.mesh_path, &err), err);
    sheen_mesh_release(&other);
    assert_fails(sheen_model_load(&back, &w.session, &err), err, SHEEN_EFORMAT,
                 "not the one that was fitted");
    assert_ok(sheen_file_remove(w.mesh_path, &err), err);
    assert_fails(sheen_model_load(&back, &w.session, &err), err, SHEEN_EFORMAT, "no mesh");
    free_world(&w);
}

static void refuses_another_texture(void **state)
{
    (void)state;
    world w;
    make_world(&w);
    save(&w);
    sheen_model back;
    sheen_image small;
    sheen_err err = {0};
    assert_ok(sheen_image_init(&small, 8, 8, 4, &err), err);
    assert_ok(sheen_exr_write(w.texture_path, &small, NULL, true, &err), err);
    assert_fails(sheen_model_load(&back, &w.session, &err), err, SHEEN_EFORMAT, "8 x 8");
    sheen_image_release(&small);
    test_file_write(w.texture_path, "", 0);
    assert_fails(sheen_model_load(&back, &w.session, &err), err, SHEEN_EFORMAT, "texture.exr");
    assert_ok(sheen_file_remove(w.texture_path, &err), err);
    assert_int_not_equal(sheen_model_load(&back, &w.session, &err), SHEEN_OK);
    assert_non_null(strstr(err.msg, "texture.exr"));
    free_world(&w);
}

// Puts `to` in the place of `from` in the saved text and parses that.
static sheen_status parse_changed(const char *text, const char *from, const char *to, sheen_err *err)
{
    const char *at = strstr(text, from);
    assert_non_null(at);
    const size_t size = strlen(text) + strlen(to) + 1;
    char *changed = malloc(size);
    assert_non_null(changed);
    const int n = snprintf(changed, size, "%.*s%s%s", (int)(at - text), text, to, at + strlen(from));
    assert_true(n > 0);
    sheen_model m;
    size_t n_triangles;
    int texels_per_edge;
    const sheen_status s = sheen_model_parse(&m, changed, (size_t)n, &n_triangles, &texels_per_edge, err);
    if (!s)
        sheen_model_release(&m);
    free(changed);
    return s;
}

static void refuses_damaged_numbers(void **state)
{
    (void)state;
    static const struct {
        const char *from, *to, *says;
    } cases[] = {
        {"sheen-model/3", "sheen-model/4", "schema"},
        {"sheen-model/3", "sheen-poses/1", "schema"},
        {"\"tail\": 0.25", "\"tail\": 1.5", "lobe"},
        {"\"fresnel\": 24", "\"fresnel\": -1", "lobe"},
        {"\"width\": 0.125", "\"width\": 0", "gloss"},
        {"0.375", "-0.375", "gloss"},
        {"\"radius_rad\": 0.125", "\"radius_rad\": -0.125", "extent"},
        {"\"inverse_distance_per_m\": 1.5", "\"inverse_distance_per_m\": -1.5", "distance"},
        {"\"origin_world\": [", "\"origin_world\": [1e9, ", "origin_world"},
        {"\"method\": \"paper\"", "\"method\": \"../etc\"", "plain name"},
        {"\"method\": \"paper\"", "\"method\": \"averyveryverylongnameindeed\"", "plain name"},
        {"\"moving\": \"object\"", "\"moving\": \"table\"", "neither"},
        {"\"sigma_rad\": 0.0114", "\"sigma_rad\": 0", "sigma_rad"},
        {"\"sigma_rad\": 0.0114", "\"sigma_rad\": -1", "sigma_rad"},
        {"\"sigma_rad\": 0.0114", "\"sigma_rad\": null", "sigma_rad"},
        {"\"sigma_rad\": 0.0114", "\"sigma_rad\": 1e999", ""},
        {"\"k_s\": 2", "\"k_s\": -2", "k_s"},
        {"\"frequency\": 6", "\"frequency\": 7", "frequency 7"},
        {"\"frequency\": 6", "\"frequency\": 100000", "frequency"},
        {"\"n_hemisphere\": 196", "\"n_hemisphere\": 10000000", "n_hemisphere"},
        {"\"n_hemisphere\": 196", "\"n_hemisphere\": 10", "hemisphere"},
        {"\"texels_per_edge\": 3", "\"texels_per_edge\": 0", "texels_per_edge"},
        {"\"texels_per_edge\": 3", "\"texels_per_edge\": 65", "texels_per_edge"},
        {"\"n_triangles\": 80", "\"n_triangles\": 0", "n_triangles"},
        {"\"columns\": ", "\"columns\": 9", "columns"},
        {"\"index\": [", "\"index\": [-1, ", "differ in length"},
        {"\"radiance\": [", "\"radiance\": [5, ", "differ in length"},
        {"\"nodes\": {", "\"nodez\": {", "nodes"},
        {"\"light_rgb\"", "\"light_bgr\"", "light_rgb"},
    };
    world w;
    make_world(&w);
    save(&w);
    char *text = (char *)test_file_read(w.json_path, NULL);
    sheen_err err = {0};
    assert_ok(parse_changed(text, "paper", "paper", &err), err);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_fails(parse_changed(text, cases[i].from, cases[i].to, &err), err, SHEEN_EFORMAT,
                     cases[i].says);
    free(text);
    free_world(&w);
}

static void refuses_damaged_lights(void **state)
{
    (void)state;
    static const char form[] =
        "{\"schema\": \"sheen-model/1\", \"method\": \"paper\", \"moving\": \"camera\", "
        "\"rt_world_obj\": [0, 0, 0, 0, 0, 0], \"frequency\": 1, \"n_hemisphere\": 6, "
        "\"nodes\": {\"index\": [%s], \"radiance\": [%s], \"direction_world\": [%s]}, "
        "\"k_s\": 1, \"sigma_rad\": 0.1, \"light_rgb\": [1, 1, 1], "
        "\"texture\": {\"file\": \"t.exr\", \"n_triangles\": 1, \"texels_per_edge\": 2, "
        "\"columns\": 1}}";
    static const struct {
        const char *index, *radiance, *direction, *says; // says NULL: good
    } cases[] = {
        {"0, 5", "1, 0", "[0, 0, 1], [0.6, 0, 0.8]", NULL},
        {"", "", "", NULL},
        {"6", "1", "[0, 0, 1]", "node 6"},
        {"-1", "1", "[0, 0, 1]", "node -1"},
        {"1.5", "1", "[0, 0, 1]", "node 1.5"},
        {"\"a\"", "1", "[0, 0, 1]", "node"},
        {"1", "-1", "[0, 0, 1]", "radiance"},
        {"1", "1e38", "[0, 0, 1]", "radiance"},
        {"1", "null", "[0, 0, 1]", "radiance"},
        {"1", "1", "[0, 0, 2]", "unit vector"},
        {"1", "1", "[0, 0]", "unit vector"},
        {"1", "1", "[0, 0, 1, 0]", "unit vector"},
        {"1", "1", "3", "unit vector"},
        {"0,0,0,0,0,0,0", "1,1,1,1,1,1,1", "[0,0,1],[0,0,1],[0,0,1],[0,0,1],[0,0,1],[0,0,1],[0,0,1]",
         "more than"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[1200];
        const int n = snprintf(text, sizeof text, form, cases[i].index, cases[i].radiance,
                               cases[i].direction);
        assert_true(n > 0 && (size_t)n < sizeof text);
        sheen_model m;
        sheen_err err = {0};
        size_t n_triangles;
        int texels_per_edge;
        const sheen_status s = sheen_model_parse(&m, text, (size_t)n, &n_triangles, &texels_per_edge, &err);
        if (cases[i].says) {
            assert_fails(s, err, SHEEN_EFORMAT, cases[i].says);
        } else {
            assert_ok(s, err);
            assert_int_equal(n_triangles, 1);
            assert_int_equal(texels_per_edge, 2);
            sheen_model_release(&m);
        }
    }
}

// Cut short anywhere, model.json is refused and nothing leaks.
static void refuses_every_cut(void **state)
{
    (void)state;
    world w;
    make_world(&w);
    save(&w);
    size_t size_bytes;
    uint8_t *text = test_file_read(w.json_path, &size_bytes);
    while (size_bytes && text[size_bytes - 1] != '}')
        size_bytes--;
    for (size_t cut = 0; cut < size_bytes; cut += cut < 200 ? 1 : 37) {
        sheen_model m;
        sheen_err err = {0};
        size_t n_triangles;
        int texels_per_edge;
        assert_fails(sheen_model_parse(&m, text, cut, &n_triangles, &texels_per_edge, &err), err,
                     SHEEN_EFORMAT, "");
    }
    free(text);
    free_world(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(comes_back_as_it_was),     cmocka_unit_test(very_bright_texels),
        cmocka_unit_test(with_a_normal_map),        cmocka_unit_test(without_lights),
        cmocka_unit_test(refuses_to_save_nonsense), cmocka_unit_test(says_that_there_is_no_model),
        cmocka_unit_test(refuses_another_mesh),     cmocka_unit_test(refuses_another_texture),
        cmocka_unit_test(refuses_damaged_numbers),  cmocka_unit_test(refuses_damaged_lights),
        cmocka_unit_test(refuses_every_cut),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

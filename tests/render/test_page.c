// SPDX-License-Identifier: Apache-2.0
// test_page.c - a model packed for a page and read back: what is kept, how closely, and what is refused.
#include "render/page.h"
#include "tests/support.h"
#include "tests/support_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "render/draw.h"
#include "render/pack_avif.h"
#include "render/pack_deflate.h"

enum { TEXELS = 4, N_LIGHTS = 40 };

static void make_model(sheen_model *m)
{
    sheen_err err = {0};
    uint64_t seed = 5;
    sheen_model_init(m);
    test_figure(&m->mesh, 6, 0.1f, 0.02f);
    memcpy(m->method, "refined", sizeof "refined");
    m->moving = SHEEN_MOVING_OBJECT;
    m->frequency = 3;
    m->n_hemisphere = 46;
    m->k_s = 2.5;
    m->sigma_rad = 0.08;
    for (int i = 0; i < 6; i++)
        m->rt_world_obj[i] = 0.1 / (i + 1);
    for (int c = 0; c < 3; c++)
        m->light_rgb[c] = 1 - 0.1 * c;
    assert_ok(sheen_model_set_lights(m, N_LIGHTS, &err), err);
    for (size_t i = 0; i < N_LIGHTS; i++) {
        float v[3];
        test_direction(v, &seed);
        m->node[i] = (uint32_t)i;
        m->radiance[i] = 0.01f * (float)(i % 7);
        m->lights.dx[i] = v[0];
        m->lights.dy[i] = v[1];
        m->lights.dz[i] = v[2];
        m->lights.weight[i] = (float)(2 * 3.14159265358979323846 / 46 * (double)m->radiance[i]);
    }
    assert_ok(sheen_texture_init(&m->texture, m->mesh.n_triangles, TEXELS, &err), err);
    const size_t n = m->mesh.n_triangles * sheen_texels_per_triangle(TEXELS);
    for (size_t i = 0; i < n; i++) {
        m->texture.n_views[i] = (uint8_t)(i % 11);
        for (size_t c = 0; c < 3; c++)
            m->texture.rgb[3 * i + c] = m->texture.n_views[i] ? (float)((7 * i + c) % 100) / 99 : 0;
    }
}

// Offsets across the mesh's normals that differ from texel to texel.
static void add_normal_map(sheen_model *m, int texels_per_edge)
{
    sheen_err err = {0};
    uint64_t seed = 11;
    float p[3 * 64], n[3 * 64];
    const size_t per_triangle = sheen_texels_per_triangle(texels_per_edge);
    assert_ok(sheen_normal_map_init(&m->normals, m->mesh.n_triangles, texels_per_edge, &err), err);
    for (size_t f = 0; f < m->mesh.n_triangles; f++) {
        sheen_texture_lattice(&m->mesh, f, texels_per_edge, p, n);
        for (size_t i = 0; i < per_triangle; i++) {
            float *d = m->normals.rgb + 3 * (f * per_triangle + i), v[3];
            test_direction(v, &seed);
            sheen_crossf(d, v, n + 3 * i);
            for (int k = 0; k < 3; k++)
                d[k] *= 0.3f;
        }
    }
}

// A board of 8 x 6 pixels brighter than white, and light from the room.
static void add_surroundings(sheen_model *m)
{
    sheen_err err = {0};
    sheen_surroundings *e = &m->surroundings;
    m->shadows = 1;
    e->present = 1;
    e->f0 = 0.04;
    e->board_x0_m = -0.4;
    e->board_y0_m = -0.3;
    e->board_pitch_m = 0.1;
    for (int c = 0; c < 3; c++) {
        e->ambient_rgb[0][c] = 1 + c;
        e->table_rgb[c] = 0.1 * c;
    }
    assert_ok(sheen_image_init(&e->board, 8, 6, 3, &err), err);
    for (size_t i = 0; i < (size_t)8 * 6 * 3; i++)
        e->board.data[i] = 2.0f * (float)(i / 3 % 8) / 7;
}

static const sheen_page_options finest = {.quantizer = SHEEN_AVIF_FINEST, .n_threads = 1};
static const sheen_page_view a_view = {.rt_board_obj = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6},
                                       .focal_per_width = 1.25};

static void pack(sheen_page *page, const sheen_model *m)
{
    sheen_err err = {0};
    assert_ok(sheen_page_pack(page, m, &a_view, &finest, &err), err);
}

static void the_same_comes_back(void **state)
{
    (void)state;
    sheen_err err = {0};
    sheen_model m, back;
    sheen_page page;
    sheen_page_view view;
    make_model(&m);
    pack(&page, &m);
    assert_ok(sheen_page_unpack(&back, &view, &page, &err), err);
    assert_memory_equal(&view, &a_view, sizeof view);
    assert_int_equal(back.moving, m.moving);
    assert_true(back.k_s == m.k_s && back.sigma_rad == m.sigma_rad);
    assert_memory_equal(back.light_rgb, m.light_rgb, sizeof m.light_rgb);
    assert_memory_equal(back.rt_world_obj, m.rt_world_obj, sizeof m.rt_world_obj);
    assert_int_equal(back.mesh.n_vertices, m.mesh.n_vertices);
    assert_int_equal(back.mesh.n_triangles, m.mesh.n_triangles);
    // Vertices change places, triangles and their corners do not.
    const double step_m = 0.25 / 65535;
    for (size_t i = 0; i < 3 * m.mesh.n_triangles; i++) {
        const size_t a = 3 * (size_t)m.mesh.triangles[i], b = 3 * (size_t)back.mesh.triangles[i];
        for (size_t k = 0; k < 3; k++)
            assert_close(back.mesh.p_obj[b + k], m.mesh.p_obj[a + k], step_m);
        for (size_t k = 0; k < 3; k++)
            assert_close(back.mesh.n_obj[b + k], m.mesh.n_obj[a + k], 1e-4);
    }
    for (size_t i = 0; i < N_LIGHTS; i++) {
        assert_close(back.lights.dx[i], m.lights.dx[i], 1e-6);
        assert_close(back.lights.dz[i], m.lights.dz[i], 1e-6);
        assert_true(back.lights.weight[i] == m.lights.weight[i]);
    }
    const size_t n = m.mesh.n_triangles * sheen_texels_per_triangle(TEXELS);
    for (size_t i = 0; i < n; i++) {
        assert_int_equal(back.texture.n_views[i] > 0, m.texture.n_views[i] > 0);
        for (size_t c = 0; c < 3 && m.texture.n_views[i]; c++)
            assert_close(sheen_transfer_encode(SHEEN_TRANSFER_SRGB, back.texture.rgb[3 * i + c]),
                         sheen_transfer_encode(SHEEN_TRANSFER_SRGB, m.texture.rgb[3 * i + c]), 4.0 / 255);
    }
    sheen_page_release(&page);
    sheen_model_release(&m);
    sheen_model_release(&back);
}

// To half a step, an eighth of sigma, in each of two directions.
static void a_normal_map_comes_back(void **state)
{
    (void)state;
    sheen_err err = {0};
    sheen_model m, back;
    sheen_page page;
    make_model(&m);
    add_normal_map(&m, 5);
    pack(&page, &m);
    assert_ok(sheen_page_unpack(&back, NULL, &page, &err), err);
    assert_int_equal(back.normals.texels_per_edge, 5);
    assert_int_equal(back.normals.n_triangles, m.normals.n_triangles);
    const size_t n = m.normals.n_triangles * sheen_texels_per_triangle(5);
    for (size_t i = 0; i < n; i++) {
        float d[3];
        sheen_subf(d, back.normals.rgb + 3 * i, m.normals.rgb + 3 * i);
        assert_true(sheen_dotf(d, d) < 0.51f * 0.01f * 0.01f);
        assert_true(back.normals.n_views[i]);
    }
    m.normals.n_triangles--;
    sheen_page other;
    assert_int_equal(sheen_page_pack(&other, &m, &a_view, &finest, &err), SHEEN_EARG);
    m.normals.n_triangles++;
    sheen_page_release(&page);
    sheen_model_release(&m);
    sheen_model_release(&back);
}

static void surroundings_come_back(void **state)
{
    (void)state;
    sheen_err err = {0};
    sheen_model m, back;
    sheen_page page;
    make_model(&m);
    add_surroundings(&m);
    pack(&page, &m);
    assert_ok(sheen_page_unpack(&back, NULL, &page, &err), err);
    const sheen_surroundings *a = &m.surroundings, *b = &back.surroundings;
    assert_int_equal(back.shadows, 1);
    assert_int_equal(b->present, 1);
    assert_true(b->f0 == a->f0 && b->board_x0_m == a->board_x0_m && b->board_pitch_m == a->board_pitch_m);
    assert_memory_equal(b->ambient_rgb, a->ambient_rgb, sizeof a->ambient_rgb);
    assert_memory_equal(b->table_rgb, a->table_rgb, sizeof a->table_rgb);
    assert_int_equal(b->board.width_px, 8);
    for (size_t i = 0; i < (size_t)8 * 6 * 3; i++)
        assert_close(b->board.data[i], a->board.data[i], 0.1);
    sheen_page_release(&page);
    sheen_model_release(&m);
    sheen_model_release(&back);
}

static void a_coarser_code_is_smaller_and_still_alike(void **state)
{
    (void)state;
    enum { SIDE = 64 };
    sheen_err err = {0};
    uint8_t rgb[SIDE * SIDE * 3], *coded, *back;
    size_t size_bytes, last_bytes = SIZE_MAX;
    for (size_t i = 0; i < sizeof rgb; i++)
        rgb[i] = (uint8_t)(i / 3 % SIDE * 3 + 40 * (i % 3) + i * 7919 % 5);
    for (int quantizer = 0; quantizer <= 60; quantizer += 20) {
        double sum = 0;
        assert_ok(sheen_avif_encode(&coded, &size_bytes, rgb, SIDE, SIDE, quantizer, 1, &err), err);
        assert_true(size_bytes < last_bytes);
        last_bytes = size_bytes;
        assert_ok(sheen_avif_decode(&back, coded, size_bytes, SIDE, SIDE, &err), err);
        for (size_t i = 0; i < sizeof rgb; i++)
            sum += ((double)rgb[i] - back[i]) * ((double)rgb[i] - back[i]);
        assert_true(sqrt(sum / sizeof rgb) < 2 + quantizer / 4.0);
        free(back);
        assert_fails(sheen_avif_decode(&back, coded, size_bytes, SIDE + 1, SIDE, &err), err, SHEEN_EFORMAT,
                     "64 x 64 px");
        free(coded);
    }
}

static void it_draws_the_same(void **state)
{
    (void)state;
    sheen_err err = {0};
    sheen_model models[2];
    sheen_page page;
    sheen_layers layers[2];
    sheen_camera cam;
    double rt_cam_obj[6];
    make_model(&models[0]);
    add_surroundings(&models[0]);
    pack(&page, &models[0]);
    assert_ok(sheen_page_unpack(&models[1], NULL, &page, &err), err);
    test_camera(&cam, 120, 90, 150, 0);
    test_look(rt_cam_obj, 0.3, 0.2, 0.15);
    for (int i = 0; i < 2; i++) {
        sheen_drawing *d;
        assert_ok(sheen_drawing_new(&d, &models[i], &err), err);
        assert_ok(sheen_draw(&layers[i], d, &cam, rt_cam_obj, NULL, NULL, &err), err);
        sheen_drawing_free(&d);
    }
    double error = 0, light = 0;
    for (size_t i = 0; i < (size_t)3 * 120 * 90; i++) {
        const double e = (double)layers[0].composite.data[i] - (double)layers[1].composite.data[i];
        error += e * e;
        light += (double)layers[0].specular.data[i];
    }
    assert_true(light > 1); // there are highlights to compare
    assert_true(sqrt(error / (3 * 120 * 90)) < 6e-3);
    for (int i = 0; i < 2; i++) {
        sheen_layers_release(&layers[i]);
        sheen_model_release(&models[i]);
    }
    sheen_page_release(&page);
}

static void what_cannot_be_shown_is_refused(void **state)
{
    (void)state;
    sheen_err err = {0};
    sheen_model m;
    sheen_page page;
    make_model(&m);
    m.mesh.p_obj[7] = NAN;
    assert_fails(sheen_page_pack(&page, &m, &a_view, &finest, &err), err, SHEEN_EARG,
                 "numbers that are not usable");
    assert_null(page.geometry);
    m.mesh.p_obj[7] = 0;
    m.sigma_rad = 0;
    assert_fails(sheen_page_pack(&page, &m, &a_view, &finest, &err), err, SHEEN_EARG, "out of range");
    m.sigma_rad = (double)NAN;
    assert_fails(sheen_page_pack(&page, &m, &a_view, &finest, &err), err, SHEEN_EARG, "out of range");
    m.sigma_rad = 0.1;
    m.lights.count = 10000000; // not read: the count alone is refused
    assert_fails(sheen_page_pack(&page, &m, &a_view, &finest, &err), err, SHEEN_EARG,
                 "more than the hemisphere");
    m.lights.count = N_LIGHTS;
    m.texture.n_triangles--;
    assert_fails(sheen_page_pack(&page, &m, &a_view, &finest, &err), err, SHEEN_EARG, "a texture for each");
    m.texture.n_triangles++;
    sheen_model_release(&m);
}

// One triangle, no light, black.
static void the_least_model_is_shown(void **state)
{
    (void)state;
    static const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    sheen_err err = {0};
    sheen_model m, back;
    sheen_page page;
    sheen_model_init(&m);
    test_triangles(&m.mesh, corners, 1);
    m.sigma_rad = 0.1;
    m.frequency = 1;
    m.n_hemisphere = 6;
    memcpy(m.method, "paper", sizeof "paper");
    assert_ok(sheen_texture_init(&m.texture, 1, 2, &err), err);
    pack(&page, &m);
    assert_ok(sheen_page_unpack(&back, NULL, &page, &err), err);
    assert_int_equal(back.lights.count, 0);
    assert_close(back.mesh.p_obj[3], 1, 1e-6);
    sheen_model_release(&back);
    sheen_model_release(&m);
    sheen_page_release(&page);
}

static void damage_is_noticed_or_harmless(void **state)
{
    (void)state;
    sheen_err err = {0};
    sheen_model m, back;
    sheen_page page;
    uint8_t *bytes;
    size_t size_bytes;
    make_model(&m);
    add_normal_map(&m, 3);
    pack(&page, &m);
    assert_ok(sheen_inflate(&bytes, &size_bytes, page.geometry, page.geometry_bytes, 1 << 24, &err), err);
    const size_t step = size_bytes / 400 + 1;
    for (size_t at = 0; at < size_bytes; at += at < 240 ? 1 : step) {
        sheen_page bent = {.texture = page.texture, .texture_bytes = page.texture_bytes};
        bytes[at] ^= 0x81;
        assert_ok(sheen_deflate(&bent.geometry, &bent.geometry_bytes, bytes, size_bytes, &err), err);
        bytes[at] ^= 0x81;
        if (!sheen_page_unpack(&back, NULL, &bent, &err))
            sheen_model_release(&back);
        free(bent.geometry);
    }
    free(bytes);
    for (size_t cut = 0; cut < page.geometry_bytes; cut += 97) {
        const sheen_page bent = {.geometry = page.geometry,
                                 .texture = page.texture,
                                 .geometry_bytes = cut,
                                 .texture_bytes = page.texture_bytes};
        assert_int_equal(sheen_page_unpack(&back, NULL, &bent, &err), SHEEN_EFORMAT);
    }
    for (size_t cut = 0; cut < page.texture_bytes; cut += 997) {
        const sheen_page bent = {.geometry = page.geometry,
                                 .texture = page.texture,
                                 .geometry_bytes = page.geometry_bytes,
                                 .texture_bytes = cut};
        assert_int_equal(sheen_page_unpack(&back, NULL, &bent, &err), SHEEN_EFORMAT);
    }
    sheen_page_release(&page);
    sheen_model_release(&m);
}

static void inflating_stops_at_its_limit(void **state)
{
    (void)state;
    sheen_err err = {0};
    uint8_t *zeros = calloc(1, 1 << 20), *small, *large;
    size_t small_bytes, large_bytes;
    assert_non_null(zeros);
    assert_ok(sheen_deflate(&small, &small_bytes, zeros, 1 << 20, &err), err);
    assert_true(small_bytes < 2000);
    assert_ok(sheen_inflate(&large, &large_bytes, small, small_bytes, 1 << 20, &err), err);
    assert_int_equal(large_bytes, 1 << 20);
    assert_memory_equal(large, zeros, 1 << 20);
    free(large);
    assert_fails(sheen_inflate(&large, &large_bytes, small, small_bytes, (1 << 20) - 1, &err), err,
                 SHEEN_EFORMAT, "larger than it may be");
    free(small);
    free(zeros);
}

static void a_page_holds_words_and_parts(void **state)
{
    (void)state;
    sheen_err err = {0};
    uint8_t geometry[] = {'M', 'a', 'n', 0xff}, texture[] = {0, 1}, board[] = {0};
    const sheen_page page = {geometry, texture, board, sizeof geometry, sizeof texture, sizeof board};
    const sheen_page_words words = {
        .title = "<a> & \"@SHEEN_TEXTURE@'", .sources = " 'self'", .more_json = "{\"a\":\"</script>\"}"};
    char *text;
    size_t size_bytes;
    assert_ok(sheen_page_html(&text, &size_bytes, &page,
                              "@SHEEN_SOURCES@<title>@SHEEN_TITLE@</title>@SHEEN_MORE@@SHEEN_GEOMETRY@|"
                              "@SHEEN_TEXTURE@.@SHEEN_BOARD@",
                              &words, &err),
              err);
    assert_string_equal(text, " &#39;self&#39;<title>&lt;a&gt; &amp; &quot;@SHEEN_TEXTURE@&#39;</title>"
                              "{\"a\":\"\\u003c/script>\"}TWFu/w==|AAE=.AA==");
    assert_int_equal(size_bytes, strlen(text));
    free(text);
    assert_fails(sheen_page_html(&text, &size_bytes, &page, "@SHEEN_SOURCES@ @SHEEN_TITLE@ @SHEEN_TEXTURE@",
                                 &words, &err),
                 err, SHEEN_EARG, "@SHEEN_MORE@");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_same_comes_back),
        cmocka_unit_test(a_normal_map_comes_back),
        cmocka_unit_test(surroundings_come_back),
        cmocka_unit_test(a_coarser_code_is_smaller_and_still_alike),
        cmocka_unit_test(it_draws_the_same),
        cmocka_unit_test(what_cannot_be_shown_is_refused),
        cmocka_unit_test(the_least_model_is_shown),
        cmocka_unit_test(damage_is_noticed_or_harmless),
        cmocka_unit_test(inflating_stops_at_its_limit),
        cmocka_unit_test(a_page_holds_words_and_parts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

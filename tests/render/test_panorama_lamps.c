// SPDX-License-Identifier: Apache-2.0
// test_panorama_lamps.c - a panorama as light: no light is lost, lamps stand where it is bright, and what it replaces goes.
#include "render/panorama_lamps.h"
#include "tests/support.h"
#include "tests/support_scene.h"

#include <math.h>

#include "base/vec.h"
#include "render/panorama.h"

static const double pi = 3.14159265358979323846, f0 = 0.04;
static const double no_turn[6] = {0};
// env from the board's frame: x, z, -y
static double R_env_board[3][3] = {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};

static void make_model(sheen_model *m)
{
    sheen_model_init(m);
    test_figure(&m->mesh, 6, 0.1f, 0.02f);
    m->sigma_rad = 0.1;
    m->k_s = 1;
    m->surroundings.present = 1;
    m->surroundings.f0 = f0;
}

static double total(const sheen_model *m, int c)
{
    double sum = 0;
    for (size_t i = 0; i < m->n_lamps; i++)
        sum += (double)m->lamps[i].rgb[c];
    return sum;
}

static void an_even_sky_becomes_even_lamps(void **state)
{
    (void)state;
    sheen_err err;
    sheen_model m;
    sheen_image sky;
    make_model(&m);
    assert_ok(sheen_image_init(&sky, 128, 64, 3, &err), err);
    for (size_t i = 0; i < 128 * 64; i++) {
        sky.data[3 * i] = 0.5f;
        sky.data[3 * i + 1] = 1;
        sky.data[3 * i + 2] = 2;
    }
    assert_ok(sheen_model_light_by_panorama(&m, &sky, 64, f0, &err), err);
    assert_int_equal(m.n_lamps, 64);
    assert_int_equal(m.surroundings.present, 0);
    const double whole = f0 * 4 * pi / (8 * pi * 0.01);
    assert_close(total(&m, 0), 0.5 * whole, 1e-4 * whole);
    assert_close(total(&m, 1), whole, 1e-4 * whole);
    assert_close(total(&m, 2), 2 * whole, 2e-4 * whole);
    for (size_t i = 0; i < m.n_lamps; i++) {
        assert_close((double)m.lamps[i].rgb[1] / (whole / 64), 1, 0.5);
        assert_close(sheen_dotf(m.lamps[i].direction_world, m.lamps[i].direction_world), 1, 1e-5);
        // a disc of a 64th of the sphere has a radius of 0.25; regions are not round
        assert_close(m.lamps[i].radius_rad, 0.3, 0.15);
    }
    sheen_image_release(&sky);
    sheen_model_release(&m);
}

// What a model's lamps are as a panorama gives lamps again that stand there with the same colours.
static void lamps_come_back_from_their_panorama(void **state)
{
    (void)state;
    static const sheen_lamp lamps[] = {
        {.direction_world = {0.6f, 0, 0.8f}, .radius_rad = 0.06f, .rgb = {1, 2, 3}},
        {.direction_world = {0, -0.8f, 0.6f}, .radius_rad = 0.06f, .rgb = {4, 2, 1}},
    };
    sheen_err err;
    sheen_model m;
    sheen_image sky;
    make_model(&m);
    m.surroundings.present = 0;
    assert_ok(sheen_model_set_lamps(&m, lamps, 2, &err), err);
    assert_ok(sheen_panorama_make(&sky, &m, no_turn, R_env_board, 256, &err), err);
    assert_ok(sheen_panorama_add_lights(&sky, &m, no_turn, R_env_board, f0, &err), err);
    assert_ok(sheen_model_light_by_panorama(&m, &sky, 32, f0, &err), err);
    double found[2][3] = {{0}};
    for (size_t i = 0; i < m.n_lamps; i++) {
        const float *l = m.lamps[i].direction_world;
        const int near = sheen_dotf(l, lamps[0].direction_world) > sheen_dotf(l, lamps[1].direction_world)
                             ? 0
                             : 1;
        assert_true(sheen_dotf(l, lamps[near].direction_world) > cosf(0.07f));
        assert_true(m.lamps[i].radius_rad < 0.07f);
        for (int c = 0; c < 3; c++)
            found[near][c] += (double)m.lamps[i].rgb[c];
    }
    for (int k = 0; k < 2; k++)
        for (int c = 0; c < 3; c++)
            assert_close(found[k][c], lamps[k].rgb[c], 0.002 * (double)lamps[k].rgb[c]);
    sheen_image_release(&sky);
    sheen_model_release(&m);
}

static void more_lamps_than_bright_pixels_are_not_made(void **state)
{
    (void)state;
    sheen_err err;
    sheen_model m;
    sheen_image sky;
    make_model(&m);
    assert_ok(sheen_image_init(&sky, 64, 32, 3, &err), err);
    sheen_image_at(&sky, 40, 10)[0] = 100;
    assert_ok(sheen_model_light_by_panorama(&m, &sky, 1000, f0, &err), err);
    assert_int_equal(m.n_lamps, 1);
    float v_env[3];
    sheen_panorama_direction(v_env, &sky, 40, 10);
    assert_close(m.lamps[0].direction_world[0], v_env[0], 1e-5);
    assert_close(m.lamps[0].direction_world[1], -v_env[2], 1e-5);
    assert_close(m.lamps[0].direction_world[2], v_env[1], 1e-5);
    sheen_image_release(&sky);
    sheen_model_release(&m);
}

static void what_is_no_panorama_is_refused(void **state)
{
    (void)state;
    sheen_err err;
    sheen_model m;
    sheen_image img;
    make_model(&m);
    assert_ok(sheen_image_init(&img, 64, 32, 3, &err), err);
    assert_fails(sheen_model_light_by_panorama(&m, &img, 8, f0, &err), err, SHEEN_EDATA, "all black");
    img.data[7] = NAN;
    assert_fails(sheen_model_light_by_panorama(&m, &img, 8, f0, &err), err, SHEEN_EDATA, "not finite");
    img.data[7] = -1;
    assert_fails(sheen_model_light_by_panorama(&m, &img, 8, f0, &err), err, SHEEN_EDATA, "negative");
    img.height_px = 31;
    assert_fails(sheen_model_light_by_panorama(&m, &img, 8, f0, &err), err, SHEEN_EDATA,
                 "twice as wide as high, not 64 x 31 px");
    assert_int_equal(m.surroundings.present, 1); // a refusal changes nothing
    sheen_image_release(&img);
    sheen_model_release(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_even_sky_becomes_even_lamps),
        cmocka_unit_test(lamps_come_back_from_their_panorama),
        cmocka_unit_test(more_lamps_than_bright_pixels_are_not_made),
        cmocka_unit_test(what_is_no_panorama_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

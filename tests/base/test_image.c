// SPDX-License-Identifier: Apache-2.0
// test_image.c - pictures in memory: sampling, code values and light, the grey that detectors see.
#include "tests/support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/image.h"

static void refuses_sizes_out_of_range(void **state)
{
    (void)state;
    static const struct {
        int width_px, height_px, n_channels;
        const char *msg;
    } cases[] = {
        {0, 5, 1, "a picture of 0 x 5 px is out of range: sides are 1 to 32768 px"},
        {5, -1, 1, "a picture of 5 x -1 px is out of range: sides are 1 to 32768 px"},
        {32769, 1, 1, "a picture of 32769 x 1 px is out of range: sides are 1 to 32768 px"},
        {2, 2, 0, "a picture has 1 to 4 channels, not 0"},
        {2, 2, 5, "a picture has 1 to 4 channels, not 5"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        sheen_err err;
        sheen_image img;
        assert_int_equal(
            sheen_image_init(&img, cases[i].width_px, cases[i].height_px, cases[i].n_channels, &err),
            SHEEN_EARG);
        assert_string_equal(err.msg, cases[i].msg);
        assert_null(img.data);
    }
    sheen_err err;
    sheen_raster r;
    assert_int_equal(sheen_raster_init(&r, 2, 2, 1, 12, &err), SHEEN_EARG);
    assert_string_equal(err.msg, "a picture has 8, 16 or 32 bits a sample, not 12");
}

static void begins_black(void **state)
{
    (void)state;
    sheen_err err;
    sheen_image img;
    assert_ok(sheen_image_init(&img, 7, 3, 4, &err), err);
    for (int i = 0; i < 7 * 3 * 4; i++)
        assert_true(img.data[i] == 0);
    sheen_image_release(&img);
    assert_null(img.data);
    sheen_image_release(&img); // twice is fine
}

static void samples_between_pixels(void **state)
{
    (void)state;
    sheen_err err;
    sheen_image img;
    assert_ok(sheen_image_init(&img, 3, 2, 2, &err), err);
    for (int y = 0; y < 2; y++)
        for (int x = 0; x < 3; x++) {
            sheen_image_at(&img, x, y)[0] = (float)(10 * x + 100 * y);
            sheen_image_at(&img, x, y)[1] = (float)x;
        }
    float v[2];
    assert_true(sheen_image_bilinear(v, &img, 0.25, 0.5)); // 10 * 0.25 + 100 * 0.5
    assert_close(v[0], 52.5, 1e-5);
    assert_close(v[1], 0.25, 1e-6);
    assert_true(sheen_image_bilinear(v, &img, 2, 1)); // the last pixel's centre
    assert_close(v[0], 120, 0);
    assert_true(sheen_image_bilinear(v, &img, 2, 0.5));
    assert_close(v[0], 70, 1e-5);

    static const double outside[][2] = {{-1e-9, 0},  {0, -1e-9}, {2.0001, 0},
                                        {0, 1.0001}, {1e300, 0}, {0, -1e300}};
    v[0] = -7;
    for (size_t i = 0; i < sizeof outside / sizeof *outside; i++)
        assert_false(sheen_image_bilinear(v, &img, outside[i][0], outside[i][1]));
    assert_false(sheen_image_bilinear(v, &img, (double)NAN, 0));
    assert_false(sheen_image_bilinear(v, &img, 0, (double)NAN));
    assert_true(v[0] == -7);
    sheen_image_release(&img);
}

// From the standards' formulas, by hand.
static void decodes_by_the_standards(void **state)
{
    (void)state;
    assert_close(sheen_transfer_decode(SHEEN_TRANSFER_SRGB, 0.5f), 0.21404114, 1e-6);
    assert_close(sheen_transfer_decode(SHEEN_TRANSFER_SRGB, 0.04f), 0.04 / 12.92, 1e-8);
    assert_close(sheen_transfer_decode(SHEEN_TRANSFER_REC709, 0.5f), 0.25958940, 1e-6);
    assert_close(sheen_transfer_decode(SHEEN_TRANSFER_REC709, 0.045f), 0.01, 1e-8);
    assert_close(sheen_transfer_decode(SHEEN_TRANSFER_GAMMA22, 0.5f), 0.21763764, 1e-6);
    assert_close(sheen_transfer_decode(SHEEN_TRANSFER_LINEAR, 3.5f), 3.5, 0);
    assert_close(sheen_transfer_encode(SHEEN_TRANSFER_SRGB, 0.18f), 0.46135613, 1e-6);
    assert_close(sheen_transfer_encode(SHEEN_TRANSFER_LINEAR, -2), -2, 0);
}

static void codes_round_trip_and_clip(void **state)
{
    (void)state;
    for (int t = 0; t < SHEEN_TRANSFER_COUNT; t++) {
        float last = -1;
        for (int i = 0; i <= 1000; i++) {
            const float code = (float)i / 1000, light = sheen_transfer_decode((sheen_transfer)t, code);
            assert_close(sheen_transfer_encode((sheen_transfer)t, light), code,
                         3e-4); // BT.709 joins to 2.5e-4
            assert_true(light > last);
            last = light;
        }
        assert_close(sheen_transfer_decode((sheen_transfer)t, 0), 0, 0);
        assert_close(sheen_transfer_decode((sheen_transfer)t, 1), 1, 0);
        if (t == SHEEN_TRANSFER_LINEAR)
            continue;
        assert_close(sheen_transfer_encode((sheen_transfer)t, 7), 1, 0);
        assert_close(sheen_transfer_encode((sheen_transfer)t, -7), 0, 0);
        assert_close(sheen_transfer_encode((sheen_transfer)t, NAN), 0, 0);
        assert_close(sheen_transfer_decode((sheen_transfer)t, 7), 1, 0);
        assert_close(sheen_transfer_decode((sheen_transfer)t, NAN), 0, 0);
    }
}

static void knows_transfers_by_name(void **state)
{
    (void)state;
    sheen_err err;
    for (int t = 0; t < SHEEN_TRANSFER_COUNT; t++) {
        sheen_transfer back = SHEEN_TRANSFER_COUNT;
        assert_ok(sheen_transfer_from_name(&back, sheen_transfer_name((sheen_transfer)t), &err), err);
        assert_int_equal(back, t);
    }
    sheen_transfer untouched = SHEEN_TRANSFER_REC709;
    assert_int_equal(sheen_transfer_from_name(&untouched, "log3", &err), SHEEN_EARG);
    assert_string_equal(err.msg, "unknown transfer 'log3': use srgb, linear, rec709 or gamma22");
    assert_int_equal(untouched, SHEEN_TRANSFER_REC709);
}

static void turns_rasters_into_light(void **state)
{
    (void)state;
    sheen_err err;
    sheen_image img;
    uint8_t rgba[] = {0, 128, 255, 7, 10, 20, 30, 255};
    const sheen_raster r8 = {rgba, 2, 1, 4, 8};
    assert_ok(sheen_image_from_raster(&img, &r8, SHEEN_TRANSFER_SRGB, &err), err);
    assert_int_equal(img.n_channels, 3);
    assert_close(img.data[0], 0, 0);
    assert_close(img.data[1], 0.21586051, 1e-6); // sRGB 128
    assert_close(img.data[2], 1, 0);
    assert_close(img.data[3], 10 / 255.0 / 12.92, 1e-7); // alpha is skipped
    sheen_image_release(&img);

    uint16_t grey_alpha[] = {65535, 1, 32768, 2};
    const sheen_raster r16 = {grey_alpha, 1, 2, 2, 16};
    assert_ok(sheen_image_from_raster(&img, &r16, SHEEN_TRANSFER_LINEAR, &err), err);
    for (int c = 0; c < 3; c++) {
        assert_close(img.data[c], 1, 0);
        assert_close(img.data[3 + c], 32768 / 65535.0, 1e-7);
    }
    sheen_image_release(&img);

    float wide[] = {2.5f, NAN, INFINITY, -0.5f, -INFINITY, 1e30f};
    const sheen_raster rf = {wide, 2, 1, 3, 32};
    assert_ok(sheen_image_from_raster(&img, &rf, SHEEN_TRANSFER_SRGB, &err),
              err); // float is linear all the same
    static const double want[] = {2.5, 0, 1e9, -0.5, -1e9, 1e9};
    for (int i = 0; i < 6; i++)
        assert_close(img.data[i], (float)want[i], 0);
    sheen_image_release(&img);
}

static void coded_pictures_keep_their_codes_in_grey(void **state)
{
    (void)state;
    uint8_t codes[256], out[256];
    for (int i = 0; i < 256; i++)
        codes[i] = (uint8_t)i;
    const sheen_raster r = {codes, 16, 16, 1, 8};
    sheen_raster_grey(out, &r, SHEEN_TRANSFER_SRGB);
    assert_memory_equal(out, codes, sizeof codes);

    uint8_t rgb[] = {255, 0, 0, 0, 255, 0, 0, 0, 255};
    const sheen_raster colours = {rgb, 3, 1, 3, 8};
    sheen_raster_grey(out, &colours, SHEEN_TRANSFER_REC709);
    assert_int_equal(out[0], 54); // 0.2126 * 255 and so on, rounded
    assert_int_equal(out[1], 182);
    assert_int_equal(out[2], 18);
}

// 1000 pixels from 0 to 0.1 of full scale: the 5 brightest are above the percentile.
static void dark_linear_pictures_are_stretched(void **state)
{
    (void)state;
    enum { N = 1000 };
    static uint16_t light[N];
    static uint8_t out[N];
    for (int i = 0; i < N; i++)
        light[i] = (uint16_t)lround(6553.5 * i / (N - 1));
    const sheen_raster r = {light, 100, 10, 1, 16};
    sheen_raster_grey(out, &r, SHEEN_TRANSFER_LINEAR);
    const double white = light[N - 6] / 65535.0;
    for (int i = 0; i < N; i++) {
        const float scaled = (float)(light[i] / 65535.0 / white);
        assert_close(out[i], 255 * sheen_transfer_encode(SHEEN_TRANSFER_SRGB, scaled), 1.01);
    }
    assert_int_equal(out[N - 6], 255);
    assert_true(out[N - 30] < 255);
}

static void bright_linear_pictures_are_not_dimmed(void **state)
{
    (void)state;
    float light[] = {0.5f, 3, 2, NAN, -1, INFINITY};
    uint8_t out[6];
    const sheen_raster r = {light, 6, 1, 1, 32};
    sheen_raster_grey(out, &r, SHEEN_TRANSFER_SRGB);
    assert_int_equal(out[0], 188); // sRGB of 0.5
    assert_int_equal(out[1], 255);
    assert_int_equal(out[2], 255);
    for (int i = 3; i < 6; i++)
        assert_int_equal(out[i], 0);

    float black[4] = {0};
    const sheen_raster dark = {black, 2, 2, 1, 32};
    sheen_raster_grey(out, &dark, SHEEN_TRANSFER_LINEAR);
    for (int i = 0; i < 4; i++)
        assert_int_equal(out[i], 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(refuses_sizes_out_of_range),
        cmocka_unit_test(begins_black),
        cmocka_unit_test(samples_between_pixels),
        cmocka_unit_test(decodes_by_the_standards),
        cmocka_unit_test(codes_round_trip_and_clip),
        cmocka_unit_test(knows_transfers_by_name),
        cmocka_unit_test(turns_rasters_into_light),
        cmocka_unit_test(coded_pictures_keep_their_codes_in_grey),
        cmocka_unit_test(dark_linear_pictures_are_stretched),
        cmocka_unit_test(bright_linear_pictures_are_not_dimmed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// SPDX-License-Identifier: Apache-2.0
// test_pixel_payload.c - cameras' payloads by format; JPEGs in the matrix and range that is said of them.
#include <stdlib.h>
#include <string.h>

#include <linux/videodev2.h>

#include "base/image_file.h"
#include "base/pixel_format.h"
#include "tests/support.h"

enum { WIDTH = 17, HEIGHT = 13 };

// A JPEG of one colour; n_channels 1: grey of rgb[0].
static uint8_t *flat_jpeg(size_t *size_bytes, const uint8_t *rgb, int n_channels)
{
    sheen_raster r;
    sheen_err err;
    uint8_t *jpeg;
    assert_ok(sheen_raster_init(&r, WIDTH, HEIGHT, n_channels, 8, &err), err);
    for (int i = 0; i < WIDTH * HEIGHT * n_channels; i++)
        ((uint8_t *)r.data)[i] = rgb[i % n_channels];
    assert_ok(sheen_jpeg_encode(&jpeg, size_bytes, &r, 100, &err), err);
    sheen_raster_release(&r);
    return jpeg;
}

static void develop(double rgb[3], const uint8_t *data, size_t size_bytes, uint32_t fourcc,
                    const sheen_colorimetry *color)
{
    const sheen_pixel_layout l = {fourcc, WIDTH, HEIGHT, 0, *color};
    sheen_raster r;
    sheen_err err;
    assert_ok(sheen_payload_develop(&r, data, size_bytes, &l, &err), err);
    assert_int_equal(r.width_px, WIDTH);
    assert_int_equal(r.height_px, HEIGHT);
    const size_t last = (size_t)(WIDTH * HEIGHT - 1) * (size_t)r.n_channels;
    for (int c = 0; c < r.n_channels; c++)
        rgb[c] = r.bits == 8 ? ((uint8_t *)r.data)[last + (size_t)c] / 255.0
                             : ((uint16_t *)r.data)[last + (size_t)c] / 65535.0;
    sheen_raster_release(&r);
}

static void assert_rgb(const double got[3], double r, double g, double b)
{
    assert_close(got[0], r, 0.006);
    assert_close(got[1], g, 0.006);
    assert_close(got[2], b, 0.006);
}

// Coded as Y' 126, Cb 90, Cr 160.
static const uint8_t color_jfif[3] = {171, 116, 59};

static void a_jpeg_is_jfif_unless_something_else_is_said(void **state)
{
    (void)state;
    size_t size_bytes;
    uint8_t *jpeg = flat_jpeg(&size_bytes, color_jfif, 3);
    static const sheen_colorimetry jfif[] = {
        {0},
        {V4L2_COLORSPACE_SRGB, 0, 0, 0}, // V4L2's default for it is limited, and no camera's JPEG
        {V4L2_COLORSPACE_REC709, 0, 0, 0},
        {V4L2_COLORSPACE_SRGB, 0, V4L2_YCBCR_ENC_601, V4L2_QUANTIZATION_FULL_RANGE},
    };
    static const uint32_t fourccs[] = {0, V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_JPEG};
    double rgb[3];
    for (size_t i = 0; i < sizeof jfif / sizeof *jfif; i++) {
        develop(rgb, jpeg, size_bytes, fourccs[i % 3], &jfif[i]);
        assert_rgb(rgb, 171 / 255.0, 116 / 255.0, 59 / 255.0);
    }
    free(jpeg);
}

static void a_jpeg_in_limited_range_or_another_matrix_is_taken_so(void **state)
{
    (void)state;
    size_t size_bytes;
    uint8_t *jpeg = flat_jpeg(&size_bytes, color_jfif, 3);
    double rgb[3], y = 110 / 219.0, u = -38 / 224.0, v = 32 / 224.0;
    develop(rgb, jpeg, size_bytes, 0, &(sheen_colorimetry){.quantization = V4L2_QUANTIZATION_LIM_RANGE});
    assert_rgb(rgb, y + 1.402 * v, y - 0.344136 * u - 0.714136 * v, y + 1.772 * u);
    y = 126 / 255.0;
    u = -38 / 255.0;
    v = 32 / 255.0;
    develop(rgb, jpeg, size_bytes, V4L2_PIX_FMT_MJPEG, &(sheen_colorimetry){.ycbcr_enc = V4L2_YCBCR_ENC_709});
    assert_rgb(rgb, y + 1.5748 * v, y - 0.187324 * u - 0.468124 * v, y + 1.8556 * u);
    free(jpeg);
}

static void grey_in_limited_range_is_spread_and_clipped(void **state)
{
    (void)state;
    static const struct {
        uint8_t code;
        double level;
    } greys[] = {{16, 0}, {235, 1}, {126, 110 / 219.0}, {4, 0}, {250, 1}};
    const sheen_colorimetry limited = {.quantization = V4L2_QUANTIZATION_LIM_RANGE};
    for (size_t i = 0; i < sizeof greys / sizeof *greys; i++) {
        size_t size_bytes;
        double rgb[3];
        uint8_t *jpeg = flat_jpeg(&size_bytes, &greys[i].code, 1);
        develop(rgb, jpeg, size_bytes, 0, &limited);
        assert_close(rgb[0], greys[i].level, 0.006);
        free(jpeg);
    }
}

static void a_png_is_no_video(void **state)
{
    (void)state;
    sheen_raster r;
    sheen_err err;
    uint8_t *png;
    size_t size_bytes;
    double rgb[3];
    assert_ok(sheen_raster_init(&r, WIDTH, HEIGHT, 3, 8, &err), err);
    memset(r.data, 200, (size_t)(WIDTH * HEIGHT * 3));
    assert_ok(sheen_png_encode(&png, &size_bytes, &r, &err), err);
    sheen_raster_release(&r);
    develop(rgb, png, size_bytes, 0, &(sheen_colorimetry){.quantization = V4L2_QUANTIZATION_LIM_RANGE});
    assert_close(rgb[0], 200 / 255.0, 1e-9);
    free(png);
}

static void what_cannot_be_developed_is_said(void **state)
{
    (void)state;
    sheen_raster r;
    sheen_err err;
    size_t size_bytes;
    uint8_t *jpeg = flat_jpeg(&size_bytes, color_jfif, 3);
    sheen_pixel_layout l = {V4L2_PIX_FMT_H264, WIDTH, HEIGHT, 0, {0}};
    assert_fails(sheen_payload_develop(&r, jpeg, size_bytes, &l, &err), err, SHEEN_EUNSUP,
                 "cannot be developed");
    l = (sheen_pixel_layout){0, WIDTH, HEIGHT, 0, {.ycbcr_enc = V4L2_YCBCR_ENC_BT2020_CONST_LUM}};
    assert_fails(sheen_payload_develop(&r, jpeg, size_bytes, &l, &err), err, SHEEN_EUNSUP, "colour encoding");
    l.color = (sheen_colorimetry){.quantization = V4L2_QUANTIZATION_LIM_RANGE};
    assert_fails(sheen_payload_develop(&r, jpeg, size_bytes / 2, &l, &err), err, SHEEN_EFORMAT, "JPEG");
    assert_null(r.data);
    free(jpeg);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_jpeg_is_jfif_unless_something_else_is_said),
        cmocka_unit_test(a_jpeg_in_limited_range_or_another_matrix_is_taken_so),
        cmocka_unit_test(grey_in_limited_range_is_spread_and_clipped),
        cmocka_unit_test(a_png_is_no_video),
        cmocka_unit_test(what_cannot_be_developed_is_said),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

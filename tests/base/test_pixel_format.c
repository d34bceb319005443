// SPDX-License-Identifier: Apache-2.0
// test_pixel_format.c - raw frames against values worked out by hand.
#include "base/pixel_format.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <linux/videodev2.h>

#include "tests/support.h"

static sheen_pixel_layout layout(uint32_t fourcc, int width_px, int height_px)
{
    sheen_pixel_layout l = {.fourcc = fourcc, .width_px = width_px, .height_px = height_px};
    l.stride_bytes = (int)sheen_pixels_stride(fourcc, width_px);
    return l;
}

static uint16_t *develop(sheen_raster *r, const void *data, size_t size_bytes, const sheen_pixel_layout *l)
{
    sheen_err err;
    assert_ok(sheen_pixels_develop(r, data, size_bytes, l, &err), err);
    assert_int_equal(r->bits, 16);
    return r->data;
}

static void assert_rgb(const uint16_t *got, double r, double g, double b, double tolerance)
{
    assert_close(got[0] / 65535.0, r, tolerance);
    assert_close(got[1] / 65535.0, g, tolerance);
    assert_close(got[2] / 65535.0, b, tolerance);
}

static void yuyv_follows_matrix_and_range(void **state)
{
    (void)state;
    sheen_raster r;
    // Y 126, Cb 90, Cr 160, twice.
    static const uint8_t pair[] = {126, 90, 126, 160};
    sheen_pixel_layout l = layout(V4L2_PIX_FMT_YUYV, 2, 1);
    // Default: limited range, BT.601. Y' = 110/219, Cb = -38/224, Cr = 32/224.
    const double y = 110 / 219.0, u = -38 / 224.0, v = 32 / 224.0;
    uint16_t *rgb = develop(&r, pair, 4, &l);
    assert_rgb(rgb, y + 1.402 * v, y - 0.344136 * u - 0.714136 * v, y + 1.772 * u, 2e-5);
    assert_rgb(rgb + 3, y + 1.402 * v, y - 0.344136 * u - 0.714136 * v, y + 1.772 * u, 2e-5);
    sheen_raster_release(&r);
    // BT.709 by colorspace.
    l.color.colorspace = V4L2_COLORSPACE_REC709;
    rgb = develop(&r, pair, 4, &l);
    assert_rgb(rgb, y + 1.5748 * v, y - 0.187324 * u - 0.468124 * v, y + 1.8556 * u, 2e-5);
    sheen_raster_release(&r);
    // Full range.
    l.color = (sheen_colorimetry){V4L2_COLORSPACE_SRGB, 0, V4L2_YCBCR_ENC_601, V4L2_QUANTIZATION_FULL_RANGE};
    rgb = develop(&r, pair, 4, &l);
    assert_rgb(rgb, (126 + 1.402 * 32) / 255, (126 + 0.344136 * 38 - 0.714136 * 32) / 255,
               (126 - 1.772 * 38) / 255, 2e-5);
    sheen_raster_release(&r);
    // White and black of limited range, and what lies beyond them.
    static const uint8_t ends[] = {235, 128, 16, 128, 255, 128, 0, 128};
    l = layout(V4L2_PIX_FMT_YUYV, 4, 1);
    rgb = develop(&r, ends, 8, &l);
    assert_rgb(rgb, 1, 1, 1, 0);
    assert_rgb(rgb + 3, 0, 0, 0, 0);
    assert_rgb(rgb + 6, 1, 1, 1, 0);
    assert_rgb(rgb + 9, 0, 0, 0, 0);
    sheen_raster_release(&r);
}

static void chroma_is_interpolated(void **state)
{
    (void)state;
    sheen_raster r;
    sheen_pixel_layout l = layout(V4L2_PIX_FMT_YUYV, 4, 1);
    l.color.quantization = V4L2_QUANTIZATION_FULL_RANGE;
    static const uint8_t row[] = {100, 128, 100, 128, 100, 128, 100, 168};
    const uint16_t *rgb = develop(&r, row, 8, &l); // Cr 0, 20, 40, 40
    const double cr[] = {0, 20, 40, 40};
    for (int x = 0; x < 4; x++)
        assert_close(rgb[3 * x] / 65535.0, (100 + 1.402 * cr[x]) / 255, 2e-5);
    sheen_raster_release(&r);
    // NV12, rows 6 bytes apart: Cr 0 left, 64 right; 9/16, 3/16 and so on at the four columns: 0, 16, 48, 64.
    l = layout(V4L2_PIX_FMT_NV12, 4, 2);
    l.stride_bytes = 6;
    l.color.quantization = V4L2_QUANTIZATION_FULL_RANGE;
    static const uint8_t nv12[] = {100, 100, 100, 100, 7, 7, 50, 50, 50, 50, 7, 7, 128, 128, 128, 192};
    rgb = develop(&r, nv12, sizeof nv12, &l);
    const double nv_cr[] = {0, 16, 48, 64};
    for (int x = 0; x < 4; x++) {
        assert_close(rgb[3 * x] / 65535.0, (100 + 1.402 * nv_cr[x]) / 255, 2e-5);
        assert_close(rgb[12 + 3 * x] / 65535.0, (50 + 1.402 * nv_cr[x]) / 255, 2e-5);
        assert_close(rgb[3 * x + 2] / 65535.0, 100 / 255.0, 2e-5);
    }
    sheen_raster_release(&r);
}

static void grey_and_rgb_are_taken_as_they_are(void **state)
{
    (void)state;
    sheen_raster r;
    static const uint8_t grey[] = {0, 51, 99, 255, 255, 99}; // stride 3
    sheen_pixel_layout l = layout(V4L2_PIX_FMT_GREY, 2, 2);
    l.stride_bytes = 3;
    const uint16_t *v = develop(&r, grey, 5, &l);
    assert_int_equal(r.n_channels, 1);
    assert_true(v[0] == 0 && v[1] == 51 * 257 && v[2] == 65535 && v[3] == 65535);
    sheen_raster_release(&r);
    static const uint8_t y10[] = {0xff, 0x03, 0x00, 0x02}; // 1023, 512
    l = layout(V4L2_PIX_FMT_Y10, 2, 1);
    v = develop(&r, y10, 4, &l);
    assert_true(v[0] == 65535 && v[1] == (512 * 65535 + 511) / 1023);
    sheen_raster_release(&r);
    static const uint8_t bgr[] = {1, 2, 3, 16, 235, 126};
    l = layout(V4L2_PIX_FMT_BGR24, 2, 1);
    v = develop(&r, bgr, 6, &l);
    assert_rgb(v, 3 / 255.0, 2 / 255.0, 1 / 255.0, 1e-5);
    sheen_raster_release(&r);
    l.fourcc = V4L2_PIX_FMT_RGB24;
    l.color.quantization = V4L2_QUANTIZATION_LIM_RANGE;
    v = develop(&r, bgr, 6, &l);
    assert_rgb(v + 3, 0, 1, 110 / 219.0, 2e-5);
    sheen_raster_release(&r);
}

// A flat mosaic of one colour comes out as that colour everywhere, in each order, width and packing.
static void mosaics_of_one_colour_are_that_colour(void **state)
{
    (void)state;
    static const struct {
        uint32_t fourcc;
        int bits, packed, red;
    } cases[] = {
        {V4L2_PIX_FMT_SRGGB8, 8, 0, 0},    {V4L2_PIX_FMT_SGRBG8, 8, 0, 1},
        {V4L2_PIX_FMT_SGBRG8, 8, 0, 2},    {V4L2_PIX_FMT_SBGGR8, 8, 0, 3},
        {V4L2_PIX_FMT_SRGGB10, 10, 0, 0},  {V4L2_PIX_FMT_SGBRG10P, 10, 1, 2},
        {V4L2_PIX_FMT_SBGGR10P, 10, 1, 3}, {V4L2_PIX_FMT_SGRBG12, 12, 0, 1},
        {V4L2_PIX_FMT_SRGGB12P, 12, 1, 0}, {V4L2_PIX_FMT_SGRBG14, 14, 0, 1},
        {V4L2_PIX_FMT_SBGGR16, 16, 0, 3},
    };
    enum { W = 8, H = 6 };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const int bits = cases[k].bits, max = (1 << bits) - 1, low = bits - 8;
        const int colour[3] = {max * 3 / 4 + 1, max / 2, max / 5 + 2};
        uint8_t data[W * H * 2] = {0};
        const sheen_pixel_layout l = layout(cases[k].fourcc, W, H);
        for (int y = 0; y < H; y++)
            for (int x = 0; x < W; x++) {
                const int place = (x % 2 + 2 * (y % 2)) ^ cases[k].red; // red's is 0, blue's 3
                const int code = colour[place == 0 ? 0 : place == 3 ? 2 : 1];
                uint8_t *row = data + y * l.stride_bytes;
                if (cases[k].packed) {
                    const int group = bits == 10 ? 4 : 2;
                    uint8_t *g = row + x / group * (group + 1);
                    g[x % group] = (uint8_t)(code >> low);
                    g[group] = (uint8_t)(g[group] | (code & ((1 << low) - 1)) << (low * (x % group)));
                } else if (bits == 8)
                    row[x] = (uint8_t)code;
                else {
                    row[2 * x] = (uint8_t)(code & 255);
                    row[2 * x + 1] = (uint8_t)(code >> 8);
                }
            }
        sheen_raster r;
        const uint16_t *rgb = develop(&r, data, sizeof data, &l);
        for (int i = 0; i < W * H; i++)
            for (int c = 0; c < 3; c++)
                assert_close(rgb[3 * i + c] / 65535.0, (double)colour[c] / max, 1e-4);
        sheen_raster_release(&r);
    }
}

// A single bright red sample: the paper's weights about it, at sites of each kind.
static void mosaics_have_the_weights_of_the_paper(void **state)
{
    (void)state;
    enum { W = 12, H = 12 };
    uint8_t data[W * H];
    memset(data, 100, sizeof data);
    data[6 * W + 6] = 180; // red in RGGB
    const sheen_pixel_layout l = layout(V4L2_PIX_FMT_SRGGB8, W, H);
    sheen_raster r;
    const uint16_t *rgb = develop(&r, data, sizeof data, &l);
#define AT(x, y, c) (rgb[3 * ((y)*W + (x)) + (c)] / 257.0 - 100)
    assert_close(AT(6, 6, 0), 80, 0.01);
    assert_close(AT(6, 6, 1), 80 * 4 / 8.0, 0.01);
    assert_close(AT(6, 6, 2), 80 * 6 / 8.0, 0.01);
    assert_close(AT(5, 6, 0), 80 * 4 / 8.0, 0.01); // green beside it
    assert_close(AT(5, 6, 2), 80 * 0 / 8.0, 0.01);
    assert_close(AT(6, 7, 0), 80 * 4 / 8.0, 0.01);  // green below it
    assert_close(AT(7, 7, 0), 80 * 2 / 8.0, 0.01);  // blue
    assert_close(AT(8, 6, 1), 80 * -1 / 8.0, 0.01); // the next red
    assert_close(AT(8, 6, 2), 80 * -1.5 / 8, 0.01);
#undef AT
    sheen_raster_release(&r);
}

static void curves_are_those_that_were_reported(void **state)
{
    (void)state;
    static const struct {
        uint32_t fourcc, colorspace, xfer_func;
        sheen_transfer want;
    } cases[] = {
        {V4L2_PIX_FMT_MJPEG, V4L2_COLORSPACE_SRGB, 0, SHEEN_TRANSFER_SRGB},
        {V4L2_PIX_FMT_MJPEG, V4L2_COLORSPACE_JPEG, 0, SHEEN_TRANSFER_SRGB},
        {V4L2_PIX_FMT_YUYV, V4L2_COLORSPACE_SMPTE170M, 0, SHEEN_TRANSFER_REC709},
        {V4L2_PIX_FMT_YUYV, V4L2_COLORSPACE_SRGB, V4L2_XFER_FUNC_709, SHEEN_TRANSFER_REC709},
        {V4L2_PIX_FMT_YUYV, V4L2_COLORSPACE_OPRGB, 0, SHEEN_TRANSFER_GAMMA22},
        {V4L2_PIX_FMT_GREY, V4L2_COLORSPACE_RAW, 0, SHEEN_TRANSFER_LINEAR},
        {V4L2_PIX_FMT_SRGGB10P, V4L2_COLORSPACE_SRGB, 0, SHEEN_TRANSFER_LINEAR},
        {V4L2_PIX_FMT_SRGGB8, V4L2_COLORSPACE_SRGB, V4L2_XFER_FUNC_SRGB, SHEEN_TRANSFER_SRGB},
    };
    sheen_err err;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const sheen_colorimetry c = {cases[i].colorspace, cases[i].xfer_func, 0, 0};
        sheen_transfer got;
        assert_ok(sheen_pixels_transfer(&got, cases[i].fourcc, &c, &err), err);
        assert_int_equal(got, cases[i].want);
    }
    sheen_transfer got;
    const sheen_colorimetry p3 = {V4L2_COLORSPACE_DCI_P3, 0, 0, 0};
    assert_fails(sheen_pixels_transfer(&got, V4L2_PIX_FMT_YUYV, &p3, &err), err, SHEEN_EUNSUP,
                 "transfer function");
}

static void impossible_frames_are_refused(void **state)
{
    (void)state;
    static const uint8_t data[64];
    sheen_raster r;
    sheen_err err;
    sheen_pixel_layout l = layout(V4L2_PIX_FMT_YUYV, 4, 2);
    assert_int_equal(sheen_pixels_size(&l), 16);
    assert_fails(sheen_pixels_develop(&r, data, 15, &l, &err), err, SHEEN_EFORMAT, "15 of 16");
    l.stride_bytes = 7;
    assert_fails(sheen_pixels_develop(&r, data, 64, &l, &err), err, SHEEN_EFORMAT, "rows of 7");
    l.stride_bytes = 12;
    assert_int_equal(sheen_pixels_size(&l), 20); // the last row may end early
    l.width_px = 3;
    assert_fails(sheen_pixels_develop(&r, data, 64, &l, &err), err, SHEEN_EFORMAT, "3 x 2");
    l.fourcc = V4L2_PIX_FMT_MJPEG;
    assert_fails(sheen_pixels_develop(&r, data, 64, &l, &err), err, SHEEN_EUNSUP, "raw data");
    l = layout(V4L2_PIX_FMT_YUYV, 4, 2);
    l.color.ycbcr_enc = V4L2_YCBCR_ENC_BT2020_CONST_LUM;
    assert_fails(sheen_pixels_develop(&r, data, 64, &l, &err), err, SHEEN_EUNSUP, "encoding");
    assert_true(!sheen_pixels_known(V4L2_PIX_FMT_MJPEG) && sheen_pixels_known(V4L2_PIX_FMT_NV12));
    l = layout(V4L2_PIX_FMT_SRGGB10P, 6, 2); // groups of four
    assert_int_equal(l.stride_bytes, 0);
    l = (sheen_pixel_layout){V4L2_PIX_FMT_GREY, 40000, 40000, 40000, {0}};
    assert_fails(sheen_pixels_develop(&r, data, 64, &l, &err), err, SHEEN_EFORMAT, "40000");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(yuyv_follows_matrix_and_range),
        cmocka_unit_test(chroma_is_interpolated),
        cmocka_unit_test(grey_and_rgb_are_taken_as_they_are),
        cmocka_unit_test(mosaics_of_one_colour_are_that_colour),
        cmocka_unit_test(mosaics_have_the_weights_of_the_paper),
        cmocka_unit_test(curves_are_those_that_were_reported),
        cmocka_unit_test(impossible_frames_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

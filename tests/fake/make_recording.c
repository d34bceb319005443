// SPDX-License-Identifier: Apache-2.0
// make_recording.c - a program that writes what a camera might have recorded, as a session and as plain files:
//
//     make_recording SESSION FORMAT WIDTH HEIGHT FRAMES
//
// FORMAT is V4L2's four letters. Every frame differs from every other, and every byte of raw frames is noise, so that
// bytes that get lost, moved or swapped show. MJPG frames are pictures that every decoder agrees about: grey ramps.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <linux/videodev2.h>

#include "base/image_file.h"
#include "base/session.h"
#include "tests/support.h"

static void fill_noise(uint8_t *data, size_t size_bytes, uint64_t seed)
{
    uint64_t x = seed * 0x9e3779b97f4a7c15u + 1;
    for (size_t i = 0; i < size_bytes; i++) {
        x ^= x << 13;
        x ^= x >> 7;
        x ^= x << 17;
        data[i] = (uint8_t)(x >> 24);
    }
}

static uint8_t *make_jpeg(size_t *size_bytes, const char *scratch, int width_px, int height_px, int i)
{
    sheen_err err;
    sheen_raster r = {0};
    assert_ok(sheen_raster_init(&r, width_px, height_px, 3, 8, &err), err);
    uint8_t *px = r.data;
    for (int y = 0; y < height_px; y++)
        for (int x = 0; x < width_px; x++)
            memset(px + 3 * ((size_t)y * (size_t)width_px + (size_t)x),
                   20 + (200 * x / width_px + 17 * i) % 216, 3);
    assert_ok(sheen_jpeg_write(scratch, &r, 95, &err), err);
    sheen_raster_release(&r);
    uint8_t *data = test_file_read(scratch, size_bytes);
    remove(scratch);
    return data;
}

static void describe(sheen_frame_info *f, int i, const char *format, int width_px, int height_px)
{
    static const sheen_frame_control controls[] = {{V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL},
                                                   {V4L2_CID_EXPOSURE_ABSOLUTE, 200},
                                                   {V4L2_CID_GAIN, 17},
                                                   {V4L2_CID_AUTO_WHITE_BALANCE, 0}};
    const bool jpeg = !strcmp(format, "MJPG");
    char padded[8];
    sheen_frame_info_init(f);
    snprintf(padded, sizeof padded, "%-4s", format);
    f->fourcc = jpeg ? 0 : v4l2_fourcc(padded[0], padded[1], padded[2], padded[3]);
    f->width_px = width_px;
    f->height_px = height_px;
    f->stride_bytes = jpeg ? 0 : (int)sheen_pixels_stride(f->fourcc, width_px);
    f->color = (sheen_colorimetry){jpeg ? V4L2_COLORSPACE_JPEG : V4L2_COLORSPACE_SRGB, 0, 0, 0};
    f->sequence = i;
    f->t_ns = 1000000000 + (int64_t)i * 33333333;
    f->lock = SHEEN_LOCK_HELD;
    f->n_controls = sizeof controls / sizeof *controls;
    memcpy(f->controls, controls, sizeof controls);
}

int main(int argc, char **argv)
{
    sheen_session s;
    sheen_err err;
    if (argc != 6)
        return 2;
    const char *format = argv[2];
    const int width_px = atoi(argv[3]), height_px = atoi(argv[4]), n = atoi(argv[5]); // NOLINT(cert-err34-c)
    assert_ok(sheen_session_create(&s, argv[1], SHEEN_MOVING_CAMERA, &err), err);
    for (int i = 0; i < n; i++) {
        sheen_frame_info f;
        uint8_t *data;
        size_t size_bytes;
        char scratch[TEST_PATH_MAX];
        describe(&f, i, format, width_px, height_px);
        assert_ok(sheen_pixels_transfer(&f.transfer, f.fourcc, &f.color, &err), err);
        if (f.fourcc) {
            const sheen_pixel_layout layout = {f.fourcc, width_px, height_px, f.stride_bytes, f.color};
            size_bytes = sheen_pixels_size(&layout);
            data = malloc(size_bytes);
            assert_non_null(data);
            fill_noise(data, size_bytes, (uint64_t)i + 1);
        } else {
            snprintf(scratch, sizeof scratch, "%s/scratch.jpg", argv[1]);
            data = make_jpeg(&size_bytes, scratch, width_px, height_px, i);
        }
        sheen_session_next_name(&s, f.name);
        assert_ok(sheen_session_add_frame(&s, &f, f.fourcc ? "raw" : "jpg", data, size_bytes, &err), err);
        free(data);
    }
    sheen_session_release(&s);
    return 0;
}

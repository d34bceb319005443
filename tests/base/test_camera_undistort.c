// SPDX-License-Identifier: Apache-2.0
// test_camera_undistort.c - photographs without their distortion: every pixel shows its own direction.
#include "base/camera_undistort.h"

#include <math.h>
#include <string.h>

#include "tests/support.h"

enum { W = 320, H = 240 };

// Two smooth functions of the direction x/z, y/z, so that a pixel tells where its light came from.
static void paint(float out[2], double x, double y)
{
    out[0] = (float)(0.5 + x);
    out[1] = (float)(0.5 + y);
}

static sheen_camera pinhole_of(double focal_px)
{
    const double fxycxy[4] = {focal_px, focal_px, 0.5 * (W - 1), 0.5 * (H - 1)};
    sheen_camera cam;
    sheen_err err;
    assert_ok(sheen_camera_opencv(&cam, W, H, fxycxy, NULL, 0, &err), err);
    return cam;
}

// A wide lens, five coefficients; and what it photographs of the two functions.
static void photograph(sheen_camera *cam, sheen_image *img)
{
    static const double fxycxy[4] = {300, 296, 163, 117}, brown[5] = {-0.2, 0.06, 0.002, -0.001, 0.01};
    sheen_err err;
    assert_ok(sheen_camera_opencv(cam, W, H, fxycxy, brown, 5, &err), err);
    assert_ok(sheen_image_init(img, W, H, 2, &err), err);
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            const double q_px[2] = {x, y};
            double v[3];
            assert_ok(sheen_camera_unproject(cam, v, q_px, 1, &err), err);
            paint(sheen_image_at(img, x, y), v[0] / v[2], v[1] / v[2]);
        }
}

static void every_pixel_shows_its_direction(void **state)
{
    (void)state;
    sheen_camera cam;
    const sheen_camera pinhole = pinhole_of(280);
    sheen_image img, out, by_three;
    sheen_err err;
    int n_seen = 0;
    photograph(&cam, &img);
    assert_ok(sheen_image_undistort(&out, &img, &cam, &pinhole, 1, &err), err);
    assert_int_equal(out.n_channels, 2);
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            const double v[3] = {(x - pinhole.intrinsics[2]) / 280, (y - pinhole.intrinsics[3]) / 280, 1};
            const float *got = sheen_image_at(&out, x, y);
            double q_px[2];
            float want[2];
            assert_ok(sheen_camera_project(&cam, q_px, NULL, v, 1, &err), err);
            const int within = q_px[0] >= 0 && q_px[1] >= 0 && q_px[0] <= W - 1 && q_px[1] <= H - 1;
            if (!within) { // no light came from there
                assert_true(got[0] <= 0 && got[1] <= 0);
                continue;
            }
            n_seen++;
            if (q_px[0] > W - 2 || q_px[1] > H - 2)
                continue; // its neighbours may be outside
            paint(want, v[0], v[1]);
            assert_close(got[0], want[0], 1e-4);
            assert_close(got[1], want[1], 1e-4);
        }
    assert_in_range(n_seen, W * H / 2, W * H - 1); // some of either kind
    assert_ok(sheen_image_undistort(&by_three, &img, &cam, &pinhole, 3, &err), err);
    assert_memory_equal(by_three.data, out.data, W * H * 2 * sizeof(float));
    sheen_image_release(&by_three);
    sheen_image_release(&out);
    sheen_image_release(&img);
}

// A pinhole's own picture comes back as it was.
static void nothing_to_do_changes_nothing(void **state)
{
    (void)state;
    const sheen_camera cam = pinhole_of(300);
    sheen_image img, out;
    sheen_err err;
    uint64_t seed = 1;
    assert_ok(sheen_image_init(&img, W, H, 3, &err), err);
    for (int i = 0; i < W * H * 3; i++)
        img.data[i] = (float)test_random(&seed);
    assert_ok(sheen_image_undistort(&out, &img, &cam, &cam, 0, &err), err);
    for (int y = 1; y < H - 1; y++)
        for (int k = 3; k < 3 * (W - 1); k++)
            assert_close(sheen_image_at(&out, 0, y)[k], sheen_image_at(&img, 0, y)[k], 1e-4);
    sheen_image_release(&out);
    sheen_image_release(&img);
}

static void what_does_not_fit_is_refused(void **state)
{
    (void)state;
    sheen_camera cam, bad;
    const sheen_camera pinhole = pinhole_of(280);
    sheen_image img, small, out = {0};
    sheen_err err;
    photograph(&cam, &img);
    assert_ok(sheen_image_init(&small, W / 2, H, 3, &err), err);
    assert_fails(sheen_image_undistort(&out, &small, &cam, &pinhole, 1, &err), err, SHEEN_EARG,
                 "160 x 240 px is not of this camera");
    assert_fails(sheen_image_undistort(&out, &img, &cam, &cam, 1, &err), err, SHEEN_EARG, "");
    bad = cam;
    bad.intrinsics[0] = (double)NAN;
    assert_int_not_equal(sheen_image_undistort(&out, &img, &bad, &pinhole, 1, &err), SHEEN_OK);
    assert_null(out.data);
    sheen_image_release(&small);
    sheen_image_release(&img);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_pixel_shows_its_direction),
        cmocka_unit_test(nothing_to_do_changes_nothing),
        cmocka_unit_test(what_does_not_fit_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

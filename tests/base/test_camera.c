// SPDX-License-Identifier: Apache-2.0
// test_camera.c - lens models by hand, round trips, and .cameramodel files.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/camera.h"
#include "support.h"

static const double fxycxy[4] = {1500, 1490, 648.2, 471.7};
static const double brown[5] = {-0.12, 0.05, 0.0008, -0.0006, 0.01};

static sheen_camera lens(int n_distortion)
{
    sheen_camera cam;
    sheen_err err;
    assert_ok(sheen_camera_opencv(&cam, 1280, 960, fxycxy, brown, n_distortion, &err), err);
    return cam;
}

// OpenCV's formula, written out.
static void projection_is_opencvs(void **state)
{
    (void)state;
    const sheen_camera cam = lens(5);
    const double p[3] = {0.12, -0.07, 0.5}, x = p[0] / p[2], y = p[1] / p[2], r2 = x * x + y * y;
    const double radial = 1 + brown[0] * r2 + brown[1] * r2 * r2 + brown[4] * r2 * r2 * r2;
    const double xd = x * radial + 2 * brown[2] * x * y + brown[3] * (r2 + 2 * x * x);
    const double yd = y * radial + brown[2] * (r2 + 2 * y * y) + 2 * brown[3] * x * y;
    double q[2];
    sheen_err err;
    assert_ok(sheen_camera_project(&cam, q, NULL, p, 1, &err), err);
    assert_close(q[0], fxycxy[0] * xd + fxycxy[2], 1e-9);
    assert_close(q[1], fxycxy[1] * yd + fxycxy[3], 1e-9);
}

static void unprojection_is_the_inverse(void **state)
{
    (void)state;
    static const int n_distortion[] = {0, 4, 5};
    for (size_t k = 0; k < 3; k++) {
        const sheen_camera cam = lens(n_distortion[k]);
        sheen_err err;
        double q[2 * 9], back[2 * 9], v[3 * 9];
        for (int i = 0; i < 9; i++) {
            q[2 * i] = 640 * (i % 3);
            q[2 * i + 1] = 480 * (i / 3);
        }
        assert_ok(sheen_camera_unproject(&cam, v, q, 9, &err), err);
        assert_ok(sheen_camera_project(&cam, back, NULL, v, 9, &err), err);
        for (int i = 0; i < 18; i++)
            assert_close(back[i], q[i], 1e-4);
        for (int i = 0; i < 9; i++)
            assert_close(v[3 * i] * v[3 * i] + v[3 * i + 1] * v[3 * i + 1] + v[3 * i + 2] * v[3 * i + 2], 1,
                         1e-12);
    }
}

static void gradient_is_that_of_differences(void **state)
{
    (void)state;
    const sheen_camera cam = lens(5);
    const double p[3] = {0.1, 0.05, 0.6}, h = 1e-6;
    double q[2], dq_dp[6], ahead[2], behind[2];
    sheen_err err;
    assert_ok(sheen_camera_project(&cam, q, dq_dp, p, 1, &err), err);
    for (int i = 0; i < 3; i++) {
        double a[3] = {p[0], p[1], p[2]}, b[3] = {p[0], p[1], p[2]};
        a[i] += h;
        b[i] -= h;
        assert_ok(sheen_camera_project(&cam, ahead, NULL, a, 1, &err), err);
        assert_ok(sheen_camera_project(&cam, behind, NULL, b, 1, &err), err);
        for (int k = 0; k < 2; k++)
            assert_close(dq_dp[3 * k + i], (ahead[k] - behind[k]) / (2 * h), 1e-3);
    }
}

static void behind_the_camera_is_not_a_pixel(void **state)
{
    (void)state;
    const sheen_camera cam = lens(4);
    const double p[6] = {0, 0, -1, 0, 0, 0};
    double q[4];
    sheen_err err;
    assert_ok(sheen_camera_project(&cam, q, NULL, p, 2, &err), err);
    for (int i = 0; i < 4; i++)
        assert_true(isnan(q[i]));
}

static void file_keeps_every_digit(void **state)
{
    char path[TEST_PATH_MAX];
    sheen_camera cam = lens(5), back;
    sheen_err err;
    cam.intrinsics[6] = 0.00079999999999999993;
    cam.rt_cam_ref[2] = 0.1 + 0.2;
    test_scratch_file(path, *state, "a.cameramodel");
    assert_ok(sheen_camera_save(&cam, path, &err), err);
    assert_ok(sheen_camera_load(&back, path, &err), err);
    assert_string_equal(back.lensmodel, "LENSMODEL_OPENCV5");
    assert_int_equal(back.n_intrinsics, 9);
    assert_int_equal(back.width_px, 1280);
    assert_memory_equal(back.intrinsics, cam.intrinsics, 9 * sizeof(double));
    assert_memory_equal(back.rt_cam_ref, cam.rt_cam_ref, sizeof cam.rt_cam_ref);
}

static void refuses_what_is_no_camera(void **state)
{
    (void)state;
    static const struct {
        const char *text, *part;
    } cases[] = {
        {"", "empty or not a text"},
        {"hello", "not a .cameramodel"},
        {"{ 'lensmodel': 'LENSMODEL_PINHOLE', 'intrinsics': [1, 1, 0, 0], 'extrinsics': [0,0,0,0,0,0],",
         "not a .cameramodel"},
        {"{ 'lensmodel': 'LENSMODEL_NOPE', 'intrinsics': [1, 1, 0, 0], 'extrinsics': [0,0,0,0,0,0], "
         "'imagersize': [9, 9] }",
         "not a .cameramodel"},
        {"{ 'lensmodel': 'LENSMODEL_PINHOLE', 'intrinsics': [-1, 1, 0, 0], 'extrinsics': [0,0,0,0,0,0], "
         "'imagersize': [9, 9] }",
         "not positive"},
        {"{ 'lensmodel': 'LENSMODEL_PINHOLE', 'intrinsics': [1, 1, 0, 0], 'extrinsics': [0,0,0,0,0,0], "
         "'imagersize': [99999, 9] }",
         "out of range"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        sheen_camera cam;
        sheen_err err;
        assert_fails(sheen_camera_parse(&cam, cases[i].text, strlen(cases[i].text), &err), err, SHEEN_EFORMAT,
                     cases[i].part);
    }
    sheen_camera cam;
    sheen_err err;
    const double bad[4] = {1500, (double)NAN, 1, 1};
    assert_fails(sheen_camera_opencv(&cam, 10, 10, fxycxy, brown, 3, &err), err, SHEEN_EARG,
                 "no lens model has 3");
    assert_fails(sheen_camera_opencv(&cam, 10, 10, bad, NULL, 0, &err), err, SHEEN_EARG,
                 "not a finite number");
}

// A scaled camera sees the same directions at q' + 1/2 = factor (q + 1/2).
static void scaling_keeps_directions(void **state)
{
    (void)state;
    const sheen_camera cam = lens(5);
    sheen_camera half;
    sheen_err err;
    const double p[3] = {0.1, -0.05, 0.5};
    double q[2], q_half[2];
    assert_ok(sheen_camera_scale(&half, &cam, 0.5, &err), err);
    assert_int_equal(half.width_px, 640);
    assert_ok(sheen_camera_project(&cam, q, NULL, p, 1, &err), err);
    assert_ok(sheen_camera_project(&half, q_half, NULL, p, 1, &err), err);
    for (int i = 0; i < 2; i++)
        assert_close(q_half[i] + 0.5, 0.5 * (q[i] + 0.5), 1e-9);
    assert_fails(sheen_camera_scale(&half, &cam, 0, &err), err, SHEEN_EARG, "cannot scale");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(projection_is_opencvs),
        cmocka_unit_test(unprojection_is_the_inverse),
        cmocka_unit_test(gradient_is_that_of_differences),
        cmocka_unit_test(behind_the_camera_is_not_a_pixel),
        cmocka_unit_test_setup_teardown(file_keeps_every_digit, test_scratch_setup, test_scratch_teardown),
        cmocka_unit_test(refuses_what_is_no_camera),
        cmocka_unit_test(scaling_keeps_directions),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

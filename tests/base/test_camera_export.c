// SPDX-License-Identifier: Apache-2.0
// Cameras as other programs' files: what we read of them ourselves comes back; what a format cannot say is refused.
#include "tests/support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/camera_export.h"
#include "base/pose_file.h"

static const double core[4] = {1500.25, 1499.5, 640.125, 480.375};
static const double k[8] = {-0.1, 0.05, 0.001, -0.002, 0.01, 0.02, -0.03, 0.004};

static void opencv_and_ros_files_come_back(void **state)
{
    static const char *const names[] = {"c.opencv.yaml", "c.ros.yaml"};
    for (int i = 0; i < 4; i++) {
        sheen_err err;
        sheen_camera made, read;
        sheen_camera_format format;
        char path[TEST_PATH_MAX];
        size_t size_bytes;
        const int n = i < 2 ? 5 : 8;
        test_scratch_file(path, *state, names[i % 2]);
        assert_ok(sheen_camera_opencv(&made, 1280, 960, core, k, n, &err), err);
        assert_ok(sheen_camera_format_of(&format, path, &err), err);
        assert_ok(sheen_camera_export(&made, format, path, &err), err);
        uint8_t *data = test_file_read(path, &size_bytes);
        assert_ok(sheen_opencv_yaml_parse(&read, data, size_bytes, 1280, 960, &err), err);
        free(data);
        assert_string_equal(read.lensmodel, made.lensmodel);
        for (int p = 0; p < made.n_intrinsics; p++)
            assert_close(read.intrinsics[p], made.intrinsics[p], 0);
    }
}

static void colmap_counts_from_the_corner(void **state)
{
    sheen_err err;
    sheen_camera camera;
    char path[TEST_PATH_MAX];
    size_t size_bytes;
    test_scratch_file(path, *state, "cameras.colmap.txt");
    assert_ok(sheen_camera_opencv(&camera, 1280, 960, core, k, 4, &err), err);
    assert_ok(sheen_camera_export(&camera, SHEEN_CAMERA_COLMAP, path, &err), err);
    char *text = (char *)test_file_read(path, &size_bytes);
    assert_non_null(strstr(text, "\n1 OPENCV 1280 960 1500.25 1499.5 640.625 480.875 -0.1"));
    free(text);
}

static void kalibr_holds_four_coefficients(void **state)
{
    sheen_err err;
    sheen_camera camera;
    char path[TEST_PATH_MAX];
    size_t size_bytes;
    test_scratch_file(path, *state, "c.kalibr.yaml");
    assert_ok(sheen_camera_opencv(&camera, 1280, 960, core, k, 4, &err), err);
    assert_ok(sheen_camera_export(&camera, SHEEN_CAMERA_KALIBR, path, &err), err);
    char *text = (char *)test_file_read(path, &size_bytes);
    assert_non_null(strstr(text, "intrinsics: [1500.25, 1499.5, 640.125, 480.375]"));
    assert_non_null(strstr(text, "resolution: [1280, 960]"));
    free(text);
    assert_ok(sheen_camera_opencv(&camera, 1280, 960, core, k, 8, &err), err);
    assert_fails(sheen_camera_export(&camera, SHEEN_CAMERA_KALIBR, path, &err), err, SHEEN_EUNSUP,
                 "cannot hold a lens of 8 coefficients: calibrate with --model opencv4");
    snprintf(camera.lensmodel, sizeof camera.lensmodel, "LENSMODEL_CAHVOR");
    assert_fails(sheen_camera_export(&camera, SHEEN_CAMERA_OPENCV, path, &err), err, SHEEN_EUNSUP,
                 "cannot hold a lens of the model LENSMODEL_CAHVOR");
}

static void endings_name_formats(void **state)
{
    (void)state;
    sheen_err err;
    sheen_camera_format format;
    assert_ok(sheen_camera_format_of(&format, "a/b.Kalibr.YAML", &err), err);
    assert_int_equal(format, SHEEN_CAMERA_KALIBR);
    assert_fails(sheen_camera_format_of(&format, "b.yaml", &err), err, SHEEN_EARG,
                 "'b.yaml' is no kind of camera");
    assert_int_equal(sheen_camera_format_of(&format, ".ros.yaml", &err), SHEEN_EARG);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(opencv_and_ros_files_come_back, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(colmap_counts_from_the_corner, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(kalibr_holds_four_coefficients, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test(endings_name_formats),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

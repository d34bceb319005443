// SPDX-License-Identifier: Apache-2.0
// The camera's file: our reader takes it with all that it carries, and mrcal's Python (where it is installed) finds
// the same residuals and the same uncertainty in it.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "calib/calibrate_session.h"
#include "calib/npz.h"
#include "support.h"
#include "support_board.h"
#include "synthetic_views.h"

enum { N = 12 };

static void calibrate(sheen_calibration *c, const char *model)
{
    sheen_err err;
    sheen_board board;
    sheen_camera truth;
    sheen_board_view views[N];
    uint64_t seed = 4;
    const double k[8] = {-0.28, 0.11, 0.0009, -0.0005, 0.02, 0.03, -0.02, 0.005};
    assert_ok(sheen_camera_opencv(&truth, 1024, 768, (const double[4]){930, 926, 521, 377}, k, 8, &err), err);
    test_board_make(&board, 10, 8, 0.027, 0.7, 0, 0);
    for (int i = 0; i < N; i++) {
        double rt_cam_board[6];
        char name[16];
        snprintf(name, sizeof name, "f%02d", i);
        test_calibration_pose(rt_cam_board, i, 0.36);
        test_view_make(&views[i], name, &board, &truth, rt_cam_board, 0.1, (const double[2]){4e-4, -2e-4},
                       &seed);
    }
    views[4].saddles[7].q_px[0] += 9; // an outlier
    const sheen_calibrate_options options = {.lensmodel = model};
    assert_ok(sheen_calibrate(c, &board, views, N, &options, &err), err);
    assert_in_range(c->n_outliers, 1, 4);
    for (int i = 0; i < N; i++)
        sheen_board_view_release(&views[i]);
    sheen_board_release(&board);
}

static void reads_back_with_all_that_it_carries(void **state)
{
    static const char *const models[] = {"opencv8", "splined"};
    for (size_t m = 0; m < 2; m++) {
        sheen_err err;
        sheen_calibration c;
        sheen_camera camera;
        char path[TEST_PATH_MAX];
        test_scratch_file(path, *state, "camera.cameramodel");
        calibrate(&c, models[m]);
        assert_ok(sheen_calibration_save_camera(&c, path, &err), err);
        assert_ok(sheen_camera_load(&camera, path, &err), err);
        assert_string_equal(camera.lensmodel, c.camera.lensmodel);
        for (int i = 0; i < camera.n_intrinsics; i++)
            assert_close(camera.intrinsics[i], c.camera.intrinsics[i], 0);
        sheen_calibration_release(&c);
    }
}

static void mrcal_finds_the_same_in_it(void **state)
{
    static const char *const models[] = {"opencv8", "splined"};
    if (system("/usr/bin/python3 -c 'import mrcal' >/dev/null 2>&1")) {
        test_skip("needs the package mrcal");
    }
    for (size_t m = 0; m < 2; m++) {
        sheen_err err;
        sheen_calibration c;
        char path[TEST_PATH_MAX], command[2 * TEST_PATH_MAX + 800];
        double rms_px = 0, sigma_px = 0;
        int n = 0;
        test_scratch_file(path, *state, "camera.cameramodel");
        calibrate(&c, models[m]);
        assert_ok(sheen_calibration_save_camera(&c, path, &err), err);
        snprintf(command, sizeof command,
                 "/usr/bin/python3 -c \"\n"
                 "import mrcal, numpy as np\n"
                 "m = mrcal.cameramodel('%s')\n"
                 "o = m.optimization_inputs()\n"
                 "x = mrcal.optimizer_callback(**o)[1][:mrcal.num_measurements_boards(**o)].reshape(-1, 2)\n"
                 "seen = o['observations_board'][..., 2].ravel() > 0\n"
                 "v = mrcal.unproject(np.array(((511.5, 383.5),)), *m.intrinsics(), normalize=True) * %.17g\n"
                 "u = mrcal.projection_uncertainty(v, m, what='worstdirection-stdev')[0]\n"
                 "print(seen.sum(), np.sqrt((x[seen] ** 2).mean()), u)\" 2>/dev/null",
                 path, c.distance_m);
        FILE *answer = popen(command, "r");
        assert_non_null(answer);
        assert_int_equal(fscanf(answer, "%d %lf %lf", &n, &rms_px, &sigma_px), 3);
        assert_int_equal(pclose(answer), 0);
        assert_int_equal(n, c.n_corners - c.n_outliers);
        assert_close(rms_px, c.rms_px, 1e-6);
        // mrcal takes the rms for the noise of a corner; we count parameters off
        assert_close(sigma_px / c.rms_px / (c.sigma_centre_px / c.noise_px), 1, 0.1);
        sheen_calibration_release(&c);
    }
}

static void an_archive_is_what_zip_and_numpy_say(void **state)
{
    (void)state;
    sheen_npz z = {0};
    const double x[2] = {1, -2};
    sheen_npz_numbers(&z, "a", x, 1, (const size_t[]){2});
    sheen_npz_text(&z, "none", "");
    const sheen_bytes *file = sheen_npz_finish(&z);
    assert_non_null(file);
    assert_int_equal(memcmp(file->data, "PK\3\4", 4), 0);
    assert_int_equal(memcmp(file->data + 30, "a.npy\x93NUMPY\1\0", 13), 0);
    assert_int_equal((30 + 5 + 10 + (file->data[43] | file->data[44] << 8)) % 64, (30 + 5) % 64);
    assert_int_equal(memcmp(file->data + file->size_bytes - 22, "PK\5\6\0\0\0\0\2\0\2\0", 12), 0);
    sheen_npz_release(&z);

    char *text = sheen_base85((const uint8_t *)"sheen", 5); // as Python's base64.b85encode(b'sheen')
    assert_string_equal(text, "b7*B{ZU");
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_archive_is_what_zip_and_numpy_say),
        cmocka_unit_test_setup_teardown(reads_back_with_all_that_it_carries, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(mrcal_finds_the_same_in_it, test_scratch_setup,
                                        test_scratch_teardown),
    };
    return test_result(cmocka_run_group_tests(tests, NULL, NULL));
}

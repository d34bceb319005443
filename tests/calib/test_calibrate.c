// SPDX-License-Identifier: Apache-2.0
// Calibration from corners that are known: the camera comes back, outliers and bad frames do not spoil it, and
// what cannot be calibrated from is said.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/pose3.h"
#include "calib/calibrate_page.h"
#include "support.h"
#include "support_board.h"
#include "synthetic_views.h"

enum { MAX_VIEWS = 48 };

typedef struct fixture {
    sheen_board board;
    sheen_camera truth;
    int n;
    sheen_board_view views[MAX_VIEWS];
    double rt_cam_board[MAX_VIEWS][6];
} fixture;

static void make(fixture *f, int n, double sigma_px, const double warp_m[2])
{
    sheen_err err;
    uint64_t seed = 21;
    const double k[8] = {-0.28, 0.11, 0.0009, -0.0005, 0.02, 0.03, -0.02, 0.005};
    assert_ok(sheen_camera_opencv(&f->truth, 1024, 768, (const double[4]){930, 926, 521, 377}, k, 8, &err),
              err);
    test_board_make(&f->board, 10, 8, 0.027, 0.7, 0, 0);
    f->n = n;
    for (int i = 0; i < n; i++) {
        char name[16];
        snprintf(name, sizeof name, "f%02d", i);
        test_calibration_pose(f->rt_cam_board[i], i, 0.36);
        test_view_make(&f->views[i], name, &f->board, &f->truth, f->rt_cam_board[i], sigma_px, warp_m, &seed);
    }
}

static void release(fixture *f)
{
    for (int i = 0; i < f->n; i++)
        sheen_board_view_release(&f->views[i]);
    sheen_board_release(&f->board);
}

static const double flat[2] = {0, 0};
static const sheen_calibrate_options usual = {0};

static void recovers_a_known_camera(void **state)
{
    (void)state;
    sheen_err err;
    fixture f;
    sheen_calibration c;
    sheen_camera_difference d;
    make(&f, 20, 0.05, flat);
    assert_ok(sheen_calibrate(&c, &f.board, f.views, 20, &usual, &err), err);
    assert_string_equal(c.camera.lensmodel, "LENSMODEL_OPENCV8");
    assert_int_equal(c.camera.width_px, 1024);
    assert_int_equal(c.n_used, 20);
    assert_close(c.rms_px, 0.05, 0.004);
    assert_in_range(c.n_outliers, 0, 3);
    assert_ok(sheen_camera_compare(&d, &c.camera, &f.truth, 0.36, &err), err);
    assert_close(d.turned_rms_px, 0, 0.1);
    assert_close(d.moved_rms_px, 0, 0.03);
    assert_close(d.moved_max_px, 0, 0.3);
    for (int i = 0; i < 20; i++) {
        assert_true(c.frames[i].used);
        assert_close(1e3 * fabs(c.frames[i].rt_cam_board[5] - f.rt_cam_board[i][5]), 0, 0.2);
        assert_close(sheen_rt_angle_rad(c.frames[i].rt_cam_board, f.rt_cam_board[i]), 0, 0.002);
    }
    assert_close(c.warp_m[0], 0, 2e-5);
    assert_close(c.warp_m[1], 0, 2e-5);
    assert_true(c.good);
    assert_non_null(strstr(c.verdict, "good"));
    assert_true(c.coverage > 0.8 && c.tilt_rad > 0.8);
    assert_close(c.distance_m, 0.36, 0.05);
    // the halves differ by about twice the error of the whole, and sigma says how large that is
    assert_true(c.has_halves);
    assert_in_range((int)(1e4 * c.halves.moved_rms_px), 10, 2000);
    assert_in_range((int)(1e4 * c.sigma_centre_px), 10, 300);
    assert_true(c.sigma_worst_px > c.sigma_centre_px && c.sigma_worst_px < 0.2);
    sheen_calibration_release(&c);
    release(&f);
}

// The same noise drawn again and again: the projections scatter as sigma says.
static void sigma_is_what_repeated_calibrations_scatter(void **state)
{
    (void)state;
    enum { REPEATS = 30 };
    sheen_err err;
    fixture f;
    double moved = 0, sigma = 0;
    uint64_t seed = 77;
    make(&f, 12, 0, flat);
    for (int r = 0; r < REPEATS; r++) {
        sheen_board_view noisy[12];
        sheen_calibration c;
        sheen_camera_difference d;
        for (int i = 0; i < 12; i++)
            test_view_make(&noisy[i], f.views[i].name, &f.board, &f.truth, f.rt_cam_board[i], 0.1, flat,
                           &seed);
        assert_ok(sheen_calibrate(&c, &f.board, noisy, 12, &usual, &err), err);
        assert_ok(sheen_camera_compare(&d, &c.camera, &f.truth, c.distance_m, &err), err);
        moved += d.moved_rms_px * d.moved_rms_px / REPEATS;
        sigma += c.sigma_centre_px / REPEATS;
        sheen_calibration_release(&c);
        for (int i = 0; i < 12; i++)
            sheen_board_view_release(&noisy[i]);
    }
    // rms over the whole image is larger than sigma at its centre, but of its order
    assert_in_range((int)(100 * sqrt(moved) / sigma), 80, 600);
    release(&f);
}

static void finds_a_bent_board(void **state)
{
    (void)state;
    sheen_err err;
    fixture f;
    sheen_calibration c;
    sheen_camera_difference d;
    make(&f, 20, 0.05, (const double[2]){0.0008, -0.0005});
    assert_ok(sheen_calibrate(&c, &f.board, f.views, 20, &usual, &err), err);
    assert_close(c.warp_m[0], 0.0008, 3e-5); // towards the viewer along x
    assert_close(c.warp_m[1], -0.0005, 3e-5);
    assert_ok(sheen_camera_compare(&d, &c.camera, &f.truth, 0.36, &err), err);
    assert_close(d.moved_rms_px, 0, 0.05);
    sheen_calibration_release(&c);
    release(&f);
}

static void outliers_and_missing_corners_do_no_harm(void **state)
{
    (void)state;
    sheen_err err;
    fixture f;
    sheen_calibration c;
    sheen_camera_difference d;
    uint64_t seed = 4;
    make(&f, 15, 0.1, flat);
    for (int i = 0; i < f.n; i++) {
        sheen_board_view *v = &f.views[i];
        for (int k = 0; k < 3; k++) {
            sheen_saddle *s = &v->saddles[(size_t)(test_random(&seed) * (double)v->n_saddles)];
            s->q_px[0] += 8 * test_random_normal(&seed);
            s->q_px[1] += 8 * test_random_normal(&seed);
        }
        size_t kept = 0; // every fifth corner was not seen
        for (size_t k = 0; k < v->n_saddles; k++)
            if ((k + (size_t)i) % 5)
                v->saddles[kept++] = v->saddles[k];
        v->n_saddles = kept;
    }
    assert_ok(sheen_calibrate(&c, &f.board, f.views, (size_t)f.n, &usual, &err), err);
    assert_in_range(c.n_outliers, 25, 46);
    assert_close(c.rms_px, 0.1, 0.01); // of what was left: missing corners do not make it smaller
    assert_ok(sheen_camera_compare(&d, &c.camera, &f.truth, 0.36, &err), err);
    assert_close(d.moved_rms_px, 0, 0.1);
    sheen_calibration_release(&c);
    release(&f);
}

// Of many frames a few are solved first. The result does not depend on them: here each fourth frame is face on and
// like the others of these, and one of them is another board's.
static void the_few_to_begin_with_do_not_matter(void **state)
{
    (void)state;
    enum { N = 48 };
    sheen_err err;
    fixture f;
    sheen_calibration c[2];
    sheen_camera_difference d;
    uint64_t seed = 5;
    make(&f, N, 0.05, flat);
    for (int i = 0; i < N; i += 4) {
        double rt[6];
        test_board_look(rt, (const double[2]){0.01, 0}, 0.36, 0.5, 10.0 * i, 0);
        sheen_board_view_release(&f.views[i]);
        test_view_make(&f.views[i], "face", &f.board, &f.truth, rt, 0.05, flat, &seed);
    }
    for (size_t k = 0; k < f.views[8].n_saddles; k++)
        f.views[8].saddles[k].q_px[0] += 40 * (test_random(&seed) - 0.5);
    assert_ok(sheen_calibrate(&c[0], &f.board, f.views, N, &usual, &err), err);
    const sheen_board_view first = f.views[0]; // the others become the few
    memmove(f.views, f.views + 1, (N - 1) * sizeof *f.views);
    f.views[N - 1] = first;
    assert_ok(sheen_calibrate(&c[1], &f.board, f.views, N, &usual, &err), err);
    assert_int_equal(c[0].n_used, N - 1);
    assert_int_equal(c[1].n_used, N - 1);
    assert_ok(sheen_camera_compare(&d, &c[0].camera, &f.truth, 0.36, &err), err);
    assert_close(d.moved_rms_px, 0, 0.03);
    assert_ok(sheen_camera_compare(&d, &c[0].camera, &c[1].camera, 0.36, &err), err);
    assert_close(d.raw_max_px, 0, 0.001);
    for (int i = 0; i < 2; i++)
        sheen_calibration_release(&c[i]);
    release(&f);
}

static void a_frame_that_does_not_fit_is_left_out(void **state)
{
    (void)state;
    sheen_err err;
    fixture f;
    sheen_calibration c;
    uint64_t seed = 5;
    make(&f, 14, 0.05, flat);
    for (size_t k = 0; k < f.views[6].n_saddles; k++) { // blurred by a shake
        f.views[6].saddles[k].q_px[0] += 6 * test_random_normal(&seed);
        f.views[6].saddles[k].q_px[1] += 6 * test_random_normal(&seed);
    }
    f.views[9].n_saddles = 5;
    sheen_board_view_release(&f.views[11]);
    f.views[11].width_px = 1024;
    f.views[11].height_px = 768;
    assert_ok(sheen_calibrate(&c, &f.board, f.views, 14, &usual, &err), err);
    assert_int_equal(c.n_used, 11);
    assert_false(c.frames[6].used);
    assert_non_null(strstr(c.frames[6].reason, "does not fit the others"));
    assert_non_null(strstr(c.frames[9].reason, "only 5 corners in view"));
    assert_string_equal(c.frames[11].reason, "no tag of the board in view");
    assert_close(c.rms_px, 0.05, 0.006);
    assert_true(c.frames[c.i_worst].used);
    sheen_calibration_release(&c);
    release(&f);
}

static void every_model_works_and_others_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        int n;
        double moved_px;
    } models[] = {{"LENSMODEL_OPENCV4", 8, 0.6},
                  {"opencv5", 9, 0.6},
                  {"opencv8", 12, 0.06},
                  {"cahvor", 9, 2},
                  {"splined", 388, 1.5}};
    sheen_err err;
    fixture f;
    sheen_calibration c;
    sheen_camera_difference d;
    make(&f, 20, 0.05, flat);
    for (size_t i = 0; i < sizeof models / sizeof *models; i++) {
        const sheen_calibrate_options options = {.lensmodel = models[i].name};
        assert_ok(sheen_calibrate(&c, &f.board, f.views, 20, &options, &err), err);
        assert_int_equal(c.camera.n_intrinsics, models[i].n);
        assert_ok(sheen_camera_compare(&d, &c.camera, &f.truth, c.distance_m, &err), err);
        assert_close(d.moved_rms_px, 0, models[i].moved_px);
        sheen_calibration_release(&c);
    }
    const sheen_calibrate_options options = {.lensmodel = "LENSMODEL_FISHEYE"};
    assert_fails(
        sheen_calibrate(&c, &f.board, f.views, 10, &options, &err), err, SHEEN_EARG,
        "cannot calibrate the lens model 'LENSMODEL_FISHEYE': use opencv4, opencv5, opencv8, cahvor");
    release(&f);
}

// The fixture's lens has eight coefficients that count; with four of them zero, four do.
static void chooses_the_model_that_the_lens_needs(void **state)
{
    (void)state;
    const sheen_calibrate_options options = {.lensmodel = "auto"};
    sheen_err err;
    fixture f;
    sheen_calibration c;
    make(&f, 20, 0.05, flat);
    assert_ok(sheen_calibrate(&c, &f.board, f.views, 20, &options, &err), err);
    assert_string_equal(c.camera.lensmodel, "LENSMODEL_OPENCV8");
    assert_in_range(c.n_candidates, 4, 5);
    assert_string_equal(c.candidates[0].name, "opencv4");
    assert_true(c.candidates[0].held_out_px > c.candidates[3].held_out_px);
    assert_close(c.candidates[3].held_out_px, 0.05, 0.005);
    sheen_calibration_release(&c);

    uint64_t seed = 5;
    f.truth.n_intrinsics = 8;
    snprintf(f.truth.lensmodel, sizeof f.truth.lensmodel, "LENSMODEL_OPENCV4");
    for (int i = 0; i < f.n; i++) {
        sheen_board_view_release(&f.views[i]);
        test_view_make(&f.views[i], "frame", &f.board, &f.truth, f.rt_cam_board[i], 0.05, flat, &seed);
    }
    assert_ok(sheen_calibrate(&c, &f.board, f.views, 20, &options, &err), err);
    assert_string_equal(c.camera.lensmodel, "LENSMODEL_OPENCV4");
    sheen_calibration_release(&c);
    release(&f);
}

// Halves of the frames differ by what their uncertainty predicts: 1 in the root mean square of many calibrations.
static void halves_differ_as_predicted(void **state)
{
    (void)state;
    enum { REPEATS = 16 };
    sheen_err err;
    fixture f;
    double square = 0;
    uint64_t seed = 901;
    make(&f, 20, 0, flat);
    for (int r = 0; r < REPEATS; r++) {
        sheen_calibration c;
        for (int i = 0; i < f.n; i++) {
            sheen_board_view_release(&f.views[i]);
            test_view_make(&f.views[i], "frame", &f.board, &f.truth, f.rt_cam_board[i], 0.1, flat, &seed);
        }
        assert_ok(sheen_calibrate(&c, &f.board, f.views, (size_t)f.n, &usual, &err), err);
        assert_true(c.has_halves);
        assert_close(c.noise_px, 0.1, 0.006);
        square += c.normalised_error * c.normalised_error / REPEATS;
        sheen_calibration_release(&c);
    }
    assert_close(sqrt(square), 1, 0.2);
    release(&f);
}

static sheen_status no_picture(void *self, size_t i_frame, sheen_raster *out, sheen_err *err)
{
    int *n_asked = self;
    *out = (sheen_raster){0};
    ++*n_asked;
    return sheen_fail(err, SHEEN_EIO, "frame %zu has no picture", i_frame);
}

// The page is written even where no picture is to be had, and holds each figure's name and every frame.
static void the_report_is_a_page(void **state)
{
    sheen_err err;
    fixture f;
    sheen_calibration c;
    char path[TEST_PATH_MAX];
    uint8_t *data;
    size_t size_bytes;
    int n_asked = 0;
    const sheen_frame_pictures pictures = {.read = no_picture, .self = &n_asked};
    test_scratch_file(path, *state, "report.html");
    make(&f, 12, 0.05, flat);
    f.views[3].n_saddles = 2;
    assert_ok(sheen_calibrate(&c, &f.board, f.views, 12, &usual, &err), err);
    assert_ok(sheen_calibration_page(&c, &pictures, "A <camera>", path, &err), err);
    assert_int_equal(n_asked, 3);
    assert_ok(sheen_file_read(&data, &size_bytes, path, 1 << 22, &err), err);
    data[size_bytes - 1] = 0;
    static const char *const words[] = {
        "A &lt;camera&gt;",       "usable with care",
        "Where the corners are",  "How certain a projection is",
        "direction of residuals", "Cross-validation",
        "The worst frames",       "<td>f03</td><td>2</td><td></td><td></td><td></td><td>not used: only 2"};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (!strstr((const char *)data, words[i]) && !(i == 1 && c.good))
            fail_msg("the report lacks '%s'", words[i]);
    free(data);
    sheen_calibration_release(&c);
    release(&f);
}

static void says_what_it_cannot_calibrate_from(void **state)
{
    (void)state;
    sheen_err err;
    fixture f;
    sheen_calibration c;
    make(&f, 8, 0.05, flat);
    assert_fails(sheen_calibrate(&c, &f.board, f.views, 0, &usual, &err), err, SHEEN_EDATA, "no frames");
    assert_fails(sheen_calibrate(&c, &f.board, f.views, 1, &usual, &err), err, SHEEN_EDATA,
                 "1 frames are too few");
    assert_fails(sheen_calibrate(&c, &f.board, f.views, 4, &usual, &err), err, SHEEN_EDATA, "at least 5");
    f.views[2].n_saddles = 3;
    assert_fails(sheen_calibrate(&c, &f.board, f.views, 5, &usual, &err), err, SHEEN_EDATA,
                 "4 of 5 frames can be used, at least 5 are needed ('f02': only 3 corners");
    size_t kept = 0;
    for (size_t k = 0; k < f.views[3].n_saddles; k++)
        if (f.views[3].saddles[k].row <= 2)
            f.views[3].saddles[kept++] = f.views[3].saddles[k];
    f.views[3].n_saddles = kept;
    f.views[2].n_saddles = 40;
    assert_fails(sheen_calibrate(&c, &f.board, f.views, 5, &usual, &err), err, SHEEN_EDATA, "lie in a strip");
    f.views[1].saddles[4].q_px[0] = (double)NAN;
    assert_fails(sheen_calibrate(&c, &f.board, f.views, 8, &usual, &err), err, SHEEN_EDATA,
                 "a corner in frame 'f01' is not a finite number");
    f.views[1].saddles[4].q_px[0] = 100;
    f.views[1].saddles[4].row = 8;
    assert_fails(sheen_calibrate(&c, &f.board, f.views, 8, &usual, &err), err, SHEEN_EARG,
                 "not on the board");
    f.views[1].saddles[4].row = 1;
    f.views[7].width_px = 640;
    assert_fails(sheen_calibrate(&c, &f.board, f.views, 8, &usual, &err), err, SHEEN_EDATA,
                 "frames of one size");
    release(&f);
}

// Five frames that all see the board face on do not determine a focal length, and the verdict says what to do.
static void face_on_frames_are_not_called_good(void **state)
{
    (void)state;
    sheen_err err;
    fixture f;
    sheen_calibration c;
    uint64_t seed = 1;
    make(&f, 12, 0.05, flat);
    for (int i = 0; i < 12; i++) {
        double rt[6];
        test_board_look(rt, (const double[2]){0.02 * (i % 3 - 1), 0.01 * (i % 4 - 1.5)}, 0.4, 0.5, 30 * i,
                        30 * i);
        sheen_board_view_release(&f.views[i]);
        test_view_make(&f.views[i], "x", &f.board, &f.truth, rt, 0.05, flat, &seed);
    }
    const sheen_status s = sheen_calibrate(&c, &f.board, f.views, 12, &usual, &err);
    if (s) {
        assert_int_equal(s, SHEEN_EDATA);
    } else {
        assert_false(c.good);
        assert_non_null(strstr(c.verdict, "tilt the board more"));
        sheen_calibration_release(&c);
    }
    release(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(recovers_a_known_camera),
        cmocka_unit_test(sigma_is_what_repeated_calibrations_scatter),
        cmocka_unit_test(finds_a_bent_board),
        cmocka_unit_test(outliers_and_missing_corners_do_no_harm),
        cmocka_unit_test(the_few_to_begin_with_do_not_matter),
        cmocka_unit_test(a_frame_that_does_not_fit_is_left_out),
        cmocka_unit_test(every_model_works_and_others_are_refused),
        cmocka_unit_test(chooses_the_model_that_the_lens_needs),
        cmocka_unit_test(halves_differ_as_predicted),
        cmocka_unit_test_setup_teardown(the_report_is_a_page, test_scratch_setup, test_scratch_teardown),
        cmocka_unit_test(says_what_it_cannot_calibrate_from),
        cmocka_unit_test(face_on_frames_are_not_called_good),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

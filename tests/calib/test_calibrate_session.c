// SPDX-License-Identifier: Apache-2.0
// The calibration stage on rendered photographs: a session's files, image files, threads, cancelling, faults; and
// the sample session that comes with the repository, against its truth.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/image_file.h"
#include "calib/calibrate_session.h"
#include "calib/vnl.h"
#include "support.h"
#include "support_board.h"
#include "synthetic_views.h"

enum { N_PHOTOS = 12, WIDTH = 480, HEIGHT = 360 };

typedef struct fixture {
    sheen_board board;
    sheen_camera truth;
    uint8_t *photos[N_PHOTOS];
    test_scratch scratch;
} fixture;

static int setup(void **state)
{
    sheen_err err;
    fixture *f = calloc(1, sizeof *f);
    assert_non_null(f);
    *state = f;
    test_scratch_make(&f->scratch);
    const double k[5] = {-0.18, 0.07, 0.0006, -0.0009, 0.01};
    assert_ok(
        sheen_camera_opencv(&f->truth, WIDTH, HEIGHT, (const double[4]){455, 458, 243, 176}, k, 5, &err),
        err);
    test_board_make(&f->board, 8, 6, 0.033, 0.64, 10, 0);
    for (int i = 0; i < N_PHOTOS; i++) {
        test_photo photo = {.board = &f->board,
                            .camera = &f->truth,
                            .blur_px = 0.6,
                            .noise_dn = 1.5,
                            .gamma = 2.2,
                            .seed = (uint64_t)i};
        test_calibration_pose(photo.rt_cam_board, i, 0.36);
        f->photos[i] = test_photo_render(&photo);
    }
    return 0;
}

static int teardown(void **state)
{
    fixture *f = *state;
    for (int i = 0; i < N_PHOTOS; i++)
        free(f->photos[i]);
    sheen_board_release(&f->board);
    test_scratch_remove(&f->scratch);
    free(f);
    return 0;
}

static void write_photo(const fixture *f, int i, const char *path)
{
    sheen_err err;
    const sheen_raster raster = {
        .data = f->photos[i], .width_px = WIDTH, .height_px = HEIGHT, .n_channels = 1, .bits = 8};
    assert_ok(sheen_png_write(path, &raster, &err), err);
}

// A session of n photos of one role, with the board under the given file name.
static void session_make(sheen_session *s, const fixture *f, const char *name, int n, sheen_role role,
                         const char *board_file)
{
    char folder[TEST_PATH_MAX], path[SHEEN_PATH_MAX];
    sheen_err err;
    test_scratch_file(folder, &f->scratch, name);
    assert_ok(sheen_session_create(s, folder, SHEEN_MOVING_CAMERA, &err), err);
    for (int i = 0; i < n; i++) {
        char png[TEST_PATH_MAX];
        size_t size_bytes;
        sheen_frame_info info;
        test_scratch_file(png, &f->scratch, "photo.png");
        write_photo(f, i, png);
        uint8_t *payload = test_file_read(png, &size_bytes);
        sheen_frame_info_init(&info);
        snprintf(info.name, sizeof info.name, "%s%02d", sheen_role_name(role), i);
        info.role = role;
        info.width_px = WIDTH;
        info.height_px = HEIGHT;
        info.transfer = SHEEN_TRANSFER_SRGB;
        assert_ok(sheen_session_add_frame(s, &info, "png", payload, size_bytes, &err), err);
        free(payload);
    }
    if (board_file) {
        assert_ok(sheen_session_path(path, s, board_file, &err), err);
        test_board_save(&f->board, path);
    }
}

static void check_camera(const sheen_camera *camera, const sheen_camera *truth)
{
    sheen_err err;
    sheen_camera_difference d;
    assert_ok(sheen_camera_compare(&d, camera, truth, 0.36, &err), err);
    assert_close(d.raw_max_px, 0, 2);
    assert_close(d.moved_rms_px, 0, 0.06);
}

static void writes_what_it_found(void **state)
{
    const fixture *f = *state;
    char path[SHEEN_PATH_MAX];
    sheen_err err;
    sheen_session s;
    sheen_calibration c;
    sheen_camera camera;
    sheen_vnl vnl;
    sheen_json *root;
    session_make(&s, f, "a", N_PHOTOS, SHEEN_ROLE_CALIBRATION, SHEEN_SESSION_CALIBRATION_BOARD);
    assert_false(sheen_calibration_is_current(&s));
    assert_ok(sheen_calibrate_session(&c, &s, &(sheen_calibrate_options){.n_threads = 1}, &err), err);
    check_camera(&c.camera, &f->truth);
    assert_true(c.rms_px < 0.08);

    assert_ok(sheen_session_path(path, &s, SHEEN_SESSION_CAMERA, &err), err);
    assert_ok(sheen_camera_load(&camera, path, &err), err);
    assert_memory_equal(camera.intrinsics, c.camera.intrinsics, 12 * sizeof(double));
    assert_ok(sheen_session_path(path, &s, "detections/calibration.vnl", &err), err);
    assert_ok(sheen_vnl_load(&vnl, path, 7, 5, &err), err);
    assert_int_equal(vnl.n_frames, N_PHOTOS);
    assert_string_equal(vnl.frames[0].file, "../frames/calibration00.png");
    int n_corners = 0;
    for (size_t i = 0; i < vnl.n_frames; i++)
        n_corners += (int)vnl.frames[i].n_found;
    assert_int_equal(n_corners, c.n_corners);
    sheen_vnl_release(&vnl);

    double rms_px;
    bool good;
    assert_ok(sheen_session_path(path, &s, SHEEN_SESSION_CALIBRATION, &err), err);
    assert_ok(sheen_json_load(&root, path, &err), err);
    assert_ok(sheen_json_schema(root, "sheen-calibration", 1, &(int){0}, &err), err);
    assert_ok(sheen_json_number(root, "rms_px", &rms_px, &err), err);
    assert_ok(sheen_json_bool(root, "good", &good, &err), err);
    assert_close(rms_px, c.rms_px, 0);
    assert_int_equal(good, c.good);
    assert_int_equal(sheen_json_count(sheen_json_get(root, "frames")), N_PHOTOS);
    sheen_json_free(&root);

    assert_true(sheen_calibration_is_current(&s));
    assert_ok(sheen_session_path(path, &s, SHEEN_SESSION_CALIBRATION_BOARD, &err), err);
    sheen_board other;
    test_board_make(&other, 8, 6, 0.034, 0.64, 10, 0);
    test_board_save(&other, path);
    sheen_board_release(&other);
    assert_false(sheen_calibration_is_current(&s));
    sheen_calibration_release(&c);
    sheen_session_release(&s);
}

static bool count_steps(void *self, const char *what, int done, int total)
{
    int *n = self;
    assert_true(what && done >= 0 && done <= total);
    return ++*n < 3;
}

static void threads_and_files_make_no_difference(void **state)
{
    const fixture *f = *state;
    sheen_err err;
    sheen_calibration c[3];
    char paths[N_PHOTOS][TEST_PATH_MAX], board[TEST_PATH_MAX];
    const char *list[N_PHOTOS];
    for (int i = 0; i < N_PHOTOS; i++) {
        char name[32];
        snprintf(name, sizeof name, "my photo #%02d.png", i);
        test_scratch_file(paths[i], &f->scratch, name);
        write_photo(f, i, paths[i]);
        list[i] = paths[i];
    }
    test_scratch_file(board, &f->scratch, "board.json");
    test_board_save(&f->board, board);
    for (int i = 0; i < 3; i++) {
        const sheen_calibrate_options options = {.n_threads = i + 1};
        assert_ok(sheen_calibrate_files(&c[i], list, N_PHOTOS, board, &options, &err), err);
        assert_memory_equal(c[i].camera.intrinsics, c[0].camera.intrinsics, 12 * sizeof(double));
    }
    check_camera(&c[0].camera, &f->truth);
    assert_string_equal(c[0].frames[3].name, "my_photo__03");
    for (int i = 0; i < 3; i++)
        sheen_calibration_release(&c[i]);

    int n_steps = 0;
    const sheen_calibrate_options cancelled = {.n_threads = 1,
                                               .progress = {.step = count_steps, .self = &n_steps}};
    assert_int_equal(sheen_calibrate_files(&c[0], list, N_PHOTOS, board, &cancelled, &err), SHEEN_ECANCEL);
    assert_int_equal(n_steps, 3);
    test_file_write_text(paths[5], "no picture");
    assert_fails(sheen_calibrate_files(&c[0], list, N_PHOTOS, board, &(sheen_calibrate_options){0}, &err),
                 err, SHEEN_EFORMAT, "my photo #05.png");
}

static void input_frames_do_where_there_are_no_others(void **state)
{
    const fixture *f = *state;
    sheen_err err;
    sheen_session s;
    sheen_calibration c;
    session_make(&s, f, "b", N_PHOTOS, SHEEN_ROLE_INPUT, SHEEN_SESSION_BOARD);
    assert_ok(sheen_calibrate_session(&c, &s, &(sheen_calibrate_options){0}, &err), err);
    check_camera(&c.camera, &f->truth);
    sheen_calibration_release(&c);
    sheen_session_release(&s);
}

static void faults_are_said_and_leave_the_session_alone(void **state)
{
    const fixture *f = *state;
    char path[SHEEN_PATH_MAX];
    sheen_err err;
    sheen_session s;
    sheen_calibration c;
    const sheen_calibrate_options usual = {0};
    session_make(&s, f, "c", 4, SHEEN_ROLE_CALIBRATION, NULL);
    assert_fails(sheen_calibrate_session(&c, &s, &usual, &err), err, SHEEN_EDATA, "has no 'board.json'");
    assert_ok(sheen_session_path(path, &s, SHEEN_SESSION_BOARD, &err), err);
    test_board_save(&f->board, path);
    assert_fails(sheen_calibrate_session(&c, &s, &usual, &err), err, SHEEN_EDATA, "4 frames are too few");

    sheen_board other; // not the board in view
    test_board_make(&other, 8, 6, 0.033, 0.64, 400, 0);
    test_board_save(&other, path);
    sheen_board_release(&other);
    assert_fails(sheen_calibrate_session(&c, &s, &usual, &err), err, SHEEN_EDATA,
                 "('calibration00': no tag of the board in view)");
    test_file_write_text(path, "{}");
    assert_fails(sheen_calibrate_session(&c, &s, &usual, &err), err, SHEEN_EFORMAT, "board.json");
    assert_false(sheen_session_has(&s, SHEEN_SESSION_CAMERA));
    assert_false(sheen_session_has(&s, SHEEN_SESSION_CALIBRATION));
    assert_false(sheen_session_has(&s, SHEEN_SESSION_DETECTIONS));
    sheen_session_release(&s);

    session_make(&s, f, "d", 0, SHEEN_ROLE_INPUT, SHEEN_SESSION_BOARD);
    assert_fails(sheen_calibrate_session(&c, &s, &usual, &err), err, SHEEN_EDATA,
                 "has no frames to calibrate from");
    sheen_session_release(&s);
}

// The sample: 16 photographs of the bare board, traced by another renderer, JPEG.
static void the_sample_is_within_three_tenths_of_a_pixel(void **state)
{
    (void)state;
    sheen_err err;
    sheen_calibration c;
    sheen_camera truth;
    sheen_camera_difference d;
    char paths[16][TEST_PATH_MAX];
    const char *list[16];
    for (int i = 0; i < 16; i++) {
        snprintf(paths[i], sizeof paths[i], SHEEN_TEST_DATA "/penguin/frames/cal%02d.jpg", i);
        list[i] = paths[i];
    }
    const double k[4] = {-0.12, 0.05, 0.0008, -0.0006};
    assert_ok(sheen_camera_opencv(&truth, 1280, 960, (const double[4]){1500, 1500, 648.2, 471.7}, k, 4, &err),
              err);
    assert_ok(sheen_calibrate_files(&c, list, 16, SHEEN_TEST_DATA "/penguin/calibration-board.json",
                                    &(sheen_calibrate_options){0}, &err),
              err);
    assert_int_equal(c.n_used, 16);
    assert_true(c.good);
    assert_ok(sheen_camera_compare(&d, &c.camera, &truth, c.distance_m, &err), err);
    print_message(
        "sample: rms %.3f px; from the truth %.3f px rms, %.3f px at most; turned %.3f, %.3f; moved %.3f, "
        "%.3f\n",
        c.rms_px, d.raw_rms_px, d.raw_max_px, d.turned_rms_px, d.turned_max_px, d.moved_rms_px,
        d.moved_max_px);
    assert_close(d.raw_max_px, 0, 0.3);
    assert_close(d.turned_max_px, 0, 0.15);
    assert_close(d.moved_max_px, 0, 0.05);
    sheen_calibration_release(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(writes_what_it_found),
        cmocka_unit_test(threads_and_files_make_no_difference),
        cmocka_unit_test(input_frames_do_where_there_are_no_others),
        cmocka_unit_test(faults_are_said_and_leave_the_session_alone),
        cmocka_unit_test(the_sample_is_within_three_tenths_of_a_pixel),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}

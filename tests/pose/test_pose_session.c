// SPDX-License-Identifier: Apache-2.0
// The pose stage: on rendered sessions with frames that show no board, with wrong cameras, imported poses; and on
// the sample session against its truth, with the true camera and with the calibrated one.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/image_file.h"
#include "base/json.h"
#include "base/pose3.h"
#include "calib/calibrate_session.h"
#include "calib/vnl.h"
#include "pose/pose_session.h"
#include "support.h"
#include "support_board.h"

enum { WIDTH = 480, HEIGHT = 360, N_FRAMES = 4 };

typedef struct fixture {
    sheen_board board;
    sheen_camera camera;
    double rt[N_FRAMES][6];
} fixture;

static void fixture_make(fixture *f)
{
    sheen_err err;
    const double k[4] = {-0.15, 0.05, 0.0006, -0.0009};
    assert_ok(
        sheen_camera_opencv(&f->camera, WIDTH, HEIGHT, (const double[4]){470, 473, 243, 176}, k, 4, &err),
        err);
    test_board_make(&f->board, 8, 6, 0.033, 0.64, 0, 0.03);
    for (int i = 0; i < N_FRAMES; i++)
        test_board_look(f->rt[i], (const double[2]){0.01 * i, 0}, 0.36, 10 + 12 * i, 80 * i, 40 * i);
}

static void add_frame(sheen_session *s, const char *name, sheen_role role, uint8_t *grey,
                      const test_scratch *scratch)
{
    char path[TEST_PATH_MAX];
    size_t size_bytes;
    sheen_err err;
    sheen_frame_info info;
    const sheen_raster raster = {
        .data = grey, .width_px = WIDTH, .height_px = HEIGHT, .n_channels = 1, .bits = 8};
    test_scratch_file(path, scratch, "photo.png");
    assert_ok(sheen_png_write(path, &raster, &err), err);
    uint8_t *payload = test_file_read(path, &size_bytes);
    sheen_frame_info_init(&info);
    snprintf(info.name, sizeof info.name, "%s", name);
    info.role = role;
    info.width_px = WIDTH;
    info.height_px = HEIGHT;
    info.transfer = SHEEN_TRANSFER_SRGB;
    assert_ok(sheen_session_add_frame(s, &info, "png", payload, size_bytes, &err), err);
    free(payload);
}

static void session_make(sheen_session *s, fixture *f, const test_scratch *scratch, const char *name)
{
    char folder[TEST_PATH_MAX], path[SHEEN_PATH_MAX];
    sheen_err err;
    fixture_make(f);
    test_scratch_file(folder, scratch, name);
    assert_ok(sheen_session_create(s, folder, SHEEN_MOVING_CAMERA, &err), err);
    for (int i = 0; i < N_FRAMES; i++) {
        char frame[16];
        test_photo photo = {
            .board = &f->board, .camera = &f->camera, .blur_px = 0.6, .noise_dn = 1.5, .gamma = 2.2};
        memcpy(photo.rt_cam_board, f->rt[i], sizeof photo.rt_cam_board);
        uint8_t *grey = test_photo_render(&photo);
        snprintf(frame, sizeof frame, "f%d", i);
        add_frame(s, frame, i == 2 ? SHEEN_ROLE_TEST : SHEEN_ROLE_INPUT, grey, scratch);
        free(grey);
    }
    assert_ok(sheen_session_path(path, s, SHEEN_SESSION_BOARD, &err), err);
    test_board_save(&f->board, path);
    assert_ok(sheen_session_path(path, s, SHEEN_SESSION_CAMERA, &err), err);
    assert_ok(sheen_camera_save(&f->camera, path, &err), err);
}

static void every_frame_gets_a_pose_or_a_reason(void **state)
{
    const test_scratch *scratch = *state;
    char path[SHEEN_PATH_MAX];
    sheen_err err;
    sheen_session s;
    fixture f;
    sheen_pose_summary summary;
    sheen_poses poses, again;
    sheen_vnl vnl;
    session_make(&s, &f, scratch, "a");
    uint8_t *empty = malloc((size_t)WIDTH * HEIGHT);
    memset(empty, 120, (size_t)WIDTH * HEIGHT);
    add_frame(&s, "g_empty", SHEEN_ROLE_INPUT, empty, scratch);
    add_frame(&s, "h_calibration", SHEEN_ROLE_CALIBRATION, empty, scratch);
    free(empty);
    assert_ok(sheen_pose_session(&summary, NULL, &s, &(sheen_pose_options){.n_threads = 1}, &err), err);
    assert_int_equal(summary.n_frames, N_FRAMES + 1);
    assert_int_equal(summary.n_found, N_FRAMES);
    assert_int_equal(summary.n_from_tags, 0);
    assert_true(summary.rms_median_px < 0.1 && summary.sigma_worst_m < 2e-4);
    assert_ok(sheen_poses_load(&poses, &s, &err), err);
    assert_int_equal(poses.n_poses, N_FRAMES + 1);
    assert_false(poses.imported);
    for (int i = 0; i < N_FRAMES; i++) {
        const sheen_frame_pose *p = &poses.poses[i];
        assert_true(p->found);
        assert_close(sheen_rt_angle_rad(p->rt_cam_board, f.rt[i]), 0, 2e-3);
        for (int k = 3; k < 6; k++)
            assert_close(p->rt_cam_board[k], f.rt[i][k], 2e-4);
        assert_true(p->n_points > 10 && p->covariance[21] > 0);
    }
    assert_false(poses.poses[N_FRAMES].found);
    assert_string_equal(poses.poses[N_FRAMES].reason, "no tag of the board in view");
    assert_ok(sheen_session_path(path, &s, "detections/board.vnl", &err), err);
    assert_ok(sheen_vnl_load(&vnl, path, 7, 5, &err), err);
    assert_int_equal(vnl.n_frames, N_FRAMES + 1);
    assert_int_equal(vnl.frames[N_FRAMES].n_found, 0);
    sheen_vnl_release(&vnl);

    // again, on two threads: the same numbers
    assert_ok(sheen_pose_session(&summary, &again, &s, &(sheen_pose_options){.n_threads = 2}, &err), err);
    for (int i = 0; i < N_FRAMES; i++)
        for (int k = 0; k < 6; k++)
            assert_close(again.poses[i].rt_cam_board[k], poses.poses[i].rt_cam_board[k], 0);
    sheen_poses_release(&again);
    sheen_poses_release(&poses);
    sheen_board_release(&f.board);
    sheen_session_release(&s);
}

// Two boards side by side in every picture; in the last frame the second one was moved.
static void boards_are_surveyed_together(void **state)
{
    const test_scratch *scratch = *state;
    char folder[TEST_PATH_MAX], path[SHEEN_PATH_MAX];
    sheen_err err;
    sheen_session s;
    sheen_board boards[2];
    sheen_camera camera;
    sheen_pose_summary summary;
    sheen_poses poses;
    double rt_ref_other[6] = {0, 0.25, 0.1, 0.2, 0, 0.02}, rt[N_FRAMES][6];
    assert_ok(
        sheen_camera_opencv(&camera, WIDTH, HEIGHT, (const double[4]){470, 473, 243, 176}, NULL, 0, &err),
        err);
    for (int b = 0; b < 2; b++)
        test_board_make(&boards[b], 6, 6, 0.028, 0.7, 20 * b, 0);
    snprintf(boards[0].name, sizeof boards[0].name, "front");
    snprintf(boards[1].name, sizeof boards[1].name, "side");
    test_scratch_file(folder, scratch, "set");
    assert_ok(sheen_session_create(&s, folder, SHEEN_MOVING_CAMERA, &err), err);
    for (int i = 0; i < N_FRAMES; i++) {
        uint8_t *grey[2];
        char frame[16];
        test_board_look(rt[i], (const double[2]){0.1, 0}, 0.42, 12 + 6 * i, 80 * i, 5 * i);
        for (int b = 0; b < 2; b++) {
            test_photo photo = {
                .board = &boards[b], .camera = &camera, .blur_px = 0.6, .noise_dn = 1, .gamma = 2.2};
            double rt_ref_board[6] = {0};
            if (b)
                memcpy(rt_ref_board, rt_ref_other, sizeof rt_ref_board);
            rt_ref_board[4] += b && i == N_FRAMES - 1 ? 0.01 : 0;
            sheen_rt_compose(photo.rt_cam_board, rt[i], rt_ref_board);
            grey[b] = test_photo_render(&photo);
        }
        const int ground = grey[0][0];
        for (int k = 0; k < WIDTH * HEIGHT; k++)
            if (abs(grey[1][k] - ground) > abs(grey[0][k] - ground))
                grey[0][k] = grey[1][k];
        snprintf(frame, sizeof frame, "f%d", i);
        add_frame(&s, frame, SHEEN_ROLE_INPUT, grey[0], scratch);
        free(grey[0]);
        free(grey[1]);
    }
    assert_ok(sheen_session_path(path, &s, SHEEN_SESSION_BOARD, &err), err);
    assert_ok(sheen_boards_save(boards, 2, path, &err), err);
    assert_ok(sheen_session_path(path, &s, SHEEN_SESSION_CAMERA, &err), err);
    assert_ok(sheen_camera_save(&camera, path, &err), err);
    assert_ok(sheen_pose_session(&summary, NULL, &s, &(sheen_pose_options){0}, &err), err);
    assert_ok(sheen_poses_load(&poses, &s, &err), err);
    assert_int_equal(summary.n_found, N_FRAMES);
    assert_int_equal((int)poses.n_boards, 2);
    assert_string_equal(poses.boards[1].name, "side");
    assert_true(poses.boards[1].found);
    assert_int_equal(poses.boards[1].n_moved, 1);
    assert_int_equal(poses.boards[1].n_frames, N_FRAMES - 1);
    for (int k = 0; k < 6; k++)
        assert_close(poses.boards[1].rt_ref_board[k], rt_ref_other[k], k < 3 ? 2e-3 : 3e-4);
    for (int i = 0; i < N_FRAMES; i++)
        assert_close(sheen_rt_angle_rad(poses.poses[i].rt_cam_board, rt[i]), 0, 2e-3);
    assert_true(sheen_session_has(&s, "detections/board-side.vnl"));
    sheen_poses_release(&poses);
    for (int b = 0; b < 2; b++)
        sheen_board_release(&boards[b]);
    sheen_session_release(&s);
}

// One frame in which the board turned while the shutter ran: its rows are from different moments.
static void a_rolling_frame_is_left_out(void **state)
{
    const test_scratch *scratch = *state;
    sheen_err err;
    sheen_session s;
    fixture f;
    sheen_pose_summary summary;
    sheen_poses poses;
    session_make(&s, &f, scratch, "rolling");
    test_photo photo = {
        .board = &f.board, .camera = &f.camera, .blur_px = 0.6, .noise_dn = 1.5, .gamma = 2.2};
    memcpy(photo.rt_cam_board, f.rt[0], sizeof photo.rt_cam_board);
    uint8_t *early = test_photo_render(&photo);
    uint8_t *rolled = malloc((size_t)WIDTH * HEIGHT);
    assert_non_null(rolled);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) { // swings to and fro by three pixels
            const int from = x + (int)lrint(3 * sin(0.06 * y));
            rolled[y * WIDTH + x] = early[y * WIDTH + (from < 0 ? 0 : from >= WIDTH ? WIDTH - 1 : from)];
        }
    add_frame(&s, "rolled", SHEEN_ROLE_INPUT, rolled, scratch);
    free(rolled);
    free(early);
    assert_ok(sheen_pose_session(&summary, &poses, &s, &(sheen_pose_options){0}, &err), err);
    assert_int_equal(summary.n_found, N_FRAMES);
    assert_false(summary.alike);
    assert_false(poses.poses[N_FRAMES].found);
    print_message("%s\n", poses.poses[N_FRAMES].reason);
    assert_true(poses.poses[N_FRAMES].reason[0]);
    sheen_poses_release(&poses);
    sheen_board_release(&f.board);
    sheen_session_release(&s);
}

static void imported_poses_are_left_alone(void **state)
{
    const test_scratch *scratch = *state;
    sheen_err err;
    sheen_session s;
    fixture f;
    sheen_pose_summary summary;
    sheen_poses poses;
    session_make(&s, &f, scratch, "b");
    sheen_frame_pose given = {
        .name = "f0", .found = true, .rt_cam_board = {0, 0, 0, 0, 0, 7}, .rms_px = (double)NAN};
    const sheen_poses imported = {.poses = &given, .n_poses = 1, .imported = true};
    assert_ok(sheen_poses_save(&imported, &s, &err), err);
    assert_ok(sheen_pose_session(&summary, &poses, &s, &(sheen_pose_options){0}, &err), err);
    assert_true(summary.left_alone);
    assert_int_equal(poses.n_poses, 1);
    assert_close(poses.poses[0].rt_cam_board[5], 7, 0);
    sheen_poses_release(&poses);
    assert_ok(sheen_pose_session(&summary, &poses, &s, &(sheen_pose_options){.force = true}, &err), err);
    assert_false(summary.left_alone);
    assert_false(poses.imported);
    assert_close(poses.poses[0].rt_cam_board[5], f.rt[0][5], 1e-3);
    sheen_poses_release(&poses);
    sheen_board_release(&f.board);
    sheen_session_release(&s);
}

static bool refuse(void *self, const char *what, int done, int total)
{
    (void)self, (void)what, (void)total;
    return done == 0;
}

static void faults_are_said_and_leave_the_session_alone(void **state)
{
    const test_scratch *scratch = *state;
    char path[SHEEN_PATH_MAX];
    sheen_err err;
    sheen_session s;
    fixture f;
    sheen_pose_summary summary;
    const sheen_pose_options usual = {0};
    session_make(&s, &f, scratch, "c");
    const sheen_pose_options cancelled = {.progress = {.step = refuse}, .n_threads = 1};
    assert_int_equal(sheen_pose_session(&summary, NULL, &s, &cancelled, &err), SHEEN_ECANCEL);

    assert_ok(sheen_session_path(path, &s, SHEEN_SESSION_CAMERA, &err), err);
    sheen_camera half;
    assert_ok(sheen_camera_scale(&half, &f.camera, 0.5, &err), err);
    assert_ok(sheen_camera_save(&half, path, &err), err);
    assert_fails(sheen_pose_session(&summary, NULL, &s, &usual, &err), err, SHEEN_EDATA,
                 "frame 'f0' is 480 x 360 px but 'camera.cameramodel' is for 240 x 180");
    test_file_write_text(path, "{ 'lensmodel': 'LENSMODEL_OPENCV4', 'intrinsics': [ nan ] }");
    assert_fails(sheen_pose_session(&summary, NULL, &s, &usual, &err), err, SHEEN_EFORMAT,
                 "camera.cameramodel");
    assert_ok(sheen_file_remove(path, &err), err);
    assert_fails(sheen_pose_session(&summary, NULL, &s, &usual, &err), err, SHEEN_EDATA, "calibrate first");
    assert_ok(sheen_camera_save(&f.camera, path, &err), err);

    assert_ok(sheen_session_path(path, &s, SHEEN_SESSION_BOARD, &err), err);
    sheen_board other;
    test_board_make(&other, 8, 6, 0.033, 0.64, 300, 0);
    test_board_save(&other, path);
    sheen_board_release(&other);
    assert_fails(sheen_pose_session(&summary, NULL, &s, &usual, &err), err, SHEEN_EDATA,
                 "none of 4 frames has a pose ('f0': no tag of the board in view)");
    assert_ok(sheen_file_remove(path, &err), err);
    assert_fails(sheen_pose_session(&summary, NULL, &s, &usual, &err), err, SHEEN_EDATA,
                 "has no 'board.json'");
    assert_false(sheen_session_has(&s, SHEEN_SESSION_POSES));
    assert_false(sheen_session_has(&s, SHEEN_SESSION_DETECTIONS));
    sheen_board_release(&f.board);
    sheen_session_release(&s);
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Compares all poses with the sample's scene.json.
static void check_sample(const sheen_poses *poses, const char *what, double most_mm, double most_deg)
{
    enum { N = 12 };
    sheen_err err;
    sheen_json *scene;
    double mm[N], deg[N];
    assert_ok(sheen_json_load(&scene, SHEEN_TEST_DATA "/penguin-truth/scene.json", &err), err);
    const sheen_json *views = sheen_json_get(scene, "views");
    assert_int_equal(sheen_json_count(views), N);
    for (size_t i = 0; i < N; i++) {
        sheen_Rt Rt;
        double truth[6];
        const char *name;
        assert_ok(sheen_json_string(sheen_json_at(views, i), "name", &name, &err), err);
        assert_ok(sheen_json_numbers(sheen_json_at(views, i), "R", Rt.R[0], 9, &err), err);
        assert_ok(sheen_json_numbers(sheen_json_at(views, i), "t", Rt.t, 3, &err), err);
        sheen_rt_from_Rt(truth, &Rt);
        const sheen_frame_pose *p = sheen_poses_find(poses, name);
        assert_non_null(p);
        assert_true(p->found);
        mm[i] = 1e3 * hypot(hypot(p->rt_cam_board[3] - truth[3], p->rt_cam_board[4] - truth[4]),
                            p->rt_cam_board[5] - truth[5]);
        deg[i] = 57.29577951308232 * sheen_rt_angle_rad(p->rt_cam_board, truth);
    }
    sheen_json_free(&scene);
    qsort(mm, N, sizeof *mm, ascending);
    qsort(deg, N, sizeof *deg, ascending);
    print_message("sample, %s camera: median %.4f mm, %.4f deg; worst %.4f mm, %.4f deg\n", what, mm[N / 2],
                  deg[N / 2], mm[N - 1], deg[N - 1]);
    assert_close(mm[N / 2], 0, most_mm);
    assert_close(deg[N / 2], 0, most_deg);
    assert_close(mm[N - 1], 0, 3 * most_mm);
    assert_close(deg[N - 1], 0, 3 * most_deg);
}

static void the_sample_is_within_a_tenth_of_a_millimetre(void **state)
{
    const test_scratch *scratch = *state;
    char folder[TEST_PATH_MAX], path[SHEEN_PATH_MAX];
    sheen_err err;
    sheen_session sample, s;
    sheen_camera truth;
    sheen_calibration calibration;
    sheen_pose_summary summary;
    sheen_poses poses;
    assert_ok(sheen_session_open(&sample, SHEEN_TEST_DATA "/penguin", &err), err);
    test_scratch_file(folder, scratch, "penguin");
    assert_ok(sheen_session_create(&s, folder, SHEEN_MOVING_CAMERA, &err), err);
    for (size_t i = 0; i < sample.n_frames; i++) {
        uint8_t *payload;
        size_t size_bytes;
        sheen_frame_info info = sample.frames[i];
        assert_ok(sheen_session_payload(&payload, &size_bytes, &sample, &info, &err), err);
        assert_ok(
            sheen_session_add_frame(&s, &info, sheen_path_extension(info.file), payload, size_bytes, &err),
            err);
        free(payload);
    }
    sheen_session_release(&sample);
    assert_ok(sheen_session_path(path, &s, SHEEN_SESSION_BOARD, &err), err);
    assert_ok(sheen_file_copy(path, SHEEN_TEST_DATA "/penguin/board.json", &err), err);
    assert_ok(sheen_session_path(path, &s, SHEEN_SESSION_CALIBRATION_BOARD, &err), err);
    assert_ok(sheen_file_copy(path, SHEEN_TEST_DATA "/penguin/calibration-board.json", &err), err);

    assert_ok(sheen_calibrate_session(&calibration, &s, &(sheen_calibrate_options){0}, &err), err);
    sheen_calibration_release(&calibration);
    assert_ok(sheen_pose_session(&summary, &poses, &s, &(sheen_pose_options){0}, &err), err);
    assert_int_equal(summary.n_found, 12);
    check_sample(&poses, "calibrated", 0.1, 0.03);
    sheen_poses_release(&poses);

    const double k[4] = {-0.12, 0.05, 0.0008, -0.0006};
    assert_ok(sheen_camera_opencv(&truth, 1280, 960, (const double[4]){1500, 1500, 648.2, 471.7}, k, 4, &err),
              err);
    assert_ok(sheen_session_path(path, &s, SHEEN_SESSION_CAMERA, &err), err);
    assert_ok(sheen_camera_save(&truth, path, &err), err);
    assert_ok(sheen_pose_session(&summary, &poses, &s, &(sheen_pose_options){0}, &err), err);
    check_sample(&poses, "true", 0.03, 0.01);
    sheen_poses_release(&poses);
    sheen_session_release(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(every_frame_gets_a_pose_or_a_reason, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(boards_are_surveyed_together, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(a_rolling_frame_is_left_out, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(imported_poses_are_left_alone, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(faults_are_said_and_leave_the_session_alone, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(the_sample_is_within_a_tenth_of_a_millimetre, test_scratch_setup,
                                        test_scratch_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// SPDX-License-Identifier: Apache-2.0
// test_choose.c - somebody walks about a board with a camera in the hand: the frames that --auto takes, what it says, and
// when it ends; from a camera and from a recording of the same walk.
#include "cli/choose.h"

#include <linux/videodev2.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "capture/v4l2_source.h"
#include "cli/hook.h"
#include "cli/white.h"
#include "tests/calib/support_board.h"
#include "tests/fake/fake_v4l2.h"
#include "tests/support.h"

enum { W = 400, H = 300, N_STOPS = 24, AT_A_STOP = 4 };
static const double pi = 3.14159265358979323846;

static void make_session(sheen_session *s, void **state, const char *name, const sheen_board *board)
{
    char dir[TEST_PATH_MAX], path[SHEEN_PATH_MAX];
    sheen_err err;
    test_scratch_file(dir, *state, name);
    assert_ok(sheen_session_create(s, dir, SHEEN_MOVING_CAMERA, &err), err);
    assert_ok(sheen_session_path(path, s, SHEEN_SESSION_BOARD, &err), err);
    test_board_save(board, path);
}

static void add(sheen_session *s, const uint8_t *grey, int number)
{
    sheen_frame_info f;
    sheen_err err;
    sheen_frame_info_init(&f);
    sheen_session_next_name(s, f.name);
    f.width_px = f.stride_bytes = W;
    f.height_px = H;
    f.fourcc = V4L2_PIX_FMT_GREY;
    f.transfer = SHEEN_TRANSFER_LINEAR;
    f.t_ns = 1000000000 + (int64_t)number * 33333000;
    f.sequence = number;
    assert_ok(sheen_session_add_frame(s, &f, "raw", grey, (size_t)W * H, &err), err);
}

// At each stop the hand first moves (two frames, each some pixels on), then rests (two frames).
static void walk(sheen_session *s, const sheen_board *board)
{
    static const double fxycxy[4] = {W, W, 0.5 * (W - 1), 0.5 * (H - 1)}, middle[2] = {0, 0};
    sheen_camera camera;
    sheen_err err;
    assert_ok(sheen_camera_opencv(&camera, W, H, fxycxy, NULL, 0, &err), err);
    for (int i = 0; i < N_STOPS; i++)
        for (int k = 0; k < AT_A_STOP - 1; k++) {
            test_photo photo = {
                .board = board, .camera = &camera, .blur_px = 0.6, .noise_dn = 1, .seed = (uint64_t)i};
            test_board_look(photo.rt_cam_board, middle, 0.3, 45, 360.0 / N_STOPS * i, 0);
            photo.rt_cam_board[3] += 0.3 / W * 4 * (k < 2 ? k : 2);
            if (i == 3 && k >= 2)
                photo.blur_px = 1.6; // out of focus for a moment
            uint8_t *grey = test_photo_render(&photo);
            add(s, grey, AT_A_STOP * i + k);
            if (k == 2)
                add(s, grey, AT_A_STOP * i + k + 1);
            free(grey);
        }
}

typedef struct hints {
    bool still, sharp, on;
} hints;

static void on_hint(void *self, const char *text)
{
    hints *h = self;
    h->still = h->still || strstr(text, "hold still");
    h->sharp = h->sharp || strstr(text, "not sharp");
    h->on = h->on || strstr(text, "move on");
}

// Records by choice; the digests of what was taken, in order.
static size_t choose(char digests[32][33], sheen_session *s, sheen_source *src, hints *h)
{
    sheen_cli_choose c = {.spread_rad = 25 * pi / 180,
                          .max_motion_px = 0.5,
                          .max_blur_px = 2.5,
                          .hint = on_hint,
                          .hint_self = h};
    sheen_record_options o = {.count = 30, .policy = {&c, sheen_cli_choose_ask, sheen_cli_choose_look, NULL}};
    sheen_record_report report;
    char missing[120];
    sheen_err err;
    assert_ok(sheen_cli_choose_init(&c, s, &err), err);
    assert_false(sheen_cli_choose_missing(missing, &c));
    assert_ok(sheen_record(s, src, &o, &report, &err), err);
    assert_true(sheen_cli_choose_missing(missing, &c));
    assert_non_null(strstr(missing, "all around"));
    sheen_cli_choose_release(&c);
    assert_true(s->n_frames <= 32);
    for (size_t i = 0; i < s->n_frames; i++)
        memcpy(digests[i], s->frames[i].payload_digest, 33);
    return s->n_frames;
}

static void a_walk_is_covered_by_frames_at_rest(void **state)
{
    sheen_board board;
    sheen_session walked, from_camera, from_recording;
    sheen_source *src;
    fake_v4l2 f;
    hints h = {0};
    sheen_err err;
    char live[32][33], replayed[32][33], uri[SHEEN_PATH_MAX + 8];
    test_board_make(&board, 7, 5, 0.04, 0.75, 0, 0);
    make_session(&walked, state, "walked", &board);
    make_session(&from_camera, state, "from_camera", &board);
    make_session(&from_recording, state, "from_recording", &board);
    walk(&walked, &board);

    fake_v4l2_init(&f);
    assert_ok(fake_v4l2_play(&f, &walked, &err), err);
    assert_ok(sheen_v4l2_source_open(&src, &f.io, "/dev/video0?lock=off", &err), err);
    const size_t n = choose(live, &from_camera, src, &h);
    sheen_source_close(&src);
    assert_true(h.still && h.on);
    // 45 degrees about the board at 45 degrees of height are 31 on the sphere, 30 are 21: each third stop is new, the
    // fourth one once, and the last hole is none.
    assert_int_equal(n, 7);
    for (size_t i = 1; i < n; i++) {
        const int64_t at = from_camera.frames[i].sequence;
        assert_true(at % AT_A_STOP == AT_A_STOP - 1); // the hand had come to rest
        assert_true(at / AT_A_STOP != 3); // and the picture was sharp: the next stop served for that one
    }

    snprintf(uri, sizeof uri, "replay:%s", walked.path);
    assert_ok(sheen_source_open(&src, uri, &err), err);
    assert_int_equal(choose(replayed, &from_recording, src, &h), n);
    assert_memory_equal(replayed, live, n * sizeof *live);
    sheen_source_close(&src);

    // What a session has already is not wanted again.
    sheen_cli_choose again = {.spread_rad = 25 * pi / 180};
    char missing[120];
    assert_ok(sheen_cli_choose_init(&again, &from_camera, &err), err);
    assert_true(sheen_cli_choose_missing(missing, &again));
    sheen_cli_choose_release(&again);

    fake_v4l2_release(&f);
    sheen_session_release(&walked);
    sheen_session_release(&from_camera);
    sheen_session_release(&from_recording);
    sheen_board_release(&board);
}

// Lamps that are switched off midway: no frame of the new light gets into the session.
static void a_light_that_goes_off_ends_the_capture(void **state)
{
    static const double fxycxy[4] = {W, W, 0.5 * (W - 1), 0.5 * (H - 1)}, middle[2] = {0, 0};
    enum { N = 6, OFF_AT = 4 };
    sheen_board board;
    sheen_session lit, s;
    sheen_source *src;
    sheen_camera camera;
    sheen_cli_white white;
    fake_v4l2 f;
    sheen_record_report report;
    sheen_err err;
    test_board_make(&board, 7, 5, 0.04, 0.75, 0, 0);
    make_session(&lit, state, "lit", &board);
    make_session(&s, state, "watched", &board);
    assert_ok(sheen_camera_opencv(&camera, W, H, fxycxy, NULL, 0, &err), err);
    test_photo photo = {.board = &board, .camera = &camera, .blur_px = 0.6, .noise_dn = 1};
    test_board_look(photo.rt_cam_board, middle, 0.3, 30, 0, 0);
    uint8_t *grey = test_photo_render(&photo);
    for (int i = 0; i < N; i++) {
        for (size_t k = 0; i == OFF_AT && k < (size_t)W * H; k++)
            grey[k] = (uint8_t)(grey[k] * 7 / 10);
        add(&lit, grey, i);
    }
    free(grey);
    fake_v4l2_init(&f);
    assert_ok(fake_v4l2_play(&f, &lit, &err), err);
    assert_ok(sheen_v4l2_source_open(&src, &f.io, "/dev/video0?lock=off", &err), err);
    assert_ok(sheen_cli_white_init(&white, &s, &err), err);
    const sheen_record_options o = {.count = N, .check = sheen_cli_white_check, .check_self = &white};
    assert_fails(sheen_record(&s, src, &o, &report, &err), err, SHEEN_EDATA, "the light has changed");
    assert_int_equal(report.n_recorded, OFF_AT);
    sheen_cli_white_release(&white);
    sheen_source_close(&src);
    fake_v4l2_release(&f);
    sheen_session_release(&lit);
    sheen_session_release(&s);
    sheen_board_release(&board);
}

static void a_session_without_a_board_is_told(void **state)
{
    char dir[TEST_PATH_MAX];
    sheen_session s;
    sheen_cli_choose c = {0};
    sheen_err err;
    test_scratch_file(dir, *state, "bare");
    assert_ok(sheen_session_create(&s, dir, SHEEN_MOVING_CAMERA, &err), err);
    assert_fails(sheen_cli_choose_init(&c, &s, &err), err, SHEEN_EARG, "--board");
    sheen_session_release(&s);
}

static void a_hook_knows_what_happened(void **state)
{
    char path[TEST_PATH_MAX], command[TEST_PATH_MAX + 64];
    size_t n;
    sheen_err err;
    test_scratch_file(path, *state, "heard");
    snprintf(command, sizeof command, "echo \"$ACTION $ARGUMENT\" >>'%s'", path);
    assert_ok(sheen_cli_hook(NULL, "init", "", &err), err);
    assert_ok(sheen_cli_hook(command, "init", "a session", &err), err);
    assert_ok(sheen_cli_hook(command, "download", "frames/1.jpg", &err), err);
    uint8_t *text = test_file_read(path, &n);
    assert_string_equal((const char *)text, "init a session\ndownload frames/1.jpg\n");
    free(text);
    assert_fails(sheen_cli_hook("exit 3", "stop", "", &err), err, SHEEN_EIO, "failed at stop");
}

#define WITH_SCRATCH(f) cmocka_unit_test_setup_teardown(f, test_scratch_setup, test_scratch_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_SCRATCH(a_walk_is_covered_by_frames_at_rest),
        WITH_SCRATCH(a_light_that_goes_off_ends_the_capture),
        WITH_SCRATCH(a_session_without_a_board_is_told),
        WITH_SCRATCH(a_hook_knows_what_happened),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

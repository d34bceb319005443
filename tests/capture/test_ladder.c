// SPDX-License-Identifier: Apache-2.0
// test_ladder.c - a camera that stalls, fails, is unplugged and comes back, while a session is recorded.
#include "capture/ladder.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <linux/videodev2.h>

#include "capture/v4l2_source.h"
#include "tests/fake/fake_v4l2.h"
#include "tests/support.h"

#define CAMERA "/dev/video0"

typedef struct notices {
    char text[4096];
} notices;

static void note(void *self, const char *text)
{
    notices *n = self;
    const size_t end = strlen(n->text);
    snprintf(n->text + end, sizeof n->text - end, "%s\n", text);
}

static void make_session(sheen_session *s, void **state, const char *name)
{
    char dir[TEST_PATH_MAX];
    sheen_err err;
    test_scratch_file(dir, *state, name);
    assert_ok(sheen_session_create(s, dir, SHEEN_MOVING_CAMERA, &err), err);
}

// Every frame of the session is whole, and was exposed as the lock says: 300, of 600 for full scale.
static void check_session(const char *path, size_t n_frames)
{
    sheen_session s;
    sheen_err err;
    assert_ok(sheen_session_open(&s, path, &err), err);
    assert_int_equal(s.n_frames, n_frames);
    for (size_t i = 0; i < n_frames; i++) {
        sheen_image image;
        assert_int_equal(s.frames[i].lock, SHEEN_LOCK_HELD);
        assert_ok(sheen_session_image(&image, &s, &s.frames[i], &err), err);
        assert_close(*sheen_image_at(&image, 20, 20), 128 / 255.0, 1e-4);
        sheen_image_release(&image);
    }
    sheen_session_release(&s);
}

static sheen_status record(void **state, fake_v4l2 *f, notices *n, sheen_record_report *report,
                           double patience_s, sheen_err *err)
{
    sheen_session s;
    sheen_err clean_up;
    sheen_source *src = NULL;
    const sheen_record_options options = {
        .count = 4, .timeout_ms = 2000, .patience_s = patience_s, .notice = note, .notice_self = n};
    *report = (sheen_record_report){0};
    make_session(&s, state, "session");
    sheen_status st = sheen_v4l2_source_open(&src, &f->io, CAMERA, err);
    if (!st)
        st = sheen_record(&s, src, &options, report, err);
    assert_int_equal(s.n_frames, report->n_recorded);
    sheen_source_close(&src);
    assert_true(fake_v4l2_is_clean(f));
    check_session(s.path, report->n_recorded);
    assert_ok(sheen_dir_remove(s.path, &clean_up), clean_up);
    sheen_session_release(&s);
    return st;
}

// A frame of the sensor in the middle of what is recorded; the lock, its probe and its proof come before.
static int64_t middle(void **state)
{
    fake_v4l2 f;
    notices n = {0};
    sheen_record_report report;
    sheen_err err;
    fake_v4l2_init(&f);
    assert_ok(record(state, &f, &n, &report, 0, &err), err);
    assert_string_equal(n.text, "");
    return f.n_frames - 2;
}

static void each_rung_helps_where_the_one_below_does_not(void **state)
{
    static const char *const last[] = {NULL, "stream is started again", "closed and opened again",
                                       "USB device is reset", "unplug the camera"};
    for (int cure = FAKE_RESTART; cure <= FAKE_USB_RESET; cure++) {
        fake_v4l2 f;
        notices n = {0};
        sheen_record_report report;
        sheen_err err;
        fake_v4l2_init(&f);
        f.faults.stall_at = middle(state);
        f.faults.cure = (fake_remedy)cure;
        assert_ok(record(state, &f, &n, &report, 60, &err), err);
        assert_int_equal(report.n_recorded, 4);
        assert_int_equal(report.n_recovered, 1);
        assert_non_null(strstr(n.text, last[cure]));
        assert_null(strstr(n.text, last[cure + 1]));
        assert_int_equal(f.n_resets, cure == FAKE_USB_RESET);
    }
}

static void the_person_is_asked_last_and_waited_for(void **state)
{
    fake_v4l2 f;
    notices n = {0};
    sheen_record_report report;
    sheen_err err;
    fake_v4l2_init(&f);
    f.faults.unplug_at = middle(state);
    f.faults.return_after_ns = 20000000000;
    f.faults.return_node = 3; // by its lasting name it is still found
    assert_ok(record(state, &f, &n, &report, 60, &err), err);
    assert_int_equal(report.n_recorded, 4);
    assert_non_null(strstr(n.text, "plug it in"));
    assert_non_null(strstr(n.text, "there again"));
    assert_int_equal(f.n_resets, 0);

    // Nobody comes: the session has what was recorded.
    fake_v4l2_init(&f);
    f.faults.unplug_at = middle(state);
    assert_fails(record(state, &f, &n, &report, 60, &err), err, SHEEN_ENODEV, "plug it in");
    assert_true(report.n_recorded > 0 && report.n_recorded < 4);
}

static void another_camera_is_not_taken_for_the_one_that_left(void **state)
{
    fake_v4l2 f;
    notices n = {0};
    sheen_record_report report;
    sheen_err err;
    fake_v4l2_init(&f);
    f.faults.unplug_at = middle(state);
    f.faults.return_after_ns = 5000000000;
    f.faults.return_as = "046d:0825 X";
    assert_fails(record(state, &f, &n, &report, 30, &err), err, SHEEN_ENODEV, "plug it in");
    assert_non_null(strstr(n.text, "another camera"));
}

static void another_camera_at_the_remembered_place_is_told(void **state)
{
    sheen_session s;
    sheen_frame_info old;
    sheen_err err;
    make_session(&s, state, "remembered");
    sheen_frame_info_init(&old);
    snprintf(old.name, sizeof old.name, "000000");
    snprintf(old.source, sizeof old.source, "v4l2:/dev/video0");
    snprintf(old.device, sizeof old.device, "Some Other (usb-0000:00:14.0-1)");
    old.width_px = old.height_px = 1;
    assert_ok(sheen_session_add_frame(&s, &old, "png", "x", 1, &err), err);
    for (int again = 0; again < 2; again++) { // the second time the last frame is this camera's
        fake_v4l2 f;
        notices n = {0};
        sheen_source *src;
        sheen_record_report report;
        const sheen_record_options o = {.count = 1, .notice = note, .notice_self = &n};
        fake_v4l2_init(&f);
        assert_ok(sheen_v4l2_source_open(&src, &f.io, CAMERA "?lock=off", &err), err);
        assert_ok(sheen_record(&s, src, &o, &report, &err), err);
        assert_true(again == !strstr(n.text, "another camera is at"));
        sheen_source_close(&src);
    }
    sheen_session_release(&s);
}

// A camera that never gave a frame is not reset: it may be another's at work.
static void nothing_is_reset_before_it_has_worked(void **state)
{
    fake_v4l2 f;
    notices n = {0};
    sheen_record_report report;
    sheen_err err;
    fake_v4l2_init(&f);
    f.faults.stall_at = 3;
    f.faults.cure = FAKE_USB_RESET;
    assert_fails(record(state, &f, &n, &report, 0, &err), err, SHEEN_ETIMEOUT, "no frame came");
    assert_int_equal(f.n_resets, 0);
    assert_non_null(strstr(n.text, "opened again"));
}

// Call n fails, for n = 1, 2, 3 ... until a whole capture, with its lock and its proof, comes through untouched.
static void loop_calls(void **state, int code, int64_t return_after_ns, double patience_s)
{
    int n_whole = 0, n = 1;
    for (bool untouched = false; !untouched; n++) {
        fake_v4l2 f;
        notices said = {0};
        sheen_record_report report;
        sheen_err err = {0};
        fake_v4l2_init(&f);
        f.faults.fail_call = n;
        f.faults.fail_errno = code;
        f.faults.return_after_ns = return_after_ns;
        const sheen_status st = record(state, &f, &said, &report, patience_s, &err);
        if (st)
            assert_true(st == err.code && strlen(err.msg) > 20 && strstr(err.msg, "/dev/video0"));
        else
            assert_int_equal(report.n_recorded, 4);
        assert_int_equal(report.n_lost, 0);
        n_whole += !st;
        untouched = f.n_calls < n;
        assert_true(!untouched || !st);
        assert_true(n < 5000);
    }
    print_message("errno %d: %d calls, a whole capture in spite of %d of them\n", code, n - 2, n_whole - 1);
    assert_true(n > 300);
    if (patience_s > 0)
        assert_true(n_whole > n / 2); // all but those before the stream has begun
}

static void a_capture_survives_any_call_that_fails(void **state)
{
    loop_calls(state, EIO, 0, 0);
}

static void a_capture_survives_what_passes_by_itself(void **state)
{
    loop_calls(state, EINTR, 0, 60);
    loop_calls(state, EAGAIN, 0, 60);
    loop_calls(state, ENOSPC, 0, 60);
}

static void a_capture_survives_an_unplug_at_any_call(void **state)
{
    loop_calls(state, ENODEV, 3000000000, 60);
}

#define WITH_SCRATCH(f) cmocka_unit_test_setup_teardown(f, test_scratch_setup, test_scratch_teardown)

int main(void)
{
    if (!access("/dev/shm", W_OK))
        setenv("TMPDIR", "/dev/shm", 0); // thousands of frames are synchronised to the "disk"
    const struct CMUnitTest tests[] = {
        WITH_SCRATCH(each_rung_helps_where_the_one_below_does_not),
        WITH_SCRATCH(the_person_is_asked_last_and_waited_for),
        WITH_SCRATCH(another_camera_is_not_taken_for_the_one_that_left),
        WITH_SCRATCH(another_camera_at_the_remembered_place_is_told),
        WITH_SCRATCH(nothing_is_reset_before_it_has_worked),
        WITH_SCRATCH(a_capture_survives_any_call_that_fails),
        WITH_SCRATCH(a_capture_survives_what_passes_by_itself),
        WITH_SCRATCH(a_capture_survives_an_unplug_at_any_call),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// SPDX-License-Identifier: Apache-2.0
// test_v4l2_source.c - the V4L2 source against a camera in memory: what it delivers, counts, locks, proves, and says.
#include "capture/v4l2_source.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <linux/videodev2.h>

#include "capture/record.h"
#include "capture/v4l2_error.h"
#include "capture/v4l2_stream.h"
#include "tests/fake/fake_v4l2.h"
#include "tests/support.h"

#define CAMERA "/dev/video0"
#define UNLOCKED CAMERA "?lock=off"

static int64_t frame_number(const sheen_frame *frame)
{
    int64_t n;
    memcpy(&n, frame->data, sizeof n);
    return n;
}

static void open_fake(sheen_source **src, fake_v4l2 *f, const char *rest)
{
    sheen_err err;
    assert_ok(sheen_v4l2_source_open(src, &f->io, rest, &err), err);
}

static void close_clean(sheen_source **src, const fake_v4l2 *f)
{
    sheen_source_close(src);
    assert_true(fake_v4l2_is_clean(f));
}

// The first frame that a source gives, or why there is none: ETIMEOUT only when nothing at all comes.
static sheen_status first_frame(sheen_frame *frame, sheen_source *src, sheen_err *err)
{
    return sheen_source_next(src, 60000, frame, err);
}

static void delivers_frames_in_order_with_their_description(void **state)
{
    (void)state;
    fake_v4l2 f;
    sheen_source *src;
    sheen_frame frame;
    sheen_err err;
    fake_v4l2_init(&f);
    open_fake(&src, &f, UNLOCKED);
    assert_true(sheen_source_is_live(src));
    assert_int_equal(sheen_source_count(src), -1);
    for (int64_t i = 0; i < 40; i++) {
        assert_ok(sheen_source_next(src, 1000, &frame, &err), err);
        assert_true(frame_number(&frame) == i && frame.info.sequence == i);
        assert_true(frame.info.t_ns > 0 && frame.info.t_ns < f.now_ns);
    }
    assert_int_equal(frame.size_bytes, 32 * 24 * 3);
    assert_int_equal(frame.info.fourcc, V4L2_PIX_FMT_RGB24);
    assert_true(frame.info.width_px == 32 && frame.info.height_px == 24 && frame.info.stride_bytes == 96);
    assert_int_equal(frame.info.transfer, SHEEN_TRANSFER_LINEAR);
    assert_int_equal(frame.info.color.quantization, V4L2_QUANTIZATION_FULL_RANGE);
    assert_int_equal(frame.info.lock, SHEEN_LOCK_OFF);
    assert_string_equal(frame.info.source, "v4l2:/dev/video0");
    assert_string_equal(frame.info.device, "Fake Camera (usb-0000:00:14.0-1)");
    assert_string_equal(frame.extension, "raw");
    close_clean(&src, &f);
}

static void every_frame_is_accounted_for(void **state)
{
    (void)state;
    fake_v4l2 f;
    sheen_source *src;
    sheen_frame frame;
    sheen_err err;
    sheen_source_counts counts;
    fake_v4l2_init(&f);
    f.faults.dropped = 1u << 3 | 1u << 4;
    f.faults.flagged = 1u << 6;
    f.faults.cut = 1u << 8;
    f.faults.swapped = 1u << 10 | 1u << 20;
    f.faults.first_sequence = UINT32_MAX - 11; // wraps at frame 12
    open_fake(&src, &f, UNLOCKED);
    int64_t last = -1;
    for (int i = 0; i < 26; i++) {
        assert_ok(sheen_source_next(src, 1000, &frame, &err), err);
        assert_true(frame_number(&frame) > last);
        last = frame_number(&frame);
        assert_true(last != 3 && last != 4 && last != 6 && last != 8);
        assert_true(frame.info.sequence == (int64_t)UINT32_MAX - 11 + last);
    }
    assert_int_equal(last, 29);
    sheen_source_counters(&counts, src);
    assert_int_equal(counts.n_frames, 26);
    assert_int_equal(counts.n_dropped, 2);
    assert_int_equal(counts.n_flagged, 1);
    assert_int_equal(counts.n_short, 1);
    assert_int_equal(counts.n_late, 0);
    assert_int_equal(f.n_unqueued, 0); // every rejected buffer went back
    close_clean(&src, &f);
}

static void what_a_camera_claims_of_its_colours_can_be_corrected(void **state)
{
    (void)state;
    fake_v4l2 f;
    sheen_source *src;
    sheen_frame frame;
    sheen_err err;
    fake_v4l2_init(&f);
    open_fake(&src, &f, UNLOCKED "&range=limited&matrix=709&transfer=srgb");
    assert_ok(sheen_source_next(src, 1000, &frame, &err), err);
    assert_int_equal(frame.info.color.quantization, V4L2_QUANTIZATION_LIM_RANGE);
    assert_int_equal(frame.info.color.ycbcr_enc, V4L2_YCBCR_ENC_709);
    assert_int_equal(frame.info.transfer, SHEEN_TRANSFER_SRGB);
    close_clean(&src, &f);
}

static void a_counter_that_stands_still_loses_nothing(void **state)
{
    (void)state;
    fake_v4l2 f;
    sheen_source *src;
    sheen_frame frame;
    sheen_err err;
    fake_v4l2_init(&f);
    f.faults.sequence_stands = true;
    open_fake(&src, &f, UNLOCKED);
    for (int64_t i = 0; i < 10; i++) {
        assert_ok(sheen_source_next(src, 1000, &frame, &err), err);
        assert_true(frame_number(&frame) == i && frame.info.sequence == i);
    }
    close_clean(&src, &f);
}

static void stamps_are_of_the_start_of_the_exposure(void **state)
{
    (void)state;
    fake_v4l2 f;
    sheen_source *src;
    sheen_frame frame;
    sheen_err err;
    fake_v4l2_init(&f);
    f.faults.stamps_end = true;
    open_fake(&src, &f, UNLOCKED);
    assert_ok(sheen_source_next(src, 1000, &frame, &err), err);
    assert_true(frame.info.t_ns <= f.now_ns - f.interval_ns);
    close_clean(&src, &f);
    fake_v4l2_init(&f);
    f.faults.stamps_none = true;
    open_fake(&src, &f, UNLOCKED);
    assert_ok(sheen_source_next(src, 1000, &frame, &err), err);
    assert_true(frame.info.t_ns == -1);
    close_clean(&src, &f);
}

static void a_stalled_camera_times_out_and_an_unplugged_one_is_gone(void **state)
{
    (void)state;
    fake_v4l2 f;
    sheen_source *src;
    sheen_frame frame;
    sheen_err err;
    fake_v4l2_init(&f);
    f.faults.stall_at = 2;
    open_fake(&src, &f, UNLOCKED);
    assert_ok(sheen_source_next(src, 1000, &frame, &err), err);
    assert_ok(sheen_source_next(src, 1000, &frame, &err), err);
    assert_fails(sheen_source_next(src, 1000, &frame, &err), err, SHEEN_ETIMEOUT, "no frame came");
    close_clean(&src, &f);
    fake_v4l2_init(&f);
    f.faults.unplug_at = 2;
    open_fake(&src, &f, UNLOCKED);
    assert_ok(sheen_source_next(src, 1000, &frame, &err), err);
    assert_ok(sheen_source_next(src, 1000, &frame, &err), err);
    assert_fails(sheen_source_next(src, 1000, &frame, &err), err, SHEEN_ENODEV, "plug it in");
    close_clean(&src, &f);
}

static void jpeg_frames_need_their_end(void **state)
{
    (void)state;
    static const uint8_t whole[] = {0xff, 0xd8, 0xff, 0xe0, 1, 2, 0xff, 0xd9, 0, 0};
    assert_true(sheen_v4l2_jpeg_whole(whole, sizeof whole));
    assert_true(sheen_v4l2_jpeg_whole(whole, 8));
    assert_false(sheen_v4l2_jpeg_whole(whole, 7));
    assert_false(sheen_v4l2_jpeg_whole(whole + 1, 7));
    assert_false(sheen_v4l2_jpeg_whole(whole, 0));
    static const uint8_t zeros[16];
    assert_false(sheen_v4l2_jpeg_whole(zeros, sizeof zeros));
}

static void says_what_is_wrong_with_a_camera(void **state)
{
    (void)state;
    static const struct {
        const char *rest;
        fake_faults faults;
        sheen_status code;
        const char *part;
    } cases[] = {
        {"/dev/video7", {0}, SHEEN_ENODEV, "sheen devices"},
        {CAMERA, {.no_capture = true}, SHEEN_EUNSUP, "captures no video"},
        {CAMERA, {.fail_request = VIDIOC_STREAMON, .fail_request_errno = ENOSPC}, SHEEN_EIO, "bandwidth"},
        {CAMERA, {.fail_request = VIDIOC_S_FMT, .fail_request_errno = EBUSY}, SHEEN_EIO, "uses the camera"},
        {CAMERA, {.fail_call = 1, .fail_errno = EACCES}, SHEEN_EACCESS, "video"},
        {CAMERA "?format=YUYV", {0}, SHEEN_EUNSUP, "RGB3"},
        {CAMERA "?size=1x1", {0}, SHEEN_EUNSUP, "32 x 24"},
        {CAMERA "?rate=7", {0}, SHEEN_EUNSUP, "30"},
        {CAMERA "?rate=x", {0}, SHEEN_EARG, "frames a second"},
        {CAMERA "?speed=7", {0}, SHEEN_EARG, "unknown option"},
        {CAMERA "?exposures_ms=1,2,", {0}, SHEEN_EARG, "commas"},
        {CAMERA "?exposures_ms=1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17", {0}, SHEEN_EARG, "16 at most"},
        {CAMERA "?exposure_most_ms=0", {0}, SHEEN_EARG, "milliseconds"},
        {CAMERA "?mains=55", {0}, SHEEN_EARG, "50 or 60"},
        {CAMERA "?size", {0}, SHEEN_EARG, "no value"},
        {CAMERA "?matrix=7", {0}, SHEEN_EARG, "709"},
        {CAMERA "?range=wide", {0}, SHEEN_EARG, "limited"},
        {CAMERA, {.no_exposure = true}, SHEEN_EUNSUP, "no control of its exposure"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        fake_v4l2 f;
        sheen_source *src;
        sheen_err err;
        fake_v4l2_init(&f);
        f.faults = cases[i].faults;
        assert_fails(sheen_v4l2_source_open(&src, &f.io, cases[i].rest, &err), err, cases[i].code,
                     cases[i].part);
        assert_null(src);
        assert_true(fake_v4l2_is_clean(&f));
    }
}

static int32_t recorded(const sheen_frame_info *info, uint32_t id)
{
    for (int i = 0; i < info->n_controls; i++)
        if (info->controls[i].id == id)
            return info->controls[i].value;
    return INT32_MIN;
}

static void the_lock_turns_automatics_off_and_fixes_the_rest(void **state)
{
    (void)state;
    for (int lag = 0; lag <= 6; lag++) {
        fake_v4l2 f;
        sheen_source *src;
        sheen_frame frame;
        sheen_err err;
        fake_v4l2_init(&f);
        f.faults.lag_frames = lag;
        open_fake(&src, &f, CAMERA);
        assert_ok(first_frame(&frame, src, &err), err);
        assert_int_equal(frame.info.lock, SHEEN_LOCK_HELD);
        assert_int_equal(recorded(&frame.info, V4L2_CID_EXPOSURE_AUTO), V4L2_EXPOSURE_MANUAL);
        assert_int_equal(recorded(&frame.info, V4L2_CID_EXPOSURE_AUTO_PRIORITY), 0);
        assert_int_equal(recorded(&frame.info, V4L2_CID_AUTO_WHITE_BALANCE), 0);
        assert_int_equal(recorded(&frame.info, V4L2_CID_EXPOSURE_ABSOLUTE),
                         300); // 29.0 ms, to 3 half periods
        assert_int_equal(recorded(&frame.info, V4L2_CID_SHARPNESS), 1);
        assert_int_equal(recorded(&frame.info, V4L2_CID_BRIGHTNESS), 3);
        assert_int_equal(recorded(&frame.info, V4L2_CID_GAIN), 10);
        assert_int_equal(recorded(&frame.info, V4L2_CID_WHITE_BALANCE_TEMPERATURE), 4600);
        // Taken at the locked exposure, not at the automatic's nor at the probe's.
        assert_int_equal(frame.data[600], 128);
        close_clean(&src, &f);
    }
}

static void exposure_and_mains_can_be_chosen(void **state)
{
    (void)state;
    static const struct {
        const char *rest;
        int32_t exposure;
    } cases[] = {{CAMERA "?exposure_ms=25", 250},
                 {CAMERA "?mains=60", 250},
                 {CAMERA "?mains=0", 290},
                 {CAMERA "?exposure_most_ms=7.5", 75},
                 {CAMERA "?exposure_most_ms=25", 200},
                 {CAMERA "?exposures_ms=7.8,15.6,31.2", 312},
                 {CAMERA "?exposure_ms=20&exposures_ms=7.8,15.6,31.2", 156}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        fake_v4l2 f;
        sheen_source *src;
        sheen_frame frame;
        sheen_err err;
        fake_v4l2_init(&f);
        open_fake(&src, &f, cases[i].rest);
        assert_ok(first_frame(&frame, src, &err), err);
        assert_int_equal(recorded(&frame.info, V4L2_CID_EXPOSURE_ABSOLUTE), cases[i].exposure);
        close_clean(&src, &f);
    }
}

static void the_proof_catches_what_the_camera_hides(void **state)
{
    (void)state;
    static const struct {
        fake_faults faults;
        sheen_status code;
        const char *part;
    } cases[] = {
        {{.forgetful = V4L2_CID_AUTO_WHITE_BALANCE},
         SHEEN_EUNSUP,
         "White_Balance,_Automatic went back from 0 to 1"},
        {{.forgetful = V4L2_CID_SHARPNESS}, SHEEN_EUNSUP, "Sharpness went back from 1 to 3"},
        {{.deaf = true}, SHEEN_EDATA, "an automatic is still at work"},
        {{.flicker = 0.05}, SHEEN_EDATA, "flicker"},
        {{.auto_white_at = 30}, SHEEN_EDATA, "White_Balance,_Automatic was 0 and is now 1"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        fake_v4l2 f;
        sheen_source *src = NULL;
        sheen_frame frame;
        sheen_err err = {0};
        fake_v4l2_init(&f);
        f.faults = cases[i].faults;
        sheen_status s = sheen_v4l2_source_open(&src, &f.io, CAMERA, &err);
        if (!s)
            s = first_frame(&frame, src, &err);
        assert_fails(s, err, cases[i].code, cases[i].part);
        close_clean(&src, &f);
    }
}

static void a_white_balance_that_comes_back_once_is_set_again(void **state)
{
    (void)state;
    fake_v4l2 f;
    sheen_source *src;
    sheen_frame frame;
    sheen_err err;
    sheen_source_counts counts;
    fake_v4l2_init(&f);
    open_fake(&src, &f, CAMERA);
    assert_ok(first_frame(&frame, src, &err), err);
    fake_v4l2_control(&f, V4L2_CID_AUTO_WHITE_BALANCE)->value = 1;
    const int64_t at = f.n_frames;
    assert_ok(first_frame(&frame, src, &err), err);
    assert_int_equal(recorded(&frame.info, V4L2_CID_AUTO_WHITE_BALANCE), 0);
    assert_true(frame_number(&frame) >= at + 10); // settled anew
    sheen_source_counters(&counts, src);
    assert_int_equal(counts.n_unlocked, 1);
    close_clean(&src, &f);
}

static void make_session(sheen_session *s, void **state, const char *name)
{
    char dir[TEST_PATH_MAX];
    sheen_err err;
    test_scratch_file(dir, *state, name);
    assert_ok(sheen_session_create(s, dir, SHEEN_MOVING_CAMERA, &err), err);
}

// What was accepted is in the session, and is what the camera delivered.
static void check_recorded(const sheen_session *s, size_t n_frames)
{
    sheen_session again;
    sheen_err err;
    assert_ok(sheen_session_open(&again, s->path, &err), err);
    assert_int_equal(again.n_frames, n_frames);
    for (size_t i = 0; i < n_frames; i++) {
        sheen_image image;
        assert_ok(sheen_session_image(&image, &again, &again.frames[i], &err), err);
        assert_close(*sheen_image_at(&image, 20, 20), 123 / 255.0, 1e-4); // exposure 290 of 600
        sheen_image_release(&image);
    }
    sheen_session_release(&again);
}

// Call n fails, for n = 1, 2, 3 ... until a whole recording comes through untouched.
static void loop_recording(void **state, int code)
{
    int n = 1;
    for (bool whole = false; !whole; n++) {
        fake_v4l2 f;
        sheen_session s;
        sheen_source *src = NULL;
        sheen_record_report report = {0};
        const sheen_record_options options = {.count = 2};
        sheen_err err = {0};
        sheen_err clean_up;
        make_session(&s, state, "faults");
        fake_v4l2_init(&f);
        f.faults.fail_call = n;
        f.faults.fail_errno = code;
        sheen_status st = sheen_v4l2_source_open(&src, &f.io, UNLOCKED, &err);
        if (!st)
            st = sheen_record(&s, src, &options, &report, &err);
        close_clean(&src, &f);
        if (st) {
            assert_true(st == err.code && strlen(err.msg) > 20 && strstr(err.msg, "/dev/video0"));
            assert_true(st == SHEEN_EIO || st == SHEEN_ENODEV || st == SHEEN_EUNSUP);
        } else
            assert_int_equal(report.n_recorded, 2);
        if (code == EINTR && n > 1) // an interruption is no failure
            assert_int_equal(st, SHEEN_OK);
        check_recorded(&s, report.n_recorded);
        assert_ok(sheen_dir_remove(s.path, &clean_up), clean_up);
        sheen_session_release(&s);
        whole = f.n_calls < n;
        assert_true(!whole || !st);
        assert_true(n < 300);
    }
    assert_true(n > 15);
}

static void a_recording_survives_any_call_that_fails(void **state)
{
    static const int codes[] = {EIO, ENODEV, EINTR, EAGAIN, ENOSPC};
    for (size_t i = 0; i < sizeof codes / sizeof *codes; i++)
        loop_recording(state, codes[i]);
}

// The same through lock, probe and proof, down to the third frame.
static void a_locked_camera_survives_any_call_that_fails(void **state)
{
    (void)state;
    static const int codes[] = {EIO, ENODEV, EINTR, EAGAIN, EBUSY, ENOSPC};
    for (size_t i = 0; i < sizeof codes / sizeof *codes; i++)
        for (int n = 1; n < 3000; n++) {
            fake_v4l2 f;
            sheen_source *src = NULL;
            sheen_frame frame;
            sheen_err err = {0};
            fake_v4l2_init(&f);
            f.faults.fail_call = n;
            f.faults.fail_errno = codes[i];
            sheen_status st = sheen_v4l2_source_open(&src, &f.io, CAMERA, &err);
            for (int k = 0; !st && k < 3; k++) {
                st = sheen_source_next(src, 20000, &frame, &err);
                if (!st) {
                    assert_int_equal(frame.data[600], 128);
                    assert_int_equal(recorded(&frame.info, V4L2_CID_EXPOSURE_ABSOLUTE), 300);
                }
            }
            close_clean(&src, &f);
            assert_true(!st || (st == err.code && strstr(err.msg, "/dev/video0")));
            if (codes[i] == EINTR && n > 1)
                assert_int_equal(st, SHEEN_OK);
            if (f.n_calls < n) {
                assert_int_equal(st, SHEEN_OK);
                assert_true(n > 200);
                break;
            }
        }
}

static int64_t asked_for(const fake_v4l2 *f)
{
    return f->n_frames >= 9 ? 1000000000 + 9 * f->interval_ns + f->interval_ns / 2 : -1;
}

static sheen_status ask(void *self, int64_t *since_ns, sheen_err *err)
{
    (void)err;
    *since_ns = asked_for(self);
    return SHEEN_OK;
}

static void a_frame_that_was_asked_for_was_exposed_after_that(void **state)
{
    for (int stamps = 0; stamps < 2; stamps++) {
        fake_v4l2 f;
        sheen_session s;
        sheen_source *src;
        sheen_record_report report;
        sheen_err err;
        fake_v4l2_init(&f);
        f.faults.stamps_none = stamps;
        make_session(&s, state, stamps ? "none" : "stamped");
        open_fake(&src, &f, UNLOCKED);
        const sheen_record_options options = {.count = 1, .policy = {.self = &f, .ask = ask}};
        assert_ok(sheen_record(&s, src, &options, &report, &err), err);
        assert_int_equal(s.n_frames, 1);
        if (stamps)
            assert_true(s.frames[0].sequence >= 9 + 8);
        else
            assert_true(s.frames[0].t_ns >= asked_for(&f) &&
                        s.frames[0].t_ns < asked_for(&f) + f.interval_ns);
        close_clean(&src, &f);
        sheen_session_release(&s);
    }
}

static void plays_a_recorded_session_byte_by_byte(void **state)
{
    fake_v4l2 f, g;
    sheen_session a, b;
    sheen_source *src;
    sheen_record_report report;
    sheen_err err;
    fake_v4l2_init(&f);
    make_session(&a, state, "a");
    make_session(&b, state, "b");
    open_fake(&src, &f, CAMERA);
    const sheen_record_options options = {.count = 4};
    assert_ok(sheen_record(&a, src, &options, &report, &err), err);
    close_clean(&src, &f);
    fake_v4l2_init(&g);
    assert_ok(fake_v4l2_play(&g, &a, &err), err);
    open_fake(&src, &g, UNLOCKED);
    assert_ok(sheen_record(&b, src, &options, &report, &err), err);
    close_clean(&src, &g);
    for (size_t i = 0; i < 4; i++) {
        assert_string_equal(a.frames[i].payload_digest, b.frames[i].payload_digest);
        assert_true(a.frames[i].color.quantization == b.frames[i].color.quantization);
    }
    fake_v4l2_release(&g);
    sheen_session_release(&b);
    assert_ok(sheen_session_open(&b, a.path, &err), err); // the lock and its settings come back from the disk
    assert_int_equal(b.frames[0].lock, SHEEN_LOCK_HELD);
    assert_int_equal(b.frames[0].n_controls, a.frames[0].n_controls);
    assert_memory_equal(b.frames[0].controls, a.frames[0].controls, sizeof b.frames[0].controls);
    assert_string_equal(b.frames[0].device, "Fake Camera (usb-0000:00:14.0-1)");
    sheen_session_release(&b);
    sheen_session_release(&a);
}

#define WITH_SCRATCH(f) cmocka_unit_test_setup_teardown(f, test_scratch_setup, test_scratch_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(delivers_frames_in_order_with_their_description),
        cmocka_unit_test(every_frame_is_accounted_for),
        cmocka_unit_test(what_a_camera_claims_of_its_colours_can_be_corrected),
        cmocka_unit_test(a_counter_that_stands_still_loses_nothing),
        cmocka_unit_test(stamps_are_of_the_start_of_the_exposure),
        cmocka_unit_test(a_stalled_camera_times_out_and_an_unplugged_one_is_gone),
        cmocka_unit_test(jpeg_frames_need_their_end),
        cmocka_unit_test(says_what_is_wrong_with_a_camera),
        cmocka_unit_test(the_lock_turns_automatics_off_and_fixes_the_rest),
        cmocka_unit_test(exposure_and_mains_can_be_chosen),
        cmocka_unit_test(the_proof_catches_what_the_camera_hides),
        cmocka_unit_test(a_white_balance_that_comes_back_once_is_set_again),
        WITH_SCRATCH(a_recording_survives_any_call_that_fails),
        cmocka_unit_test(a_locked_camera_survives_any_call_that_fails),
        WITH_SCRATCH(a_frame_that_was_asked_for_was_exposed_after_that),
        WITH_SCRATCH(plays_a_recorded_session_byte_by_byte),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

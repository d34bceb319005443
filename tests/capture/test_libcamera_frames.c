// SPDX-License-Identifier: Apache-2.0
// test_libcamera_frames.c - what becomes of a libcamera camera's finished requests, without libcamera.
#include "capture/libcamera_frames.h"

#include <pthread.h>
#include <string.h>

#include <linux/videodev2.h>

#include "base/clock.h"
#include "capture/libcamera_inbox.h"
#include "capture/v4l2_options.h"
#include "tests/support.h"

enum { WIDTH = 4, HEIGHT = 2, N_BYTES = WIDTH * HEIGHT };

static const sheen_frame_pipeline says = {
    .exposure_us = 10000, .analogue_gain = 2, .red_gain = 1.5, .blue_gain = 2};

static void begin(sheen_libcamera_frames *f, uint32_t fourcc)
{
    sheen_err err;
    *f = (sheen_libcamera_frames){0};
    sheen_frame_info_init(&f->info);
    f->info.fourcc = fourcc;
    f->info.width_px = WIDTH;
    f->info.height_px = HEIGHT;
    f->info.stride_bytes = fourcc ? WIDTH : 0;
    f->info.color.colorspace = V4L2_COLORSPACE_SRGB;
    assert_ok(sheen_libcamera_frames_describe(f, "Camera", "/base/cam", "4x2", NULL, &err), err);
}

// A finished request with n bytes; whether its frame is kept.
static bool finish(sheen_libcamera_frames *f, sheen_frame *frame, int64_t sequence, const void *data,
                   size_t n)
{
    sheen_err err;
    bool keep = false;
    *frame = (sheen_frame){.data = data, .size_bytes = n, .info.t_ns = 7000};
    if (sheen_libcamera_frames_turn(f, sequence, true))
        assert_ok(sheen_libcamera_frames_judge(&keep, frame, f, &says, "Camera", &err), err);
    return keep;
}

static void every_request_is_accounted_for(void **state)
{
    (void)state;
    static const uint8_t data[N_BYTES] = {1, 2, 3};
    sheen_libcamera_frames f;
    sheen_frame frame;
    begin(&f, V4L2_PIX_FMT_GREY);
    assert_true(finish(&f, &frame, 5, data, N_BYTES)); // what came before it is not missing
    assert_int_equal(frame.info.sequence, 5);
    assert_int_equal(frame.info.t_ns, 7000);
    assert_close(frame.info.pipeline.red_gain, 1.5, 0);
    assert_string_equal(frame.extension, "raw");
    assert_string_equal(frame.info.source, "libcamera:/base/cam");
    assert_string_equal(frame.info.device, "Camera (/base/cam)");
    assert_int_equal(frame.info.lock, SHEEN_LOCK_OFF);
    assert_ptr_equal(frame.data, data);
    assert_int_equal(frame.size_bytes, N_BYTES);
    assert_true(finish(&f, &frame, 8, data, N_BYTES));
    assert_false(finish(&f, &frame, 7, data, N_BYTES));
    assert_false(finish(&f, &frame, 9, data, N_BYTES - 1));
    assert_false(sheen_libcamera_frames_turn(&f, 10, false));
    f.begun = false; // the stream was started again
    assert_true(finish(&f, &frame, 0, data, N_BYTES));
    assert_int_equal(f.counts.n_frames, 3);
    assert_int_equal(f.counts.n_dropped, 2);
    assert_int_equal(f.counts.n_late, 1);
    assert_int_equal(f.counts.n_short, 1);
    assert_int_equal(f.counts.n_flagged, 1);
    assert_int_equal(f.counts.n_unlocked, 0);
}

static void jpegs_need_their_end(void **state)
{
    (void)state;
    static const uint8_t jpeg[] = {0xff, 0xd8, 0xff, 0xe0, 0, 2, 0xff, 0xd9};
    sheen_libcamera_frames f;
    sheen_frame frame;
    begin(&f, 0);
    assert_true(finish(&f, &frame, 0, jpeg, sizeof jpeg));
    assert_string_equal(frame.extension, "jpg");
    assert_false(finish(&f, &frame, 1, jpeg, sizeof jpeg - 1));
    assert_int_equal(f.counts.n_short, 1);
}

static void frames_count_under_the_lock_only(void **state)
{
    (void)state;
    static const uint8_t data[N_BYTES] = {0};
    static const sheen_libcamera_abilities all = {true, true, true};
    sheen_libcamera_frames f;
    sheen_frame frame;
    sheen_err err;
    bool keep = false;
    begin(&f, V4L2_PIX_FMT_GREY);
    f.locked = true;
    f.lock.mains_hz = 50;
    assert_ok(sheen_libcamera_lock_begin(&f.lock, &all, "Camera", &err), err);
    assert_ok(sheen_libcamera_frames_describe(&f, "Camera", "0", "4x2", NULL, &err), err);
    assert_int_equal(f.info.lock, SHEEN_LOCK_HELD);
    int n = 0;
    while (!finish(&f, &frame, n, data, N_BYTES) && n < 40)
        n++;
    assert_in_range(n, 15, 30); // the automatics have had their time
    assert_int_equal(f.counts.n_frames, 1);
    assert_int_equal(f.counts.n_unlocked, 0);
    sheen_frame_pipeline strays = says;
    strays.exposure_us *= 1.1;
    assert_true(sheen_libcamera_frames_turn(&f, n + 1, true));
    frame = (sheen_frame){.data = data, .size_bytes = N_BYTES, .info.t_ns = 1};
    assert_ok(sheen_libcamera_frames_judge(&keep, &frame, &f, &strays, "Camera", &err), err);
    assert_false(keep);
    assert_int_equal(f.counts.n_unlocked, 1);
}

static void claims_are_checked_and_corrected(void **state)
{
    (void)state;
    sheen_libcamera_frames f;
    sheen_err err;
    begin(&f, V4L2_PIX_FMT_GREY);
    const sheen_transfer linear = SHEEN_TRANSFER_LINEAR;
    assert_ok(sheen_libcamera_frames_describe(&f, "Camera", "0", "4x2", &linear, &err), err);
    assert_int_equal(f.info.transfer, SHEEN_TRANSFER_LINEAR);
    f.info.stride_bytes = 1;
    assert_fails(sheen_libcamera_frames_describe(&f, "Camera", "0", "4x2-GREY", NULL, &err), err, SHEEN_EIO,
                 "4x2-GREY");
    sheen_v4l2_options o;
    assert_ok(sheen_v4l2_options_parse(&o, "0?colorspace=rec709&range=full", &err), err);
    sheen_colorimetry claim = {V4L2_COLORSPACE_SRGB, V4L2_XFER_FUNC_NONE, V4L2_YCBCR_ENC_601, 0};
    sheen_v4l2_options_color(&claim, &o);
    assert_int_equal(claim.colorspace, V4L2_COLORSPACE_REC709);
    assert_int_equal(claim.xfer_func, 0);
    assert_int_equal(claim.ycbcr_enc, 0);
    assert_int_equal(claim.quantization, V4L2_QUANTIZATION_FULL_RANGE);
}

enum { N_ROUNDS = 2000 };
static int letters[N_ROUNDS];

static void *deliver(void *inbox)
{
    for (int i = 0; i < N_ROUNDS; i++) {
        sheen_libcamera_inbox_put(inbox, &letters[i]);
        if (i % 16 == 15) // as a camera with few buffers does
            sheen_libcamera_inbox_sleep(inbox, 0);
    }
    sheen_libcamera_inbox_unplug(inbox);
    return NULL;
}

static void requests_come_in_order_from_another_thread(void **state)
{
    (void)state;
    sheen_libcamera_inbox *inbox;
    sheen_err err;
    void *request = NULL;
    pthread_t thread;
    assert_ok(sheen_libcamera_inbox_open(&inbox, &err), err);
    assert_int_equal(pthread_create(&thread, NULL, deliver, inbox), 0);
    int *last = NULL;
    sheen_status s;
    while (
        !(s = sheen_libcamera_inbox_take(inbox, sheen_clock_ns() + 20000000000, "Camera", &request, &err))) {
        assert_true(!last || (int *)request > last); // a full inbox takes no more
        last = request;
    }
    assert_fails(s, err, SHEEN_ENODEV, "gone"); // and only after all that were finished
    assert_non_null(last);
    pthread_join(thread, NULL);
    assert_true(sheen_libcamera_inbox_is_unplugged(inbox));
    sheen_libcamera_inbox_clear(inbox);
    assert_false(sheen_libcamera_inbox_is_unplugged(inbox));
    assert_fails(sheen_libcamera_inbox_take(inbox, sheen_clock_ns() + 1000000, "Camera", &request, &err), err,
                 SHEEN_ETIMEOUT, "cable");
    sheen_libcamera_inbox_put(inbox, &letters[0]);
    sheen_libcamera_inbox_stop(inbox); // comes first
    assert_fails(sheen_libcamera_inbox_take(inbox, INT64_MAX, "Camera", &request, &err), err, SHEEN_ECANCEL,
                 "stopped");
    sheen_libcamera_inbox_close(&inbox);
    assert_null(inbox);
    sheen_libcamera_inbox_close(&inbox);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_request_is_accounted_for),
        cmocka_unit_test(jpegs_need_their_end),
        cmocka_unit_test(frames_count_under_the_lock_only),
        cmocka_unit_test(claims_are_checked_and_corrected),
        cmocka_unit_test(requests_come_in_order_from_another_thread),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// SPDX-License-Identifier: Apache-2.0
// test_libcamera_lock.c - which requests of a libcamera camera are kept, told by what they say of themselves.
#include "capture/libcamera_lock.h"

#include <string.h>

#include "tests/support.h"

// A camera with a sensor of rows and steps of gain, whose settings reach the picture `lag` requests later.
typedef struct pipeline {
    sheen_frame_pipeline now, coming[8];
    int lag;
} pipeline;

static const sheen_frame_pipeline found = {.exposure_us = 14700,
                                           .analogue_gain = 2.03,
                                           .digital_gain = 1.01,
                                           .red_gain = 1.6,
                                           .blue_gain = 2.1,
                                           .black_levels = {4096, 4096, 4096, 4096}};

static sheen_status request(bool *keep, pipeline *p, sheen_libcamera_lock *lock, sheen_err *err)
{
    p->now = p->lag ? p->coming[0] : p->coming[7];
    for (int i = 0; i < 7; i++)
        p->coming[i] = p->coming[i + 1];
    const sheen_status s = sheen_libcamera_lock_frame(keep, lock, &p->now, "cam", err);
    if (!s && lock->phase != SHEEN_LIBCAMERA_WARM_UP) {
        p->coming[p->lag ? p->lag - 1 : 7] = lock->want;
        for (int i = p->lag; i < 8; i++)
            p->coming[i] = lock->want;
        for (int i = 0; i < 8; i++) // whole rows of 18.5 us
            p->coming[i].exposure_us = (double)(int)(p->coming[i].exposure_us / 18.5) * 18.5;
    }
    return s;
}

static void begin(pipeline *p, sheen_libcamera_lock *lock, int lag)
{
    const sheen_libcamera_abilities all = {true, true, true};
    sheen_err err;
    *p = (pipeline){.lag = lag};
    for (int i = 0; i < 8; i++)
        p->coming[i] = found;
    *lock = (sheen_libcamera_lock){.mains_hz = 50};
    assert_ok(sheen_libcamera_lock_begin(lock, &all, "cam", &err), err);
}

static void frames_that_lag_behind_the_settings_are_dropped(void **state)
{
    (void)state;
    for (int lag = 1; lag <= 6; lag++) {
        pipeline p;
        sheen_libcamera_lock lock;
        sheen_err err;
        int n_kept = 0;
        begin(&p, &lock, lag);
        for (int i = 0; i < 60; i++) {
            bool keep;
            assert_ok(request(&keep, &p, &lock, &err), err);
            n_kept += keep;
            if (keep) {
                assert_close(p.now.exposure_us, 10000, 19); // one half period of the lamps, in rows
                assert_close(p.now.analogue_gain, 2.03 * 14700 / 10000, 1e-9);
            }
        }
        assert_int_equal(n_kept, 60 - 15 - lag + 1);
    }
}

static void one_that_strays_is_dropped_and_many_end_it(void **state)
{
    (void)state;
    pipeline p;
    sheen_libcamera_lock lock;
    sheen_err err;
    bool keep = false;
    begin(&p, &lock, 1);
    while (!keep)
        assert_ok(request(&keep, &p, &lock, &err), err);
    const sheen_frame_pipeline held = lock.held;
    sheen_frame_pipeline other[5] = {held, held, held, held, held};
    other[0].exposure_us *= 1.01;
    other[1].analogue_gain *= 0.99;
    other[2].red_gain *= 1.02;
    other[3].blue_gain *= 1.02;
    other[4].digital_gain *= 1.1;
    for (int i = 0; i < 5; i++) {
        assert_ok(sheen_libcamera_lock_frame(&keep, &lock, &other[i], "cam", &err), err);
        assert_false(keep);
        assert_ok(sheen_libcamera_lock_frame(&keep, &lock, &held, "cam", &err), err);
        assert_true(keep);
    }
    sheen_status s = SHEEN_OK;
    for (int i = 0; i < 100 && !s; i++) {
        s = sheen_libcamera_lock_frame(&keep, &lock, &other[0], "cam", &err);
        assert_false(keep);
    }
    assert_fails(s, err, SHEEN_EDATA, "did not keep its settings");
}

static void a_mosaic_has_no_white_balance(void **state)
{
    (void)state;
    const sheen_libcamera_abilities no_colour = {true, true, false};
    sheen_libcamera_lock lock = {.is_raw = true, .exposure_s = 0.02};
    sheen_err err;
    assert_ok(sheen_libcamera_lock_begin(&lock, &no_colour, "cam", &err), err);
    sheen_frame_pipeline says = {.exposure_us = 14700, .analogue_gain = 1};
    bool keep = false;
    for (int i = 0; i < 15; i++)
        assert_ok(sheen_libcamera_lock_frame(&keep, &lock, &says, "cam", &err), err);
    assert_close(lock.want.exposure_us, 20000, 1e-6);
    says.exposure_us = 19980;
    assert_ok(sheen_libcamera_lock_frame(&keep, &lock, &says, "cam", &err), err);
    assert_true(keep);
}

static void what_cannot_be_proven_is_refused(void **state)
{
    (void)state;
    static const struct {
        sheen_libcamera_abilities can;
        const char *names;
    } cases[] = {{{false, true, true}, "its exposure"},
                 {{true, false, true}, "its gain"},
                 {{true, true, false}, "its white balance"}};
    sheen_libcamera_lock lock = {0};
    sheen_err err;
    for (size_t i = 0; i < 3; i++) {
        assert_fails(sheen_libcamera_lock_begin(&lock, &cases[i].can, "cam", &err), err, SHEEN_EUNSUP,
                     cases[i].names);
        assert_non_null(strstr(err.msg, "v4l2:"));
    }
    pipeline p;
    begin(&p, &lock, 1);
    const sheen_frame_pipeline silent = {0};
    sheen_status s = SHEEN_OK;
    bool keep;
    for (int i = 0; i < 15 && !s; i++)
        s = sheen_libcamera_lock_frame(&keep, &lock, &silent, "cam", &err);
    assert_fails(s, err, SHEEN_EUNSUP, "does not say");
}

static void a_camera_that_does_not_obey_is_given_up(void **state)
{
    (void)state;
    pipeline p;
    sheen_libcamera_lock lock;
    sheen_err err;
    bool keep;
    begin(&p, &lock, 1);
    sheen_status s = SHEEN_OK;
    for (int i = 0; i < 100 && !s; i++) {
        s = sheen_libcamera_lock_frame(&keep, &lock, &found, "cam", &err);
        assert_false(keep);
    }
    assert_fails(s, err, SHEEN_EDATA, "exposure_ms");
}

// Plugged in again: the same settings are asked for at once, and a frame counts only if it is as those before.
static void a_stream_that_begins_anew_has_the_same_lock(void **state)
{
    (void)state;
    static const sheen_libcamera_abilities all = {true, true, true};
    sheen_libcamera_lock lock = {.mains_hz = 50};
    sheen_err err;
    bool keep = false;
    assert_ok(sheen_libcamera_lock_begin(&lock, &all, "cam", &err), err);
    for (int i = 0; i < 15; i++)
        assert_ok(sheen_libcamera_lock_frame(&keep, &lock, &found, "cam", &err), err);
    sheen_frame_pipeline locked = lock.want;
    locked.exposure_us += 10; // what the sensor makes of it
    assert_ok(sheen_libcamera_lock_frame(&keep, &lock, &locked, "cam", &err), err);
    assert_true(keep);
    const sheen_frame_pipeline want = lock.want;
    assert_ok(sheen_libcamera_lock_begin(&lock, &all, "cam", &err), err);
    assert_int_equal(lock.phase, SHEEN_LIBCAMERA_SETTLE);
    assert_close(lock.want.exposure_us, want.exposure_us, 0);
    sheen_frame_pipeline other = locked;
    other.exposure_us += 40; // near the wish, but not what it was before
    assert_ok(sheen_libcamera_lock_frame(&keep, &lock, &other, "cam", &err), err);
    assert_false(keep);
    assert_ok(sheen_libcamera_lock_frame(&keep, &lock, &locked, "cam", &err), err);
    assert_true(keep);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_that_lag_behind_the_settings_are_dropped),
        cmocka_unit_test(one_that_strays_is_dropped_and_many_end_it),
        cmocka_unit_test(a_mosaic_has_no_white_balance),
        cmocka_unit_test(what_cannot_be_proven_is_refused),
        cmocka_unit_test(a_camera_that_does_not_obey_is_given_up),
        cmocka_unit_test(a_stream_that_begins_anew_has_the_same_lock),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

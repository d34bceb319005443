// SPDX-License-Identifier: Apache-2.0
// test_camera_parts.c - what a camera says of itself, who holds it, when its picture rests, and when the light changed.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <linux/videodev2.h>

#include "capture/devices.h"
#include "capture/drift.h"
#include "capture/settle.h"
#include "capture/v4l2_error.h"
#include "capture/v4l2_options.h"
#include "tests/fake/fake_v4l2.h"
#include "tests/support.h"

static void a_camera_says_what_it_can_do(void **state)
{
    (void)state;
    fake_v4l2 f;
    fake_v4l2_init(&f);
    sheen_device *d = calloc(1, sizeof *d);
    snprintf(d->path, sizeof d->path, "/dev/video0");
    assert_true(sheen_device_ask(d, &f.io));
    assert_int_equal(d->status, SHEEN_OK);
    assert_string_equal(d->name, "Fake Camera (usb-0000:00:14.0-1)");
    assert_int_equal(d->n_modes, 1);
    assert_string_equal(d->modes[0].format, "RGB3");
    assert_true(d->modes[0].width_px == 32 && d->modes[0].height_px == 24 && d->modes[0].recorded);
    assert_int_equal(d->modes[0].n_rates, 1);
    assert_close(d->modes[0].rates_hz[0], 30, 0.01);
    assert_int_equal(d->controls.n_controls, 9); // the heading of their class is none
    const sheen_v4l2_control *c = sheen_v4l2_controls_find(&d->controls, V4L2_CID_EXPOSURE_ABSOLUTE);
    assert_non_null(c);
    assert_string_equal(c->name, "Exposure_Time,_Absolute");
    assert_true(c->min == 1 && c->max == 5000 && c->value == 157 && c->inactive && !c->read_only);
    assert_true(fake_v4l2_is_clean(&f));
    sheen_devices_release(d, 1);
}

static void nodes_that_are_no_camera_are_left_out_and_busy_ones_told(void **state)
{
    (void)state;
    fake_v4l2 f;
    sheen_device d = {.path = "/dev/video0"};
    fake_v4l2_init(&f);
    f.faults.no_capture = true;
    assert_false(sheen_device_ask(&d, &f.io));
    fake_v4l2_init(&f);
    f.faults.fail_call = 1;
    f.faults.fail_errno = 13; // EACCES
    assert_true(sheen_device_ask(&d, &f.io));
    assert_int_equal(d.status, SHEEN_EACCESS);
    assert_non_null(strstr(d.problem, "video"));
}

static void devices_of_this_machine_can_be_listed(void **state)
{
    (void)state;
    sheen_device *devices;
    size_t n;
    sheen_err err;
    assert_ok(sheen_devices_list(&devices, &n, &err), err);
    for (size_t i = 0; i < n; i++)
        assert_true(!strncmp(devices[i].path, "/dev/video", 10));
    sheen_devices_release(devices, n);
}

// A child has the file open and waits until it is killed by the end of its input.
static void the_program_that_holds_a_file_is_named(void **state)
{
    char path[TEST_PATH_MAX], holder[96], number[32], c = 0;
    int hold[2], ready[2];
    test_scratch_file(path, *state, "node");
    test_file_write_text(path, "x");
    sheen_v4l2_holder(holder, sizeof holder, path, "/proc");
    assert_string_equal(holder, "");
    assert_true(!pipe(hold) && !pipe(ready));
    const pid_t child = fork();
    assert_true(child >= 0);
    if (!child) {
        close(hold[1]);
        FILE *f = fopen(path, "r");
        const char answer = f ? 'y' : 'n';
        if (write(ready[1], &answer, 1) == 1)
            while (read(hold[0], &c, 1) > 0)
                continue;
        _exit(0);
    }
    assert_true(read(ready[0], &c, 1) == 1 && c == 'y');
    sheen_v4l2_holder(holder, sizeof holder, path, "/proc");
    snprintf(number, sizeof number, "(process %ld)", (long)child);
    close(hold[1]);
    assert_true(waitpid(child, NULL, 0) == child);
    assert_non_null(strstr(holder, number));
    sheen_v4l2_holder(holder, sizeof holder, "/no/such/file", "/proc");
    assert_string_equal(holder, "");
    close(hold[0]);
    close(ready[0]);
    close(ready[1]);
}

static void the_light_may_vary_a_little_only(void **state)
{
    (void)state;
    static const float first[3] = {0.5f, 0.5f, 0.4f};
    static const struct {
        float rgb[3];
        const char *says; // NULL: fine
    } cases[] = {
        {{0.5f, 0.5f, 0.4f}, NULL},
        {{0.42f, 0.42f, 0.336f}, NULL},
        {{0.6f, 0.6f, 0.48f}, NULL},
        {{0.52f, 0.5f, 0.4f}, NULL},
        {{0.35f, 0.35f, 0.28f}, "30 % darker"},
        {{0.7f, 0.7f, 0.56f}, "40 % brighter"},
        {{0.55f, 0.5f, 0.4f}, "red"},
        {{0.5f, 0.5f, 0.36f}, "blue"},
        {{0, 0, 0}, "darker"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        sheen_drift d = {0};
        sheen_err err;
        assert_ok(sheen_drift_check(&d, first, &err), err);
        if (cases[i].says)
            assert_fails(sheen_drift_check(&d, cases[i].rgb, &err), err, SHEEN_EDATA, cases[i].says);
        else
            assert_ok(sheen_drift_check(&d, cases[i].rgb, &err), err);
    }
}

static void a_picture_rests_when_its_last_frames_agree(void **state)
{
    (void)state;
    sheen_settle s = {0};
    int n = 0;
    // It changes once, at the eighth frame.
    for (bool rests = false; !rests; n++) {
        const float level = n < 7 ? 0.2f : 0.4f;
        const float rgb[3] = {level, level, level};
        rests = sheen_settle_add(&s, rgb);
        assert_true(n < 20);
    }
    assert_int_equal(n, 7 + SHEEN_SETTLE_STILL);
    assert_close(sheen_settle_spread(&s), 0, 1e-6);
    const float other[3] = {0.4f, 0.4f, 0.42f};
    assert_false(sheen_settle_add(&s, other));
    assert_close(sheen_settle_spread(&s), 0.02 / 0.422, 1e-4);
}

static void the_mean_is_of_linear_light(void **state)
{
    (void)state;
    sheen_raster r;
    sheen_err err;
    float rgb[3];
    assert_ok(sheen_raster_init(&r, 2, 2, 3, 8, &err), err);
    static const uint8_t data[12] = {0, 128, 255, 255, 128, 255, 0, 128, 255, 255, 128, 255};
    memcpy(r.data, data, sizeof data);
    sheen_settle_mean(rgb, &r, SHEEN_TRANSFER_LINEAR);
    assert_close(rgb[0], 0.5, 1e-6);
    assert_close(rgb[1], 128 / 255.0, 1e-6);
    sheen_settle_mean(rgb, &r, SHEEN_TRANSFER_SRGB);
    assert_close(rgb[0], 0.5, 1e-6);
    assert_close(rgb[1], 0.2158605, 1e-6);
    assert_close(rgb[2], 1, 1e-6);
    sheen_raster_release(&r);
}

static void a_uri_is_read_with_all_its_options(void **state)
{
    (void)state;
    sheen_v4l2_options o;
    sheen_err err;
    assert_ok(sheen_v4l2_options_parse(
                  &o,
                  "/dev/v4l/by-id/usb-cam?format=Y16&size=640x480&rate=15&exposure_ms=8.33&mains=60&"
                  "lock=off&transfer=linear&matrix=709&range=full",
                  &err),
              err);
    assert_string_equal(o.path, "/dev/v4l/by-id/usb-cam");
    assert_int_equal(o.fourcc, V4L2_PIX_FMT_Y16);
    assert_true(o.width_px == 640 && o.height_px == 480 && o.mains_hz == 60 && !o.lock && o.set_transfer);
    assert_close(o.rate_hz, 15, 0);
    assert_int_equal(o.ycbcr_enc, V4L2_YCBCR_ENC_709);
    assert_int_equal(o.quantization, V4L2_QUANTIZATION_FULL_RANGE);
    assert_close(o.exposure_s, 0.00833, 1e-12);
    assert_int_equal(o.transfer, SHEEN_TRANSFER_LINEAR);
    assert_ok(sheen_v4l2_options_parse(&o, "/dev/video0", &err), err);
    assert_true(o.lock && o.mains_hz == 50 && !o.fourcc && !o.set_transfer);
}

#define WITH_SCRATCH(f) cmocka_unit_test_setup_teardown(f, test_scratch_setup, test_scratch_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_camera_says_what_it_can_do),
        cmocka_unit_test(nodes_that_are_no_camera_are_left_out_and_busy_ones_told),
        cmocka_unit_test(devices_of_this_machine_can_be_listed),
        WITH_SCRATCH(the_program_that_holds_a_file_is_named),
        cmocka_unit_test(the_light_may_vary_a_little_only),
        cmocka_unit_test(a_picture_rests_when_its_last_frames_agree),
        cmocka_unit_test(the_mean_is_of_linear_light),
        cmocka_unit_test(a_uri_is_read_with_all_its_options),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

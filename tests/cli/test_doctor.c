// SPDX-License-Identifier: Apache-2.0
// test_doctor.c - the doctor finds what was made wrong, and nothing where all is well.
#include "cli/doctor.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <linux/videodev2.h>

#include "base/session.h"
#include "tests/support.h"

// What was found of that severity that contains `part`.
static size_t count(const sheen_cli_findings *f, sheen_cli_severity severity, const char *part)
{
    size_t n = 0;
    for (size_t i = 0; i < f->n_findings; i++)
        n += f->findings[i].severity == severity && strstr(f->findings[i].text, part) != NULL;
    return n;
}

static sheen_v4l2_mode yuyv = {.fourcc = V4L2_PIX_FMT_YUYV, .recorded = true};
static sheen_v4l2_mode mjpg = {.fourcc = V4L2_PIX_FMT_MJPEG, .recorded = true};
static sheen_v4l2_control controls[] = {
    {.id = V4L2_CID_EXPOSURE_AUTO, .min = 0, .max = 3},
    {.id = V4L2_CID_EXPOSURE_ABSOLUTE, .min = 1, .max = 5000},
};

static sheen_device good_camera(void)
{
    return (sheen_device){.path = "/dev/video0",
                          .by_id = "/dev/v4l/by-id/a",
                          .modes = &yuyv,
                          .n_modes = 1,
                          .controls = {controls, 2}};
}

static void cameras_are_told_apart_by_what_is_wrong(void **state)
{
    (void)state;
    sheen_device d[5] = {good_camera(), good_camera(), good_camera(), good_camera(), good_camera()};
    sheen_cli_findings f = {0};
    sheen_cli_check_cameras(&f, d, 1);
    assert_true(f.n_findings == 1 && !f.n_wrong);
    d[1].status = SHEEN_EACCESS;
    snprintf(d[1].problem, sizeof d[1].problem, "no permission; join the group");
    d[2].modes = &mjpg;
    d[3].controls.n_controls = 1;
    d[3].n_modes = 0;
    d[4].is_usb = true;
    d[4].usb_bus = d[4].usb_address = 999;
    snprintf(d[4].usb_speed, sizeof d[4].usb_speed, "12 Mbit/s");
    d[4].by_id[0] = 0;
    f = (sheen_cli_findings){0};
    sheen_cli_check_cameras(&f, d, 5);
    assert_int_equal(count(&f, SHEEN_CLI_WRONG, "no permission"), 1);
    assert_int_equal(count(&f, SHEEN_CLI_NOTE, "JPEG only"), 1);
    assert_int_equal(count(&f, SHEEN_CLI_WRONG, "no control of its exposure"), 1);
    assert_int_equal(count(&f, SHEEN_CLI_WRONG, "can be recorded"), 1);
    assert_int_equal(count(&f, SHEEN_CLI_WRONG, "fallen back to 12 Mbit/s"), 1);
    assert_int_equal(count(&f, SHEEN_CLI_NOTE, "cannot be reset"), 1);
    assert_int_equal(count(&f, SHEEN_CLI_NOTE, "lasting name"), 1);
    assert_int_equal(count(&f, SHEEN_CLI_NOTE, "same serial number"), 2);
    assert_int_equal(f.n_wrong, 4);
}

static void put(const test_scratch *scratch, const char *dir, const char *name, const char *text)
{
    char path[TEST_PATH_MAX], folder[TEST_PATH_MAX];
    sheen_err err;
    test_scratch_file(folder, scratch, dir);
    assert_ok(sheen_dir_make(folder, &err), err);
    snprintf(path, sizeof path, "%.400s/%s", folder, name);
    test_file_write_text(path, text);
}

static void a_machine_is_read_from_its_files(void **state)
{
    const test_scratch *scratch = *state;
    sheen_cli_findings f = {0};
    put(scratch, "sys/bus/usb/devices/1-1:1.0", "bInterfaceClass", "0e\n");
    put(scratch, "proc/77", "comm", "ModemManager\n");
    put(scratch, "proc", "meminfo", "MemTotal: 9000000 kB\nMemAvailable:  500000 kB\n");
    sheen_cli_check_machine(&f, scratch->path, 0);
    assert_int_equal(count(&f, SHEEN_CLI_WRONG, "modprobe uvcvideo"), 1);
    assert_int_equal(count(&f, SHEEN_CLI_NOTE, "udevd does not run"), 1);
    assert_int_equal(count(&f, SHEEN_CLI_NOTE, "serial port"), 1);
    assert_int_equal(count(&f, SHEEN_CLI_NOTE, "500 MB are free"), 1);
    put(scratch, "sys/bus/usb/drivers/uvcvideo", "x", "");
    put(scratch, "run/udev", "control", "");
    put(scratch, "etc/udev/rules.d", "60-sheen.rules", "");
    f = (sheen_cli_findings){0};
    sheen_cli_check_machine(&f, scratch->path, 1);
    assert_true(!f.n_wrong && count(&f, SHEEN_CLI_FINE, "rules are installed") == 1);
    assert_int_equal(count(&f, SHEEN_CLI_NOTE, "serial port"), 0);
}

static void a_session_with_a_damaged_frame_is_told(void **state)
{
    char dir[TEST_PATH_MAX], payload[TEST_PATH_MAX];
    sheen_session s;
    sheen_frame_info info;
    sheen_err err;
    sheen_cli_findings f = {0};
    test_scratch_file(dir, *state, "s");
    assert_ok(sheen_session_create(&s, dir, SHEEN_MOVING_CAMERA, &err), err);
    sheen_frame_info_init(&info);
    snprintf(info.name, sizeof info.name, "a");
    info.width_px = info.height_px = 1;
    info.lock = SHEEN_LOCK_OFF;
    assert_ok(sheen_session_add_frame(&s, &info, "raw", "x", 1, &err), err);
    sheen_session_release(&s);
    sheen_cli_check_session(&f, dir);
    assert_true(!f.n_wrong && count(&f, SHEEN_CLI_NOTE, "without the lock") == 1);
    snprintf(payload, sizeof payload, "%.400s/frames/a.raw", dir);
    test_file_write_text(payload, "y");
    sheen_cli_check_session(&f, dir);
    assert_int_equal(count(&f, SHEEN_CLI_WRONG, "the first is 'a'"), 1);
    sheen_cli_check_disk(&f, dir);
    assert_true(count(&f, SHEEN_CLI_FINE, "MB/s") + count(&f, SHEEN_CLI_NOTE, "MB/s") == 1);
    sheen_cli_check_disk(&f, "/nowhere");
    assert_int_equal(count(&f, SHEEN_CLI_WRONG, "/nowhere"), 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cameras_are_told_apart_by_what_is_wrong),
        cmocka_unit_test_setup_teardown(a_machine_is_read_from_its_files, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(a_session_with_a_damaged_frame_is_told, test_scratch_setup,
                                        test_scratch_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

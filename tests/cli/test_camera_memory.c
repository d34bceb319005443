// SPDX-License-Identifier: Apache-2.0
// test_camera_memory.c - what is remembered of cameras that claim wrong colours.
#include "cli/camera_memory.h"

#include <string.h>

#include "tests/support.h"

static void a_camera_is_known_again(void **state)
{
    char file[TEST_PATH_MAX], options[SHEEN_CLI_OPTIONS_MAX];
    sheen_err err;
    test_scratch_file(file, *state, "cameras.json");
    assert_ok(sheen_cli_camera_recall(options, file, "046d:0825 A1", "Webcam", &err), err);
    assert_string_equal(options, "");
    assert_ok(sheen_cli_camera_remember(file, "046d:0825", "transfer=srgb&range=full", &err), err);
    assert_ok(sheen_cli_camera_remember(file, "Other Camera", "matrix=709", &err), err);
    assert_ok(sheen_cli_camera_recall(options, file, "046d:0825 A1", "Webcam", &err), err);
    assert_string_equal(options, "transfer=srgb&range=full");
    assert_ok(sheen_cli_camera_recall(options, file, "", "Other Camera", &err), err);
    assert_string_equal(options, "matrix=709");
    assert_ok(sheen_cli_camera_recall(options, file, "046d:0826", "", &err), err);
    assert_string_equal(options, "");
    // Another word replaces the first one, none removes it.
    assert_ok(sheen_cli_camera_remember(file, "046d:0825", "range=limited", &err), err);
    assert_ok(sheen_cli_camera_recall(options, file, "046d:0825 A1", "", &err), err);
    assert_string_equal(options, "range=limited");
    assert_ok(sheen_cli_camera_remember(file, "046d:0825", "", &err), err);
    assert_ok(sheen_cli_camera_recall(options, file, "046d:0825 A1", "", &err), err);
    assert_string_equal(options, "");
}

static void only_claims_are_remembered(void **state)
{
    char file[TEST_PATH_MAX], options[SHEEN_CLI_OPTIONS_MAX];
    sheen_err err;
    sheen_cli_camera_claims(options, "v4l2:/dev/video0?size=640x480&colorspace=rec709&lock=off&range=full");
    assert_string_equal(options, "colorspace=rec709&range=full");
    sheen_cli_camera_claims(options, "v4l2:/dev/video0");
    assert_string_equal(options, "");
    test_scratch_file(file, *state, "cameras.json");
    test_file_write_text(file, "{\"schema\": \"sheen-cameras/1\", \"cameras\": [{\"camera\": \"1:2\", "
                               "\"options\": \"lock=off&matrix=601\"}]}");
    assert_ok(sheen_cli_camera_recall(options, file, "1:2", "", &err), err);
    assert_string_equal(options, "matrix=601");
    test_file_write_text(file, "{");
    assert_fails(sheen_cli_camera_recall(options, file, "1:2", "", &err), err, SHEEN_EFORMAT, "cameras.json");
}

// A camera that is known to the program; what the person says of it counts instead, were it nothing.
static void a_known_camera_is_put_right_unless_told_otherwise(void **state)
{
    char file[TEST_PATH_MAX], options[SHEEN_CLI_OPTIONS_MAX];
    sheen_err err;
    test_scratch_file(file, *state, "cameras.json");
    assert_ok(sheen_cli_camera_recall(options, file, "0c45:6366 SN0001", "Arducam OV9281 USB Camera", &err),
              err);
    assert_string_equal(options, "exposure_most_ms=7.5");
    assert_ok(sheen_cli_camera_recall(options, file, "0c45:6366", "USB Camera", &err), err); // another chip
    assert_string_equal(options, "");
    assert_ok(sheen_cli_camera_recall(options, file, "045e:0810", "Microsoft LifeCam HD-3000", &err), err);
    assert_non_null(strstr(options, "exposures_ms="));
    test_file_write_text(file, "{\"schema\": \"sheen-cameras/1\", \"cameras\": [{\"camera\": \"0c45:6366\", "
                               "\"options\": \"\"}]}");
    assert_ok(sheen_cli_camera_recall(options, file, "0c45:6366 SN0001", "Arducam OV9281 USB Camera", &err),
              err);
    assert_string_equal(options, "");
    assert_ok(sheen_cli_camera_remember(file, "0c45:6366", "exposure_most_ms=33", &err), err);
    assert_ok(sheen_cli_camera_recall(options, file, "0c45:6366 SN0001", "Arducam OV9281 USB Camera", &err),
              err);
    assert_string_equal(options, "exposure_most_ms=33");
}

#define WITH_SCRATCH(f) cmocka_unit_test_setup_teardown(f, test_scratch_setup, test_scratch_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_SCRATCH(a_camera_is_known_again),
        WITH_SCRATCH(only_claims_are_remembered),
        WITH_SCRATCH(a_known_camera_is_put_right_unless_told_otherwise),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

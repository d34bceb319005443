// SPDX-License-Identifier: Apache-2.0
// test_session_arg.c - a failed command takes its new session back, but nothing that another one put there.
#include <string.h>

#include "cli/cli.h"
#include "tests/support.h"

static void make(sheen_cli_session *c, char path[TEST_PATH_MAX], void **state)
{
    sheen_err err;
    test_scratch_file(path, *state, "new.session");
    assert_ok(sheen_cli_session_create(c, path, SHEEN_MOVING_CAMERA, &err), err);
    assert_true(c->fresh && c->fresh_dir);
}

static void an_empty_session_is_taken_back(void **state)
{
    char path[TEST_PATH_MAX], payload[SHEEN_PATH_MAX];
    sheen_cli_session c;
    sheen_err err;
    make(&c, path, state);
    assert_ok(sheen_session_path(payload, &c.session, "frames/a.png", &err), err);
    test_file_write_text(payload, "of a frame that was never finished");
    sheen_cli_session_close(&c, true);
    assert_false(sheen_dir_exists(path));
}

static void what_another_command_recorded_stays(void **state)
{
    static const char *const files[] = {"frames/a.json", "mesh.ply"};
    for (size_t i = 0; i < 2; i++) {
        char path[TEST_PATH_MAX], file[SHEEN_PATH_MAX];
        sheen_cli_session c;
        sheen_err err;
        make(&c, path, state);
        assert_ok(sheen_session_path(file, &c.session, files[i], &err), err);
        test_file_write_text(file, "whole");
        sheen_cli_session_close(&c, true);
        assert_true(sheen_file_exists(file));
        assert_ok(sheen_dir_remove(path, &err), err);
    }
}

static void an_older_session_stays(void **state)
{
    char path[TEST_PATH_MAX];
    sheen_cli_session c;
    sheen_err err;
    make(&c, path, state);
    sheen_cli_session_close(&c, false);
    assert_ok(sheen_cli_session_create(&c, path, SHEEN_MOVING_CAMERA, &err), err);
    sheen_cli_session_close(&c, true);
    assert_true(sheen_dir_exists(path));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(an_empty_session_is_taken_back, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(what_another_command_recorded_stays, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(an_older_session_stays, test_scratch_setup, test_scratch_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

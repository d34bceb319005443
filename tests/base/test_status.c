// SPDX-License-Identifier: Apache-2.0
// test_status.c - codes, sentences, and their wrapping.
#include <string.h>

#include "base/status.h"
#include "support.h"

static void every_code_has_a_text(void **state)
{
    (void)state;
    assert_string_equal(sheen_status_text(SHEEN_OK), "success");
    assert_string_equal(sheen_status_text(SHEEN_ECANCEL), "cancelled");
    assert_string_equal(sheen_status_text((sheen_status)99), "unknown status");
    assert_string_equal(sheen_status_text((sheen_status)-1), "unknown status");
}

static void fail_fills_and_returns(void **state)
{
    (void)state;
    sheen_err err;
    assert_int_equal(sheen_fail(&err, SHEEN_EIO, "cannot open '%s'", "x"), SHEEN_EIO);
    assert_int_equal(err.code, SHEEN_EIO);
    assert_string_equal(err.msg, "cannot open 'x'");
    assert_int_equal(sheen_fail(NULL, SHEEN_EIO, "nobody listens"), SHEEN_EIO);
}

static void wrap_puts_the_subject_first(void **state)
{
    (void)state;
    sheen_err err;
    sheen_fail(&err, SHEEN_EFORMAT, "no number 'fx'");
    assert_int_equal(sheen_wrap(&err, SHEEN_EFORMAT, "cannot read '%s'", "a.json"), SHEEN_EFORMAT);
    assert_string_equal(err.msg, "cannot read 'a.json': no number 'fx'");
    assert_int_equal(sheen_wrap(NULL, SHEEN_EIO, "x"), SHEEN_EIO);
}

static void long_sentences_are_cut_not_overrun(void **state)
{
    (void)state;
    sheen_err err;
    char text[2000];
    memset(text, 'x', sizeof text - 1);
    text[sizeof text - 1] = 0;
    sheen_fail(&err, SHEEN_EIO, "%s", text);
    assert_int_equal(strlen(err.msg), sizeof err.msg - 1);
    sheen_wrap(&err, SHEEN_EIO, "cannot do '%s'", "y");
    assert_true(!strncmp(err.msg, "cannot do 'y': xxx", 18));
    assert_true(strlen(err.msg) < sizeof err.msg);
    sheen_wrap(&err, SHEEN_EIO, "%s", text);
    assert_int_equal(strlen(err.msg), sizeof err.msg - 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_code_has_a_text),
        cmocka_unit_test(fail_fills_and_returns),
        cmocka_unit_test(wrap_puts_the_subject_first),
        cmocka_unit_test(long_sentences_are_cut_not_overrun),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// SPDX-License-Identifier: Apache-2.0
// test_support.c - the helpers themselves: what they accept, and that each of them can fail a test.
#include "tests/support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static sheen_status says(sheen_err *err, sheen_status code)
{
    err->code = code;
    snprintf(err->msg, sizeof err->msg, "cannot read 'a.json': it is empty");
    return code;
}

static void accepts(void **state)
{
    (void)state;
    sheen_err err = {0};
    assert_close(1.0 + 1e-9, 1, 1e-8);
    assert_close(NAN, NAN, 0);
    assert_close(INFINITY, INFINITY, 0);
    assert_ok(says(&err, SHEEN_OK), err);
    assert_fails(says(&err, SHEEN_EIO), err, SHEEN_EIO, "cannot read 'a.json'");
}

static void scratch_holds_files_until_it_goes(void **state)
{
    const test_scratch *scratch = *state;
    char path[TEST_PATH_MAX];
    test_scratch_file(path, scratch, "a.bin");
    test_file_write(path, "a\0b", 3);
    size_t size_bytes;
    uint8_t *data = test_file_read(path, &size_bytes);
    assert_int_equal(size_bytes, 3);
    assert_memory_equal(data, "a\0b", 4);
    free(data);

    test_scratch other;
    test_scratch_make(&other);
    assert_string_not_equal(other.path, scratch->path);
    char other_path[sizeof other.path];
    memcpy(other_path, other.path, sizeof other_path);
    test_scratch_file(path, &other, "b.txt");
    test_file_write_text(path, "");
    test_scratch_remove(&other);
    assert_int_not_equal(access(other_path, F_OK), 0);
}

static void random_numbers_have_their_moments(void **state)
{
    (void)state;
    enum { N = 100000 };
    uint64_t seed = 0;
    double sum = 0, normal_sum = 0, normal_sum2 = 0;
    for (int i = 0; i < N; i++) {
        const double u = test_random(&seed), g = test_random_normal(&seed);
        assert_true(u >= 0 && u < 1);
        sum += u;
        normal_sum += g;
        normal_sum2 += g * g;
    }
    assert_close(sum / N, 0.5, 0.005);
    assert_close(normal_sum / N, 0, 0.02);
    assert_close(normal_sum2 / N, 1, 0.03);
}

static void far_off(void **state)
{
    (void)state;
    assert_close(1.1, 1, 0.05);
}

static void not_a_number(void **state)
{
    (void)state;
    assert_close(NAN, 1, INFINITY);
}

static void not_ok(void **state)
{
    (void)state;
    sheen_err err;
    assert_ok(says(&err, SHEEN_EIO), err);
}

static void another_code(void **state)
{
    (void)state;
    sheen_err err;
    assert_fails(says(&err, SHEEN_EIO), err, SHEEN_EFORMAT, "cannot read");
}

static void another_sentence(void **state)
{
    (void)state;
    sheen_err err;
    assert_fails(says(&err, SHEEN_EIO), err, SHEEN_EIO, "no such camera");
}

static void no_file(void **state)
{
    (void)state;
    test_file_read("/nonexistent/a.json", NULL);
}

static void wants_what_is_not_here(void **state)
{
    (void)state;
    test_skip("needs what is not here");
    fail_msg("a skipped test went on");
}

int main(void)
{
    const struct CMUnitTest must_fail[] = {
        cmocka_unit_test(far_off),      cmocka_unit_test(not_a_number),     cmocka_unit_test(not_ok),
        cmocka_unit_test(another_code), cmocka_unit_test(another_sentence), cmocka_unit_test(no_file),
    };
    const int n_must_fail = (int)(sizeof must_fail / sizeof *must_fail);
    const int n_failed = cmocka_run_group_tests_name("tests that must fail", must_fail, NULL, NULL);
    if (n_failed != n_must_fail) {
        print_error("%d of %d tests failed that must fail\n", n_failed, n_must_fail);
        return 1;
    }
    const struct CMUnitTest skipped[] = {cmocka_unit_test(wants_what_is_not_here)};
    const int n_skipped_failed = cmocka_run_group_tests_name("a test that must skip", skipped, NULL, NULL);
    if (test_result(n_skipped_failed) != 77 || test_result(1) != 1) {
        print_error("a skipped test must be told from a passed and a failed one\n");
        return 1;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(accepts),
        cmocka_unit_test_setup_teardown(scratch_holds_files_until_it_goes, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test(random_numbers_have_their_moments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// SPDX-License-Identifier: Apache-2.0
// support.h - what every test starts with: cmocka, closeness of numbers, statuses, a scratch folder.
//
// cmocka 1.1.5 wants these headers before its own; this is the one place that knows.
// Data that come with the repository are found by name: SHEEN_TEST_DATA "/board.json".
#ifndef SHEEN_TESTS_SUPPORT_H
#define SHEEN_TESTS_SUPPORT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/status.h"

// |got - want| <= tolerance, else the test fails and says by how much. NaN is close to NaN only.
#define assert_close(got, want, tolerance)                                                                   \
    test_assert_close((double)(got), (double)(want), (double)(tolerance), #got, __FILE__, __LINE__)
void test_assert_close(double got, double want, double tolerance, const char *what, const char *file,
                       int line);

// The call returned SHEEN_OK, else the test fails with the sentence in `err` (a sheen_err, not a pointer):
//     assert_ok(sheen_board_load(&board, path, &err), err);
#define assert_ok(call, err) test_assert_ok((call), &(err), #call, __FILE__, __LINE__)
void test_assert_ok(sheen_status got, const sheen_err *err, const char *what, const char *file, int line);

// The call failed with this code, and the sentence in `err` carries that code and contains `part`.
#define assert_fails(call, err, code, part)                                                                  \
    test_assert_fails((call), &(err), (code), (part), #call, __FILE__, __LINE__)
void test_assert_fails(sheen_status got, const sheen_err *err, sheen_status want, const char *part,
                       const char *what, const char *file, int line);

// Ends the test as skipped, with the reason; test_result of the group's failures then lets CTest count the program as
// skipped where none failed:
//     return test_result(cmocka_run_group_tests(tests, NULL, NULL));
void test_skip(const char *reason);
int test_result(int n_failed);

// A scratch folder of this process alone. As a cmocka fixture:
//     cmocka_unit_test_setup_teardown(writes_a_file, test_scratch_setup, test_scratch_teardown)
// and in the test `const test_scratch *scratch = *state;`.
enum { TEST_PATH_MAX = 512 };
typedef struct test_scratch {
    char path[256];
} test_scratch;

void test_scratch_make(test_scratch *scratch);
void test_scratch_remove(test_scratch *scratch); // with all in it
void test_scratch_file(char out[TEST_PATH_MAX], const test_scratch *scratch, const char *name);
int test_scratch_setup(void **state);
int test_scratch_teardown(void **state);

// Whole files; the test fails where that cannot be done. Read: caller frees, a NUL follows the last byte.
uint8_t *test_file_read(const char *path, size_t *size_bytes_out);
void test_file_write(const char *path, const void *data, size_t size_bytes);
void test_file_write_text(const char *path, const char *text);

// Repeatable random numbers: any seed, also 0. Uniform in [0, 1), and normal with sigma 1.
double test_random(uint64_t *seed);
double test_random_normal(uint64_t *seed);

#endif

// SPDX-License-Identifier: Apache-2.0
// test_text.c - a text written piece by piece: pieces of any length arrive whole, and in order.
#include "support.h"

#include <stdlib.h>
#include <string.h>

#include "base/text.h"

static void pieces_of_any_length_arrive_whole(void **state)
{
    const test_scratch *scratch = *state;
    char path[TEST_PATH_MAX], want[4 * 4096];
    test_scratch_file(path, scratch, "a.txt");
    sheen_text t = {0};
    sheen_err err;
    size_t n = 0;
    for (int length = 500; length < 3000;
         length = length * 3 / 2) { // around what is formatted without memory, and beyond
        memset(want + n, 'a' + length % 26, (size_t)length);
        sheen_text_put(&t, "%.*s|", length, want + n);
        n += (size_t)length;
        want[n++] = '|';
    }
    sheen_text_append(&t, "end", 3);
    memcpy(want + n, "end", 4);
    assert_string_equal(sheen_text_string(&t), want);
    sheen_text_append(&t, "!", 1); // reading it does not end it
    assert_ok(sheen_text_save(&t, path, &err), err);
    size_t size_bytes;
    char *file = (char *)test_file_read(path, &size_bytes);
    assert_int_equal(size_bytes, n + 4);
    assert_memory_equal(file, want, n + 3);
    assert_int_equal(file[n + 3], '!');
    free(file);
    assert_null(t.bytes.data);
}

static void an_empty_text_is_an_empty_file(void **state)
{
    const test_scratch *scratch = *state;
    char path[TEST_PATH_MAX];
    test_scratch_file(path, scratch, "empty.txt");
    sheen_text t = {0};
    sheen_err err;
    assert_string_equal(sheen_text_string(&t), "");
    assert_ok(sheen_text_save(&t, path, &err), err);
    size_t size_bytes;
    free(test_file_read(path, &size_bytes));
    assert_int_equal(size_bytes, 0);
}

static void what_did_not_fit_is_told_at_the_end(void **state)
{
    const test_scratch *scratch = *state;
    char path[TEST_PATH_MAX];
    test_scratch_file(path, scratch, "b.txt");
    sheen_text t = {.failed = true};
    sheen_err err;
    sheen_text_put(&t, "%d", 7);
    assert_null(sheen_text_string(&t));
    assert_fails(sheen_text_save(&t, path, &err), err, SHEEN_ENOMEM, "out of memory while writing");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(pieces_of_any_length_arrive_whole, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(an_empty_text_is_an_empty_file, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(what_did_not_fit_is_told_at_the_end, test_scratch_setup,
                                        test_scratch_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

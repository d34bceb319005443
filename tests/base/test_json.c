// SPDX-License-Identifier: Apache-2.0
// test_json.c - reading and writing JSON: exact numbers, clear sentences, hostile text.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "base/json_write.h"
#include "support.h"

static sheen_json *parse(const char *text)
{
    sheen_err err;
    sheen_json *root;
    assert_ok(sheen_json_parse(&root, text, strlen(text), &err), err);
    return root;
}

static void written_numbers_read_back_exactly(void **state)
{
    (void)state;
    static const double x[] = {
        0, 1, -1, 0.1, 1.0 / 3, 3.14159265358979, 1e-300, 1.7976931348623157e308, 123456789.25};
    enum { N = sizeof x / sizeof *x };
    sheen_json_writer w = {0};
    sheen_json_open(&w, NULL, '{');
    sheen_json_put_numbers(&w, "x", x, N);
    sheen_json_put_number(&w, "nan", (double)NAN);
    sheen_json_put_string(&w, "text", "a \"quoted\" back\\slash\nline \x01 end");
    sheen_json_put_bool(&w, "yes", true);
    sheen_json_open(&w, "empty", '[');
    sheen_json_close(&w);
    sheen_json_open(&w, "list", '[');
    sheen_json_put_int(&w, NULL, -7);
    sheen_json_put_string(&w, NULL, NULL);
    sheen_json_close(&w);
    sheen_json_close(&w);
    sheen_json *root = parse(sheen_json_text(&w));
    double back[N];
    sheen_err err;
    const char *text;
    assert_ok(sheen_json_numbers(root, "x", back, N, &err), err);
    for (int i = 0; i < N; i++)
        assert_true(back[i] == x[i]);
    assert_false(sheen_json_is_number(sheen_json_get(root, "nan")));
    assert_ok(sheen_json_string(root, "text", &text, &err), err);
    assert_string_equal(text, "a \"quoted\" back\\slash\nline \x01 end");
    assert_int_equal(sheen_json_count(sheen_json_get(root, "empty")), 0);
    assert_int_equal(sheen_json_count(sheen_json_get(root, "list")), 2);
    assert_close(sheen_json_value_number(sheen_json_at(sheen_json_get(root, "list"), 0), 0), -7, 0);
    sheen_json_free(&root);
    assert_null(root);
    sheen_json_writer_release(&w);
}

static void says_what_is_missing(void **state)
{
    (void)state;
    sheen_err err;
    sheen_json *root = parse("{\"n\": 3.5, \"s\": \"x\", \"m\": [[1, 2], [3, 4]], \"mixed\": [1, \"a\"], "
                             "\"schema\": \"sheen-x/2\"}");
    double x[4];
    int i;
    bool b;
    const char *t;
    const sheen_json *list;
    assert_fails(sheen_json_number(root, "absent", x, &err), err, SHEEN_EFORMAT, "no number 'absent'");
    assert_fails(sheen_json_number(root, "s", x, &err), err, SHEEN_EFORMAT, "no number 's'");
    assert_fails(sheen_json_int(root, "n", 0, 9, &i, &err), err, SHEEN_EFORMAT,
                 "'n' is 3.5, not a whole number");
    assert_fails(sheen_json_string(root, "n", &t, &err), err, SHEEN_EFORMAT, "no text 'n'");
    assert_fails(sheen_json_bool(root, "n", &b, &err), err, SHEEN_EFORMAT, "no true or false 'n'");
    assert_fails(sheen_json_array(root, "n", &list, &err), err, SHEEN_EFORMAT, "no list 'n'");
    assert_fails(sheen_json_numbers(root, "m", x, 3, &err), err, SHEEN_EFORMAT, "'m' has 4 numbers, not 3");
    assert_fails(sheen_json_numbers(root, "mixed", x, 2, &err), err, SHEEN_EFORMAT,
                 "no list of 2 numbers 'mixed'");
    assert_ok(sheen_json_numbers(root, "m", x, 4, &err), err);
    assert_close(x[2], 3, 0);
    assert_ok(sheen_json_schema(root, "sheen-x", 2, &i, &err), err);
    assert_int_equal(i, 2);
    assert_fails(sheen_json_schema(root, "sheen-x", 1, &i, &err), err, SHEEN_EFORMAT,
                 "newer than this program");
    assert_fails(sheen_json_schema(root, "sheen-y", 2, &i, &err), err, SHEEN_EFORMAT,
                 "schema is 'sheen-x/2'");
    assert_null(sheen_json_get(NULL, "x"));
    assert_null(sheen_json_at(root, 0));
    sheen_json_free(&root);
}

static void refuses_what_is_not_json(void **state)
{
    (void)state;
    static const char *const texts[] = {"",      "{",   "[1,]",    "{\"a\": 1, \"a\": 2}",
                                        "{} {}", "NaN", "[1e999]", "{\"a\": \"\xff\"}"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        sheen_err err;
        sheen_json *root;
        assert_fails(sheen_json_parse(&root, texts[i], strlen(texts[i]), &err), err, SHEEN_EFORMAT,
                     "not valid JSON");
        assert_null(root);
    }
    const size_t n = 1 << 20; // a million brackets
    char *deep = malloc(n);
    assert_non_null(deep);
    memset(deep, '[', n);
    sheen_err err;
    sheen_json *root;
    assert_fails(sheen_json_parse(&root, deep, n, &err), err, SHEEN_EFORMAT, "not valid JSON");
    free(deep);
}

static void names_the_file(void **state)
{
    char path[TEST_PATH_MAX];
    sheen_err err;
    sheen_json *root;
    test_scratch_file(path, *state, "x.json");
    assert_fails(sheen_json_load(&root, path, &err), err, SHEEN_EIO, "cannot open '");
    test_file_write_text(path, "{");
    assert_fails(sheen_json_load(&root, path, &err), err, SHEEN_EFORMAT, "x.json': not valid JSON");
    sheen_json_writer w = {0};
    sheen_json_open(&w, NULL, '{');
    sheen_json_put_int(&w, "a", 1);
    sheen_json_close(&w);
    assert_ok(sheen_json_save(&w, path, &err), err);
    assert_null(w.text.bytes.data);
    assert_ok(sheen_json_load(&root, path, &err), err);
    sheen_json_free(&root);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(written_numbers_read_back_exactly),
        cmocka_unit_test(says_what_is_missing),
        cmocka_unit_test(refuses_what_is_not_json),
        cmocka_unit_test_setup_teardown(names_the_file, test_scratch_setup, test_scratch_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

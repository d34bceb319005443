// SPDX-License-Identifier: Apache-2.0
// test_file.c - whole files, folders, atomic replacement.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "support.h"

static void in_scratch(char out[TEST_PATH_MAX], void **state, const char *name)
{
    test_scratch_file(out, *state, name);
}

static void writes_reads_and_replaces(void **state)
{
    char path[TEST_PATH_MAX];
    sheen_err err;
    uint8_t *data;
    size_t n;
    in_scratch(path, state, "a.bin");
    assert_ok(sheen_file_write(path, "one\0two", 7, &err), err);
    assert_ok(sheen_file_write(path, "three", 5, &err), err);
    assert_ok(sheen_file_read(&data, &n, path, 5, &err), err);
    assert_int_equal(n, 5);
    assert_string_equal((char *)data, "three"); // with the NUL behind
    free(data);
    assert_fails(sheen_file_read(&data, &n, path, 4, &err), err, SHEEN_EFORMAT, "too large");
    assert_null(data);
    sheen_names names; // nothing temporary is left
    const test_scratch *scratch = *state;
    assert_ok(sheen_dir_list(&names, scratch->path, NULL, &err), err);
    assert_int_equal(names.count, 1);
    sheen_names_release(&names);
}

static void says_what_cannot_be_done(void **state)
{
    char path[TEST_PATH_MAX];
    sheen_err err;
    uint8_t *data;
    size_t n;
    in_scratch(path, state, "no/such/file");
    assert_fails(sheen_file_read(&data, &n, path, 99, &err), err, SHEEN_EIO, "cannot open '");
    assert_fails(sheen_file_write(path, "x", 1, &err), err, SHEEN_EIO, "No such file");
    const test_scratch *scratch = *state;
    assert_fails(sheen_file_read(&data, &n, scratch->path, 99, &err), err, SHEEN_EIO, "not a regular file");
    in_scratch(path, state, "pipe");
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_fails(sheen_file_read(&data, &n, path, 99, &err), err, SHEEN_EIO,
                 "not a regular file"); // and does not hang
    assert_fails(sheen_file_write("/dev/full/x", "x", 1, &err), err, SHEEN_EIO, "cannot write");
}

static void lists_sorted_without_hidden_ones(void **state)
{
    static const char *const files[] = {"b.json", "a.json", "c.txt", ".hidden.json"};
    char path[TEST_PATH_MAX];
    sheen_err err;
    sheen_names names;
    for (size_t i = 0; i < 4; i++) {
        in_scratch(path, state, files[i]);
        test_file_write_text(path, "x");
    }
    const test_scratch *scratch = *state;
    assert_ok(sheen_dir_list(&names, scratch->path, ".json", &err), err);
    assert_int_equal(names.count, 2);
    assert_string_equal(names.names[0], "a.json");
    assert_string_equal(names.names[1], "b.json");
    sheen_names_release(&names);
    assert_null(names.names);
}

static void replaces_a_folder_in_one_step(void **state)
{
    char made[TEST_PATH_MAX], place[TEST_PATH_MAX], file[TEST_PATH_MAX + 16], deep[TEST_PATH_MAX + 16];
    sheen_err err;
    in_scratch(made, state, "new");
    in_scratch(place, state, "model");
    for (int round = 0; round < 3; round++) {
        snprintf(deep, sizeof deep, "%s/sub/sub", made);
        assert_ok(sheen_dir_make(deep, &err), err);
        snprintf(file, sizeof file, "%s/%d", made, round);
        test_file_write_text(file, "x");
        assert_ok(sheen_dir_replace(place, made, &err), err);
        assert_false(sheen_dir_exists(made));
        snprintf(file, sizeof file, "%s/%d", place, round);
        assert_true(sheen_file_exists(file));
        snprintf(file, sizeof file, "%s/%d", place, round - 1);
        assert_false(sheen_file_exists(file));
    }
    assert_ok(sheen_dir_remove(place, &err), err);
    assert_ok(sheen_dir_remove(place, &err), err); // not there: fine
    assert_false(sheen_dir_exists(place));
}

static void removing_does_not_follow_links(void **state)
{
    char outside[TEST_PATH_MAX], file[TEST_PATH_MAX + 16], dir[TEST_PATH_MAX], link[TEST_PATH_MAX + 16];
    sheen_err err;
    in_scratch(outside, state, "outside");
    in_scratch(dir, state, "dir");
    assert_ok(sheen_dir_make(outside, &err), err);
    assert_ok(sheen_dir_make(dir, &err), err);
    snprintf(file, sizeof file, "%s/precious", outside);
    test_file_write_text(file, "x");
    snprintf(link, sizeof link, "%s/link", dir);
    assert_int_equal(symlink(outside, link), 0);
    assert_ok(sheen_dir_remove(dir, &err), err);
    assert_true(sheen_file_exists(file));
}

static void paths_and_digests(void **state)
{
    char path[SHEEN_PATH_MAX], hex[33], file[TEST_PATH_MAX];
    sheen_err err;
    assert_ok(sheen_path_join(path, "a/b", "c.d", &err), err);
    assert_string_equal(path, "a/b/c.d");
    assert_ok(sheen_path_join(path, "a/b/", "c", &err), err);
    assert_string_equal(path, "a/b/c");
    char *longer = malloc(SHEEN_PATH_MAX + 1);
    assert_non_null(longer);
    memset(longer, 'x', SHEEN_PATH_MAX);
    longer[SHEEN_PATH_MAX] = 0;
    assert_fails(sheen_path_join(path, longer, "c", &err), err, SHEEN_EARG, "too long");
    free(longer);
    assert_string_equal(sheen_path_base("a/b.c"), "b.c");
    assert_string_equal(sheen_path_extension("a.b/c"), "");
    assert_string_equal(sheen_path_extension("a/b.tar.gz"), "gz");
    sheen_digest(hex, "", 0);
    assert_string_equal(hex,
                        "99aa06d3014798d86001c324468d497f"); // XXH3-128 of nothing, from its specification
    in_scratch(file, state, "x");
    test_file_write_text(file, "");
    char again[33];
    assert_ok(sheen_file_digest(again, file, &err), err);
    assert_string_equal(again, hex);
}

static void what_a_power_cut_left_is_swept(void **state)
{
    static const struct {
        const char *name;
        bool goes;
    } files[] = {{".000001.json.aB3xY9", true},
                 {".000001.json.aB3x", false},
                 {".hidden", false},
                 {"000001.json", false},
                 {".a.b-c-d!", false}};
    const test_scratch *scratch = *state;
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char path[TEST_PATH_MAX];
        test_scratch_file(path, scratch, files[i].name);
        test_file_write_text(path, "x");
    }
    sheen_dir_sweep(scratch->path, 60); // young: may be somebody's at work
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char path[TEST_PATH_MAX];
        test_scratch_file(path, scratch, files[i].name);
        assert_true(sheen_file_exists(path));
    }
    sheen_dir_sweep(scratch->path, 0);
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char path[TEST_PATH_MAX];
        test_scratch_file(path, scratch, files[i].name);
        assert_true(sheen_file_exists(path) != files[i].goes);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(writes_reads_and_replaces, test_scratch_setup, test_scratch_teardown),
        cmocka_unit_test_setup_teardown(says_what_cannot_be_done, test_scratch_setup, test_scratch_teardown),
        cmocka_unit_test_setup_teardown(lists_sorted_without_hidden_ones, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(replaces_a_folder_in_one_step, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(removing_does_not_follow_links, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(what_a_power_cut_left_is_swept, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(paths_and_digests, test_scratch_setup, test_scratch_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

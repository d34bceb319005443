// SPDX-License-Identifier: Apache-2.0
// damaged_files.c - reads damaged files one after the other and compares what is said of them.
#include "tests/base/damaged_files.h"

#include <stdio.h>
#include <string.h>

void test_damaged_files(const test_damaged_file *files, size_t n_files,
                        sheen_status (*load)(const char *path, sheen_err *err))
{
    for (size_t i = 0; i < n_files; i++) {
        char path[TEST_PATH_MAX], named[TEST_PATH_MAX + 8];
        snprintf(path, sizeof path, "%s%s", TEST_CORPUS, files[i].path);
        snprintf(named, sizeof named, "'%s': ", path);
        sheen_err err = {0};
        const sheen_status s = load(path, &err);
        const char *name = strstr(err.msg, named);
        if (!name || strncmp(err.msg, "cannot read ", 12) != 0)
            fail_msg("'%s' is not named: %s", files[i].path, err.msg);
        else if (files[i].sentence)
            assert_string_equal(name + strlen(named), files[i].sentence);
        assert_int_equal(s, files[i].code);
        assert_int_equal(err.code, files[i].code);
    }
}

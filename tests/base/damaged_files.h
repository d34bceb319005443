// SPDX-License-Identifier: Apache-2.0
// damaged_files.h - files that are broken or lie, and the sentence that each is refused with.
//
// The files are those of the fuzz corpora: what a reader once got wrong is tried again by both.
#ifndef SHEEN_TESTS_BASE_DAMAGED_FILES_H
#define SHEEN_TESTS_BASE_DAMAGED_FILES_H

#include "tests/support.h"

#define TEST_CORPUS SHEEN_TEST_DATA "/../fuzz/corpus/"

typedef struct test_damaged_file {
    const char *path;     // within the corpora
    sheen_status code;    // what reading it returns
    const char *sentence; // all that is said behind "cannot read ... 'path': "; NULL: a library's words
} test_damaged_file;

// Reads every file by `load`, which hands nothing out on failure; the test fails where another code or
// sentence than the listed one comes back.
void test_damaged_files(const test_damaged_file *files, size_t n_files,
                        sheen_status (*load)(const char *path, sheen_err *err));

#endif

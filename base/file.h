// SPDX-License-Identifier: Apache-2.0
// file.h - whole files and folders; every write is temp file + fsync + rename.
#ifndef SHEEN_BASE_FILE_H
#define SHEEN_BASE_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SHEEN_PATH_MAX = 4096 };

// "<dir>/<name>" into out; EARG where that is too long. `name` may hold slashes.
sheen_status sheen_path_join(char out[SHEEN_PATH_MAX], const char *dir, const char *name, sheen_err *err);
// The part after the last slash, and the part of that after the last dot ("" where there is none).
const char *sheen_path_base(const char *path);
const char *sheen_path_extension(const char *path);

bool sheen_file_exists(const char *path);
bool sheen_dir_exists(const char *path);

// Reads a regular file of at most max_bytes into new memory (caller frees), with a NUL after
// the last byte that is not counted. EIO, EACCESS; EFORMAT where it is larger.
sheen_status sheen_file_read(uint8_t **data_out, size_t *size_bytes_out, const char *path, size_t max_bytes,
                             sheen_err *err);

// Replaces a file in one step: a reader, or a power cut, sees the old content or the new.
// A full disk is said as such. EIO, EACCESS.
sheen_status sheen_file_write(const char *path, const void *data, size_t size_bytes, sheen_err *err);
sheen_status sheen_file_copy(const char *to_path, const char *from_path, sheen_err *err);
// Removes a file; one that is not there is fine.
sheen_status sheen_file_remove(const char *path, sheen_err *err);

// Makes a folder and its parents; one that exists is fine.
sheen_status sheen_dir_make(const char *path, sheen_err *err);
// Removes a folder and all in it; one that is not there is fine. Links are not followed.
sheen_status sheen_dir_remove(const char *path, sheen_err *err);
// Renames a finished folder to its place, replacing one that is there (which is removed last).
sheen_status sheen_dir_replace(const char *path, const char *finished_path, sheen_err *err);

// Removes the temporary files that an interrupted sheen_file_write left in a folder (not below it), where they were
// last written at least so many seconds ago: a younger one may be another program's at work. What cannot be removed
// stays.
void sheen_dir_sweep(const char *path, int older_than_s);

typedef struct sheen_names {
    char **names;
    size_t count;
} sheen_names;

// Names in a folder that end in `suffix` (NULL: all), sorted by strcmp; not those which begin with a dot.
sheen_status sheen_dir_list(sheen_names *out, const char *path, const char *suffix, sheen_err *err);
void sheen_names_release(sheen_names *n);

// XXH3-128 as 32 hex digits.
void sheen_digest(char hex[33], const void *data, size_t size_bytes);
// The same of a file's content, as 32 hex digits: tells whether a stage's input has changed.
sheen_status sheen_file_digest(char hex[33], const char *path, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

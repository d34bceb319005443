// SPDX-License-Identifier: Apache-2.0
// json_write.h - writing JSON, value by value, into memory.
//
//     sheen_json_writer w = {0};
//     sheen_json_open(&w, NULL, '{');
//     sheen_json_put_number(&w, "rms_px", 0.12);
//     sheen_json_put_numbers(&w, "rt_cam_board", rt, 6);
//     sheen_json_close(&w);
//     s = sheen_json_save(&w, path, err);         // atomic; releases the writer
//
// `key` is NULL inside an array and for the outermost value. Running out of memory is
// remembered and reported once, at the end. Numbers are written so that they read back
// exactly; what is not finite is written as null.
#ifndef SHEEN_BASE_JSON_WRITE_H
#define SHEEN_BASE_JSON_WRITE_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"
#include "base/text.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_json_writer {
    sheen_text text;
    char closers[32]; // of the open objects and arrays, innermost last
    int depth;
    bool has_member[33];
} sheen_json_writer;

void sheen_json_open(sheen_json_writer *w, const char *key, char bracket); // '{' or '['
void sheen_json_close(sheen_json_writer *w);
void sheen_json_put_number(sheen_json_writer *w, const char *key, double x);
void sheen_json_put_int(sheen_json_writer *w, const char *key, long long x);
void sheen_json_put_string(sheen_json_writer *w, const char *key, const char *text); // NULL: null
void sheen_json_put_bool(sheen_json_writer *w, const char *key, bool x);
// An array of numbers on one line.
void sheen_json_put_numbers(sheen_json_writer *w, const char *key, const double *x, size_t n);

// The text so far, ended by a NUL (lent until the next call); NULL when memory ran out.
const char *sheen_json_text(sheen_json_writer *w);
// Writes the text and a newline to a file, atomically, and releases the writer.
sheen_status sheen_json_save(sheen_json_writer *w, const char *path, sheen_err *err);
void sheen_json_writer_release(sheen_json_writer *w);

#ifdef __cplusplus
}
#endif
#endif

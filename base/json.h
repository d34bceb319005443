// SPDX-License-Identifier: Apache-2.0
// json.h - reading JSON: a tree of values, with getters that check and say what is wrong.
//
// Values are lent by the tree and live until sheen_json_free() of its root. Getters fail
// with EFORMAT and a short text ("no number 'fx'"); the caller puts the file's name before
// it with sheen_wrap(). Numbers are finite by construction (JSON has no NaN).
#ifndef SHEEN_BASE_JSON_H
#define SHEEN_BASE_JSON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_json sheen_json;

// Parses `size_bytes` of text. Nesting is limited; duplicate keys and trailing text are errors.
sheen_status sheen_json_parse(sheen_json **root_out, const void *data, size_t size_bytes, sheen_err *err);
// Reads a file (at most 256 MB) and parses it; the sentence names the path.
sheen_status sheen_json_load(sheen_json **root_out, const char *path, sheen_err *err);
void sheen_json_free(sheen_json **root);

// A member of an object or an element of an array; NULL where absent (or of another type).
const sheen_json *sheen_json_get(const sheen_json *object, const char *key);
const sheen_json *sheen_json_at(const sheen_json *array, size_t index);
// Elements of an array; 0 for anything else.
size_t sheen_json_count(const sheen_json *array);
bool sheen_json_is_array(const sheen_json *value);
bool sheen_json_is_object(const sheen_json *value);
bool sheen_json_is_number(const sheen_json *value);
bool sheen_json_is_string(const sheen_json *value);

// The value itself, where it is of that type; else the fallback.
double sheen_json_value_number(const sheen_json *value, double fallback);
const char *sheen_json_value_string(const sheen_json *value, const char *fallback);

// Required members.
sheen_status sheen_json_number(const sheen_json *object, const char *key, double *out, sheen_err *err);
sheen_status sheen_json_int(const sheen_json *object, const char *key, int min, int max, int *out,
                            sheen_err *err);
// A whole number with all its 64 bits (a double keeps 53).
sheen_status sheen_json_int64(const sheen_json *object, const char *key, int64_t *out, sheen_err *err);
sheen_status sheen_json_string(const sheen_json *object, const char *key, const char **out, sheen_err *err);
sheen_status sheen_json_bool(const sheen_json *object, const char *key, bool *out, sheen_err *err);
sheen_status sheen_json_array(const sheen_json *object, const char *key, const sheen_json **out,
                              sheen_err *err);
// Exactly n numbers; nested arrays are flattened row by row (a 4x4 matrix is 16 numbers).
sheen_status sheen_json_numbers(const sheen_json *object, const char *key, double *out, size_t n,
                                sheen_err *err);

// Checks the member "schema": "<name>/<version>" against a name and the newest version known.
sheen_status sheen_json_schema(const sheen_json *root, const char *name, int newest, int *version,
                               sheen_err *err);

// Visits every member of an object in the order of the file.
void sheen_json_each(const sheen_json *object,
                     void (*visit)(void *self, const char *key, const sheen_json *value), void *self);

#ifdef __cplusplus
}
#endif
#endif

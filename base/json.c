// SPDX-License-Identifier: Apache-2.0
// json.c - the only file that includes jansson. A sheen_json is a json_t under another name.
#include "base/json.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"

static json_t *unwrap(const sheen_json *v)
{
    union { // jansson's getters take const, its iterators do not; nothing here writes
        const sheen_json *in;
        json_t *out;
    } u = {.in = v};
    return u.out;
}

static sheen_json *wrap(json_t *v)
{
    return (sheen_json *)(void *)v;
}

sheen_status sheen_json_parse(sheen_json **root_out, const void *data, size_t size_bytes, sheen_err *err)
{
    *root_out = NULL;
    json_error_t e;
    json_t *root = json_loadb(data, size_bytes, JSON_REJECT_DUPLICATES, &e);
    if (!root) {
        if (json_error_code(&e) == json_error_out_of_memory)
            return sheen_fail_memory(err, (double)size_bytes, "JSON");
        return sheen_fail(err, SHEEN_EFORMAT, "not valid JSON: %s (line %d)", e.text, e.line);
    }
    *root_out = wrap(root);
    return SHEEN_OK;
}

sheen_status sheen_json_load(sheen_json **root_out, const char *path, sheen_err *err)
{
    *root_out = NULL;
    uint8_t *data;
    size_t size_bytes;
    sheen_status s = sheen_file_read(&data, &size_bytes, path, (size_t)256 << 20, err);
    if (s)
        return s;
    s = sheen_json_parse(root_out, data, size_bytes, err);
    free(data);
    return s ? sheen_wrap(err, s, "cannot read '%s'", path) : SHEEN_OK;
}

void sheen_json_free(sheen_json **root)
{
    if (root && *root) {
        json_decref(unwrap(*root));
        *root = NULL;
    }
}

const sheen_json *sheen_json_get(const sheen_json *object, const char *key)
{
    return object ? wrap(json_object_get(unwrap(object), key)) : NULL;
}

const sheen_json *sheen_json_at(const sheen_json *array, size_t index)
{
    return array ? wrap(json_array_get(unwrap(array), index)) : NULL;
}

size_t sheen_json_count(const sheen_json *array)
{
    return array ? json_array_size(unwrap(array)) : 0;
}

bool sheen_json_is_array(const sheen_json *value)
{
    return value && json_is_array(unwrap(value));
}

bool sheen_json_is_object(const sheen_json *value)
{
    return value && json_is_object(unwrap(value));
}

bool sheen_json_is_number(const sheen_json *value)
{
    return value && json_is_number(unwrap(value));
}

bool sheen_json_is_string(const sheen_json *value)
{
    return value && json_is_string(unwrap(value));
}

double sheen_json_value_number(const sheen_json *value, double fallback)
{
    return sheen_json_is_number(value) ? json_number_value(unwrap(value)) : fallback;
}

const char *sheen_json_value_string(const sheen_json *value, const char *fallback)
{
    return sheen_json_is_string(value) ? json_string_value(unwrap(value)) : fallback;
}

sheen_status sheen_json_number(const sheen_json *object, const char *key, double *out, sheen_err *err)
{
    const sheen_json *v = sheen_json_get(object, key);
    if (!sheen_json_is_number(v))
        return sheen_fail(err, SHEEN_EFORMAT, "no number '%s'", key);
    *out = json_number_value(unwrap(v));
    return SHEEN_OK;
}

sheen_status sheen_json_int(const sheen_json *object, const char *key, int min, int max, int *out,
                            sheen_err *err)
{
    double x;
    const sheen_status s = sheen_json_number(object, key, &x, err);
    if (s)
        return s;
    if (x < min || x > max || x != floor(x))
        return sheen_fail(err, SHEEN_EFORMAT, "'%s' is %g, not a whole number from %d to %d", key, x, min,
                          max);
    *out = (int)x;
    return SHEEN_OK;
}

sheen_status sheen_json_int64(const sheen_json *object, const char *key, int64_t *out, sheen_err *err)
{
    const sheen_json *v = sheen_json_get(object, key);
    if (!v || !json_is_integer(unwrap(v)))
        return sheen_fail(err, SHEEN_EFORMAT, "no whole number '%s'", key);
    *out = json_integer_value(unwrap(v));
    return SHEEN_OK;
}

sheen_status sheen_json_string(const sheen_json *object, const char *key, const char **out, sheen_err *err)
{
    const sheen_json *v = sheen_json_get(object, key);
    if (!sheen_json_is_string(v))
        return sheen_fail(err, SHEEN_EFORMAT, "no text '%s'", key);
    *out = json_string_value(unwrap(v));
    return SHEEN_OK;
}

sheen_status sheen_json_bool(const sheen_json *object, const char *key, bool *out, sheen_err *err)
{
    const sheen_json *v = sheen_json_get(object, key);
    if (!v || !json_is_boolean(unwrap(v)))
        return sheen_fail(err, SHEEN_EFORMAT, "no true or false '%s'", key);
    *out = json_is_true(unwrap(v));
    return SHEEN_OK;
}

sheen_status sheen_json_array(const sheen_json *object, const char *key, const sheen_json **out,
                              sheen_err *err)
{
    const sheen_json *v = sheen_json_get(object, key);
    if (!sheen_json_is_array(v))
        return sheen_fail(err, SHEEN_EFORMAT, "no list '%s'", key);
    *out = v;
    return SHEEN_OK;
}

// Appends the numbers of v to out[*n..max); false where something else is met.
static bool flatten(const json_t *v, double *out, size_t max, size_t *n, int depth)
{
    if (json_is_number(v)) {
        if (*n < max)
            out[*n] = json_number_value(v);
        (*n)++;
        return true;
    }
    if (!json_is_array(v) || depth > 3)
        return false;
    for (size_t i = 0; i < json_array_size(v); i++)
        if (!flatten(json_array_get(v, i), out, max, n, depth + 1))
            return false;
    return true;
}

sheen_status sheen_json_numbers(const sheen_json *object, const char *key, double *out, size_t n,
                                sheen_err *err)
{
    const sheen_json *v = sheen_json_get(object, key);
    size_t found = 0;
    if (!sheen_json_is_array(v) || !flatten(unwrap(v), out, n, &found, 0))
        return sheen_fail(err, SHEEN_EFORMAT, "no list of %zu numbers '%s'", n, key);
    if (found != n)
        return sheen_fail(err, SHEEN_EFORMAT, "'%s' has %zu numbers, not %zu", key, found, n);
    return SHEEN_OK;
}

sheen_status sheen_json_schema(const sheen_json *root, const char *name, int newest, int *version,
                               sheen_err *err)
{
    const char *text;
    const sheen_status s = sheen_json_string(root, "schema", &text, err);
    if (s)
        return s;
    const size_t n = strlen(name);
    char *end = NULL;
    const long v = !strncmp(text, name, n) && text[n] == '/' ? strtol(text + n + 1, &end, 10) : 0;
    if (!end || *end || v < 1)
        return sheen_fail(err, SHEEN_EFORMAT, "schema is '%.60s', not '%s/%d'", text, name, newest);
    if (v > newest)
        return sheen_fail(err, SHEEN_EFORMAT,
                          "schema '%.60s' is newer than this program knows (%d): update sheen", text, newest);
    if (version)
        *version = (int)v;
    return SHEEN_OK;
}

void sheen_json_each(const sheen_json *object,
                     void (*visit)(void *self, const char *key, const sheen_json *value), void *self)
{
    const char *key;
    json_t *value;
    if (sheen_json_is_object(object))
        json_object_foreach(unwrap(object), key, value) visit(self, key, wrap(value));
}

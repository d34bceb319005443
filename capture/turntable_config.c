// SPDX-License-Identifier: Apache-2.0
// turntable_config.c - the turntable's file, read and written.
#include "capture/turntable_config.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "base/json_write.h"
#include "capture/grbl_protocol.h"

#define SCHEMA "sheen-turntable"

enum { MAX_FILE_BYTES = 1 << 16 };

void sheen_table_config_init(sheen_table_config *c)
{
    *c = (sheen_table_config){
        .baud = 115200, .axis = 'X', .degrees_per_unit = 1, .direction = 1, .speed_deg_s = 20};
}

static sheen_status read_range(double *out, const sheen_json *root, const char *key, double least,
                               double most, sheen_err *err)
{
    if (!sheen_json_get(root, key))
        return SHEEN_OK;
    const sheen_status s = sheen_json_number(root, key, out, err);
    if (!s && !(*out >= least && *out <= most))
        return sheen_fail(err, SHEEN_EFORMAT, "'%s' must lie between %g and %g", key, least, most);
    return s;
}

static sheen_status read_axis(sheen_table_config *c, const sheen_json *root, sheen_err *err)
{
    const char *axis;
    if (!sheen_json_get(root, "axis"))
        return SHEEN_OK;
    const sheen_status s = sheen_json_string(root, "axis", &axis, err);
    if (!s && (strlen(axis) != 1 || sheen_grbl_axis_index(axis[0]) < 0))
        return sheen_fail(err, SHEEN_EFORMAT, "'axis' must be one of X, Y, Z, A, B, C");
    if (!s)
        c->axis = axis[0];
    return s;
}

static sheen_status read_members(sheen_table_config *c, const sheen_json *root, sheen_err *err)
{
    int version;
    double direction = c->direction;
    sheen_status s = sheen_json_schema(root, SCHEMA, 1, &version, err);
    if (!s && sheen_json_get(root, "baud"))
        s = sheen_json_int(root, "baud", 1200, 4000000, &c->baud, err);
    if (s || (s = read_axis(c, root, err)) ||
        (s = read_range(&c->degrees_per_unit, root, "degrees_per_unit", 1e-6, 1e6, err)) ||
        (s = read_range(&direction, root, "direction", -1, 1, err)) ||
        (s = read_range(&c->speed_deg_s, root, "speed_deg_s", 0.01, 36000, err)) ||
        (s = read_range(&c->acceleration_deg_s2, root, "acceleration_deg_s2", 0, 1e6, err)) ||
        (s = read_range(&c->backlash_deg, root, "backlash_deg", 0, 20, err)))
        return s;
    if (fabs(direction) != 1)
        return sheen_fail(err, SHEEN_EFORMAT, "'direction' must be 1 or -1");
    c->direction = (int)direction;
    if (sheen_json_get(root, "axis_board"))
        s = sheen_json_numbers(root, "axis_board", c->axis_board, 6, err);
    if (!s && sheen_json_get(root, "measured"))
        s = sheen_json_bool(root, "measured", &c->measured, err);
    return s;
}

sheen_status sheen_table_config_parse(sheen_table_config *c, const void *data, size_t size_bytes,
                                      sheen_err *err)
{
    sheen_json *root = NULL;
    sheen_table_config_init(c);
    sheen_status s = sheen_json_parse(&root, data, size_bytes, err);
    if (!s)
        s = read_members(c, root, err);
    sheen_json_free(&root);
    return s;
}

sheen_status sheen_table_config_load(sheen_table_config *c, const char *path, sheen_err *err)
{
    uint8_t *data;
    size_t size_bytes;
    sheen_status s = sheen_file_read(&data, &size_bytes, path, MAX_FILE_BYTES, err);
    if (s)
        return s;
    s = sheen_table_config_parse(c, data, size_bytes, err);
    free(data);
    return s ? sheen_wrap(err, s, "cannot use '%s'", path) : SHEEN_OK;
}

sheen_status sheen_table_config_save(const sheen_table_config *c, const char *path, sheen_err *err)
{
    const char axis[2] = {c->axis, '\0'};
    sheen_json_writer w = {0};
    sheen_json_open(&w, NULL, '{');
    sheen_json_put_string(&w, "schema", SCHEMA "/1");
    sheen_json_put_int(&w, "baud", c->baud);
    sheen_json_put_string(&w, "axis", axis);
    sheen_json_put_number(&w, "degrees_per_unit", c->degrees_per_unit);
    sheen_json_put_int(&w, "direction", c->direction);
    sheen_json_put_number(&w, "speed_deg_s", c->speed_deg_s);
    sheen_json_put_number(&w, "acceleration_deg_s2", c->acceleration_deg_s2);
    sheen_json_put_number(&w, "backlash_deg", c->backlash_deg);
    sheen_json_put_numbers(&w, "axis_board", c->axis_board, 6);
    sheen_json_put_bool(&w, "measured", c->measured);
    sheen_json_close(&w);
    return sheen_json_save(&w, path, err);
}

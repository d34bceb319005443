// SPDX-License-Identifier: Apache-2.0
// turntable_config.h - what must be known of a turntable to drive it: a small JSON file. docs/turntable.md.
#ifndef SHEEN_CAPTURE_TURNTABLE_CONFIG_H
#define SHEEN_CAPTURE_TURNTABLE_CONFIG_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

// Angles are degrees of the table as the tags see them turn; positive is counter-clockwise seen from above.
typedef struct sheen_table_config {
    int baud;
    char axis;               // 'X', 'Y', 'Z', 'A', 'B' or 'C'
    double degrees_per_unit; // > 0: of the table for one unit ("mm") of the controller
    int direction;           // 1: the controller's numbers grow as the angle does; -1: the other way
    double speed_deg_s;
    double acceleration_deg_s2; // 0: what the controller has
    double backlash_deg;        // lost when the direction changes; every angle is approached from below
    double axis_board
        [6];       // the axis in the board's frame: a point (metres), then its direction, up; zero: not known
    bool measured; // by the set-up, from the tags, rather than typed
} sheen_table_config;

// 115200 baud, axis X, one degree a unit, 20 degrees a second.
void sheen_table_config_init(sheen_table_config *c);
// Every member is checked; those that are missing keep their defaults. EFORMAT.
sheen_status sheen_table_config_parse(sheen_table_config *c, const void *data, size_t size_bytes,
                                      sheen_err *err);
sheen_status sheen_table_config_load(sheen_table_config *c, const char *path, sheen_err *err);
sheen_status sheen_table_config_save(const sheen_table_config *c, const char *path, sheen_err *err);

#endif

// SPDX-License-Identifier: Apache-2.0
// v4l2_controls.h - a camera's settings, by V4L2's numbers (names have changed over the years).
#ifndef SHEEN_CAPTURE_V4L2_CONTROLS_H
#define SHEEN_CAPTURE_V4L2_CONTROLS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "capture/v4l2_io.h"

typedef struct sheen_v4l2_control {
    uint32_t id, type; // type: V4L2_CTRL_TYPE_*
    char name[40];
    int32_t min, max, step, fallback; // fallback: the driver's default
    int32_t value;
    bool has_value, inactive, read_only;
} sheen_v4l2_control;

typedef struct sheen_v4l2_controls {
    sheen_v4l2_control
        *controls; // in the order of their numbers; settings only: no buttons, classes, strings
    size_t n_controls;
} sheen_v4l2_controls;

// Asks for every control and its value. ENODEV, EIO, ENOMEM. A camera without controls has none.
sheen_status sheen_v4l2_controls_read(sheen_v4l2_controls *out, const sheen_v4l2_io *io, int fd,
                                      const char *path, sheen_err *err);
void sheen_v4l2_controls_release(sheen_v4l2_controls *c);
sheen_v4l2_control *sheen_v4l2_controls_find(const sheen_v4l2_controls *c, uint32_t id);

// 0 or errno.
int sheen_v4l2_control_get(int32_t *value, const sheen_v4l2_io *io, int fd, uint32_t id);
int sheen_v4l2_control_set(const sheen_v4l2_io *io, int fd, uint32_t id, int32_t value);

#endif

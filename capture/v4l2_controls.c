// SPDX-License-Identifier: Apache-2.0
// v4l2_controls.c - enumerates, reads and writes the controls of a video node.
#include "capture/v4l2_controls.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <linux/videodev2.h>

#include "capture/v4l2_error.h"

enum { MAX_CONTROLS = 256 };

int sheen_v4l2_control_get(int32_t *value, const sheen_v4l2_io *io, int fd, uint32_t id)
{
    struct v4l2_control c;
    memset(&c, 0, sizeof c);
    c.id = id;
    if (sheen_v4l2_ioctl(io, fd, VIDIOC_G_CTRL, &c) < 0)
        return errno;
    *value = c.value;
    return 0;
}

int sheen_v4l2_control_set(const sheen_v4l2_io *io, int fd, uint32_t id, int32_t value)
{
    struct v4l2_control c;
    memset(&c, 0, sizeof c);
    c.id = id;
    c.value = value;
    return sheen_v4l2_ioctl(io, fd, VIDIOC_S_CTRL, &c) < 0 ? errno : 0;
}

static bool is_setting(const struct v4l2_queryctrl *q)
{
    switch (q->type) {
    case V4L2_CTRL_TYPE_INTEGER:
    case V4L2_CTRL_TYPE_BOOLEAN:
    case V4L2_CTRL_TYPE_MENU:
    case V4L2_CTRL_TYPE_INTEGER_MENU:
    case V4L2_CTRL_TYPE_BITMASK:
        return !(q->flags & V4L2_CTRL_FLAG_DISABLED);
    default:
        return false;
    }
}

static void describe(sheen_v4l2_control *c, const struct v4l2_queryctrl *q)
{
    *c = (sheen_v4l2_control){.id = q->id, .type = q->type, .min = q->minimum, .max = q->maximum};
    c->step = q->step > 0 ? q->step : 1;
    c->fallback = q->default_value;
    c->inactive = (q->flags & (V4L2_CTRL_FLAG_INACTIVE | V4L2_CTRL_FLAG_GRABBED)) != 0;
    c->read_only = (q->flags & V4L2_CTRL_FLAG_READ_ONLY) != 0;
    snprintf(c->name, sizeof c->name, "%.31s", (const char *)q->name);
    for (char *p = c->name; *p; p++) // "White Balance, Automatic" as v4l2-ctl writes it
        if (*p == ' ')
            *p = '_';
}

sheen_status sheen_v4l2_controls_read(sheen_v4l2_controls *out, const sheen_v4l2_io *io, int fd,
                                      const char *path, sheen_err *err)
{
    *out = (sheen_v4l2_controls){0};
    out->controls = calloc(MAX_CONTROLS, sizeof *out->controls);
    if (!out->controls)
        return sheen_fail_memory(err, MAX_CONTROLS * (double)sizeof *out->controls, "the camera's controls");
    struct v4l2_queryctrl q;
    memset(&q, 0, sizeof q);
    for (int i = 0; i < 4 * MAX_CONTROLS && out->n_controls < MAX_CONTROLS; i++) {
        const uint32_t before = q.id;
        q.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
        if (sheen_v4l2_ioctl(io, fd, VIDIOC_QUERYCTRL, &q) < 0) {
            if (errno == EINVAL || errno == ENOTTY)
                break; // that was the last, or there are none
            const sheen_status s = sheen_v4l2_fail(err, errno, "read the controls of", path);
            sheen_v4l2_controls_release(out);
            return s;
        }
        if (q.id <= before)
            break;
        if (!is_setting(&q))
            continue;
        sheen_v4l2_control *c = &out->controls[out->n_controls++];
        describe(c, &q);
        const int code = sheen_v4l2_control_get(&c->value, io, fd, c->id);
        c->has_value = !code;
        if (code == ENODEV) {
            sheen_v4l2_controls_release(out);
            return sheen_v4l2_fail(err, code, "read the controls of", path);
        }
    }
    return SHEEN_OK;
}

void sheen_v4l2_controls_release(sheen_v4l2_controls *c)
{
    free(c->controls);
    *c = (sheen_v4l2_controls){0};
}

sheen_v4l2_control *sheen_v4l2_controls_find(const sheen_v4l2_controls *c, uint32_t id)
{
    for (size_t i = 0; i < c->n_controls; i++)
        if (c->controls[i].id == id)
            return &c->controls[i];
    return NULL;
}

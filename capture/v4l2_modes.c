// SPDX-License-Identifier: Apache-2.0
// v4l2_modes.c - enumerates what a video node can deliver. Limits keep a driver that never ends its lists in bounds.
#include "capture/v4l2_modes.h"

#include <stdlib.h>
#include <string.h>

#include <linux/videodev2.h>

#include "capture/v4l2_camera.h"
#include "capture/v4l2_error.h"

enum { MAX_FORMATS = 32, MAX_SIZES = 64, MAX_MODES = 512 };

static void read_rates(sheen_v4l2_mode *m, const sheen_v4l2_io *io, int fd)
{
    for (uint32_t i = 0; i < SHEEN_V4L2_MAX_RATES; i++) {
        struct v4l2_frmivalenum e;
        memset(&e, 0, sizeof e);
        e.index = i;
        e.pixel_format = m->fourcc;
        e.width = (uint32_t)m->width_px;
        e.height = (uint32_t)m->height_px;
        if (sheen_v4l2_ioctl(io, fd, VIDIOC_ENUM_FRAMEINTERVALS, &e) < 0)
            return;
        // Of a range the shortest interval is told.
        const struct v4l2_fract t = e.type == V4L2_FRMIVAL_TYPE_DISCRETE ? e.discrete : e.stepwise.min;
        if (t.numerator)
            m->rates_hz[m->n_rates++] = (double)t.denominator / t.numerator;
        if (e.type != V4L2_FRMIVAL_TYPE_DISCRETE)
            return;
    }
}

// One size; false where there are no more.
static bool read_size(sheen_v4l2_mode *m, uint32_t fourcc, uint32_t i, bool *is_last, const sheen_v4l2_io *io,
                      int fd)
{
    struct v4l2_frmsizeenum e;
    memset(&e, 0, sizeof e);
    e.index = i;
    e.pixel_format = fourcc;
    if (sheen_v4l2_ioctl(io, fd, VIDIOC_ENUM_FRAMESIZES, &e) < 0)
        return false;
    *m = (sheen_v4l2_mode){.fourcc = fourcc, .recorded = sheen_v4l2_is_recorded(fourcc)};
    sheen_v4l2_fourcc_text(m->format, fourcc);
    *is_last = e.type != V4L2_FRMSIZE_TYPE_DISCRETE;
    m->width_px = (int)(*is_last ? e.stepwise.max_width : e.discrete.width);
    m->height_px = (int)(*is_last ? e.stepwise.max_height : e.discrete.height);
    read_rates(m, io, fd);
    return true;
}

sheen_status sheen_v4l2_modes_read(sheen_v4l2_mode **modes_out, size_t *n_out, const sheen_v4l2_io *io,
                                   int fd, sheen_err *err)
{
    *n_out = 0;
    *modes_out = calloc(MAX_MODES, sizeof **modes_out);
    if (!*modes_out)
        return sheen_fail_memory(err, MAX_MODES * (double)sizeof **modes_out, "the camera's formats");
    for (uint32_t k = 0; k < MAX_FORMATS; k++) {
        struct v4l2_fmtdesc d;
        bool is_last = false;
        memset(&d, 0, sizeof d);
        d.index = k;
        d.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        if (sheen_v4l2_ioctl(io, fd, VIDIOC_ENUM_FMT, &d) < 0)
            break;
        for (uint32_t i = 0; !is_last && i < MAX_SIZES && *n_out < MAX_MODES; i++) {
            if (!read_size(*modes_out + *n_out, d.pixelformat, i, &is_last, io, fd))
                break;
            ++*n_out;
        }
    }
    return SHEEN_OK;
}

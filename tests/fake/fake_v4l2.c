// SPDX-License-Identifier: Apache-2.0
// fake_v4l2.c - the state machine: calls, their rules, and the faults that were planned.
#include "tests/fake/fake_v4l2.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <linux/videodev2.h>

#include "tests/fake/fake_sensor.h"
#include "tests/support.h"

enum { FD = 1000, STEP_BYTES = 1 << 24 };

static int refuse(int code)
{
    errno = code;
    return -1;
}

// 0: go on. Every call goes through here first.
static int enter(fake_v4l2 *f, unsigned long request)
{
    f->now_ns += 1000;
    if (++f->n_calls == f->faults.fail_call) {
        f->gone = f->faults.fail_errno == ENODEV;
        return refuse(f->faults.fail_errno);
    }
    if (request && request == f->faults.fail_request)
        return refuse(f->faults.fail_request_errno);
    return f->gone ? refuse(ENODEV) : 0;
}

static int fake_open(void *self, const char *path)
{
    fake_v4l2 *f = self;
    if (enter(f, 0))
        return -1;
    if (strcmp(path, "/dev/video0") != 0)
        return refuse(ENOENT);
    if (f->n_open)
        return refuse(EBUSY);
    f->n_open++;
    return FD;
}

static int fake_close(void *self, int fd)
{
    fake_v4l2 *f = self;
    assert_int_equal(fd, FD);
    assert_int_equal(f->n_open, 1);
    f->n_open--;
    f->streaming = false;
    return 0;
}

static int query_caps(const fake_v4l2 *f, struct v4l2_capability *c)
{
    memset(c, 0, sizeof *c);
    snprintf((char *)c->driver, sizeof c->driver, "fake");
    snprintf((char *)c->card, sizeof c->card, "Fake Camera");
    snprintf((char *)c->bus_info, sizeof c->bus_info, "usb-0000:00:14.0-1");
    c->device_caps = V4L2_CAP_STREAMING |
                     (f->faults.no_capture ? V4L2_CAP_META_CAPTURE : V4L2_CAP_VIDEO_CAPTURE);
    // Of the whole device, as the kernel says it: what other nodes can do counts here.
    c->capabilities = c->device_caps | V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_DEVICE_CAPS;
    return 0;
}

static int format(fake_v4l2 *f, struct v4l2_format *v, bool set)
{
    if (v->type != V4L2_BUF_TYPE_VIDEO_CAPTURE)
        return refuse(EINVAL);
    if (set && f->n_buffers)
        return refuse(EBUSY);
    memset(&v->fmt, 0, sizeof v->fmt);
    v->fmt.pix.width = (uint32_t)f->width_px;
    v->fmt.pix.height = (uint32_t)f->height_px;
    v->fmt.pix.pixelformat = f->fourcc;
    v->fmt.pix.field = V4L2_FIELD_NONE;
    v->fmt.pix.bytesperline = (uint32_t)f->stride_bytes;
    v->fmt.pix.sizeimage = (uint32_t)fake_v4l2_frame_bytes(f);
    v->fmt.pix.colorspace = f->color.colorspace;
    v->fmt.pix.priv = V4L2_PIX_FMT_PRIV_MAGIC;
    v->fmt.pix.xfer_func = f->color.xfer_func;
    v->fmt.pix.ycbcr_enc = f->color.ycbcr_enc;
    v->fmt.pix.quantization = f->color.quantization;
    return 0;
}

static int enum_format(const fake_v4l2 *f, struct v4l2_fmtdesc *d)
{
    if (d->index || d->type != V4L2_BUF_TYPE_VIDEO_CAPTURE)
        return refuse(EINVAL);
    d->pixelformat = f->fourcc;
    snprintf((char *)d->description, sizeof d->description, "the only one");
    return 0;
}

static int enum_size(const fake_v4l2 *f, struct v4l2_frmsizeenum *e)
{
    if (e->index || e->pixel_format != f->fourcc)
        return refuse(EINVAL);
    e->type = V4L2_FRMSIZE_TYPE_DISCRETE;
    e->discrete.width = (uint32_t)f->width_px;
    e->discrete.height = (uint32_t)f->height_px;
    return 0;
}

static int enum_interval(const fake_v4l2 *f, struct v4l2_frmivalenum *e)
{
    if (e->index || e->pixel_format != f->fourcc || e->width != (uint32_t)f->width_px)
        return refuse(EINVAL);
    e->type = V4L2_FRMIVAL_TYPE_DISCRETE;
    e->discrete.numerator = (uint32_t)(f->interval_ns / 1000);
    e->discrete.denominator = 1000000;
    return 0;
}

static int rate(const fake_v4l2 *f, struct v4l2_streamparm *p)
{
    if (p->type != V4L2_BUF_TYPE_VIDEO_CAPTURE)
        return refuse(EINVAL);
    p->parm.capture.timeperframe.numerator = (uint32_t)(f->interval_ns / 1000);
    p->parm.capture.timeperframe.denominator = 1000000;
    return 0;
}

static int request_buffers(fake_v4l2 *f, struct v4l2_requestbuffers *r)
{
    if (r->type != V4L2_BUF_TYPE_VIDEO_CAPTURE || r->memory != V4L2_MEMORY_MMAP)
        return refuse(EINVAL);
    if (f->streaming || f->n_mapped)
        return refuse(EBUSY);
    f->n_buffers = r->count > FAKE_MAX_BUFFERS ? FAKE_MAX_BUFFERS : (int)r->count;
    r->count = (uint32_t)f->n_buffers;
    memset(f->buffers, 0, sizeof f->buffers);
    return 0;
}

static void describe_buffer(const fake_v4l2 *f, struct v4l2_buffer *b)
{
    const uint32_t i = b->index;
    b->length = (uint32_t)fake_v4l2_frame_bytes(f);
    b->m.offset = i * STEP_BYTES;
    b->flags = f->faults.stamps_none ? V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN : V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
    b->flags |= f->faults.stamps_end ? V4L2_BUF_FLAG_TSTAMP_SRC_EOF : V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
    if (f->buffers[i].flagged)
        b->flags |= V4L2_BUF_FLAG_ERROR;
    b->bytesused = (uint32_t)f->buffers[i].bytes_used;
    b->sequence = f->buffers[i].sequence;
    b->field = V4L2_FIELD_NONE;
    b->timestamp.tv_sec = f->buffers[i].t_ns / 1000000000;
    b->timestamp.tv_usec = f->buffers[i].t_ns % 1000000000 / 1000;
}

static int buffer_call(fake_v4l2 *f, unsigned long request, struct v4l2_buffer *b)
{
    if (b->type != V4L2_BUF_TYPE_VIDEO_CAPTURE || b->memory != V4L2_MEMORY_MMAP)
        return refuse(EINVAL);
    if (request == VIDIOC_DQBUF) {
        int first = -1;
        if (!f->streaming)
            return refuse(EINVAL);
        for (int i = 0; i < f->n_buffers; i++)
            if (f->buffers[i].done && (first < 0 || f->buffers[i].order < f->buffers[first].order))
                first = i;
        if (first < 0)
            return refuse(EAGAIN);
        b->index = (uint32_t)first;
        f->buffers[first].done = false;
        describe_buffer(f, b);
        return 0;
    }
    if (b->index >= (uint32_t)f->n_buffers)
        return refuse(EINVAL);
    if (request == VIDIOC_QUERYBUF) {
        describe_buffer(f, b);
        return 0;
    }
    if (f->buffers[b->index].queued || f->buffers[b->index].done || !f->buffers[b->index].memory)
        return refuse(EINVAL);
    f->buffers[b->index].queued = true;
    return 0;
}

static int stream(fake_v4l2 *f, const int *type, bool on)
{
    int n_queued = 0;
    for (int i = 0; i < f->n_buffers; i++)
        n_queued += f->buffers[i].queued;
    if (*type != V4L2_BUF_TYPE_VIDEO_CAPTURE || (on && !n_queued))
        return refuse(EINVAL);
    f->streaming = on;
    f->next_frame_ns = f->now_ns + f->interval_ns;
    for (int i = 0; !on && i < f->n_buffers; i++)
        f->buffers[i].queued = f->buffers[i].done = false;
    return 0;
}

static int fake_ioctl(void *self, int fd, unsigned long request, void *arg)
{
    fake_v4l2 *f = self;
    if (enter(f, request))
        return -1;
    if (fd != FD || !f->n_open)
        return refuse(EBADF);
    switch (request) {
    case VIDIOC_QUERYCAP:
        return query_caps(f, arg);
    case VIDIOC_ENUM_FMT:
        return enum_format(f, arg);
    case VIDIOC_ENUM_FRAMESIZES:
        return enum_size(f, arg);
    case VIDIOC_ENUM_FRAMEINTERVALS:
        return enum_interval(f, arg);
    case VIDIOC_G_FMT:
    case VIDIOC_S_FMT:
        return format(f, arg, request == VIDIOC_S_FMT);
    case VIDIOC_G_PARM:
    case VIDIOC_S_PARM:
        return rate(f, arg);
    case VIDIOC_REQBUFS:
        return request_buffers(f, arg);
    case VIDIOC_QUERYBUF:
    case VIDIOC_QBUF:
    case VIDIOC_DQBUF:
        return buffer_call(f, request, arg);
    case VIDIOC_STREAMON:
    case VIDIOC_STREAMOFF:
        return stream(f, arg, request == VIDIOC_STREAMON);
    case VIDIOC_QUERYCTRL:
        return fake_query_control(f, arg) ? refuse(EINVAL) : 0;
    case VIDIOC_G_CTRL:
    case VIDIOC_S_CTRL: {
        const int code = fake_access_control(f, arg, request == VIDIOC_S_CTRL);
        return code ? refuse(code) : 0;
    }
    default:
        return refuse(ENOTTY);
    }
}

static void *fake_mmap(void *self, int fd, size_t length_bytes, int64_t offset_bytes)
{
    fake_v4l2 *f = self;
    const int64_t i = offset_bytes / STEP_BYTES;
    if (enter(f, 0))
        return NULL;
    if (fd != FD || offset_bytes % STEP_BYTES || i >= f->n_buffers || f->buffers[i].memory ||
        length_bytes != fake_v4l2_frame_bytes(f)) {
        errno = EINVAL;
        return NULL;
    }
    f->buffers[i].memory = calloc(1, length_bytes);
    f->n_mapped++;
    return f->buffers[i].memory;
}

static int fake_munmap(void *self, void *addr, size_t length_bytes)
{
    fake_v4l2 *f = self;
    assert_int_equal(length_bytes, fake_v4l2_frame_bytes(f));
    for (int i = 0; i < FAKE_MAX_BUFFERS; i++)
        if (f->buffers[i].memory == addr) {
            free(addr);
            f->buffers[i].memory = NULL;
            f->n_mapped--;
            return 0;
        }
    fail_msg("what was unmapped is no buffer");
    return -1;
}

static bool is_ready(const fake_v4l2 *f)
{
    bool ready = f->gone || !f->streaming; // POLLERR
    for (int i = 0; i < f->n_buffers; i++)
        ready = ready || f->buffers[i].done;
    return ready;
}

// Time passes here: frames come when they are due.
static int fake_wait(void *self, int fd, int wake_fd, int timeout_ms)
{
    fake_v4l2 *f = self;
    (void)wake_fd;
    if (enter(f, 0))
        return f->gone && f->n_calls != f->faults.fail_call ? SHEEN_V4L2_READY : -1;
    assert_int_equal(fd, FD);
    const int64_t until_ns = f->now_ns + (int64_t)timeout_ms * 1000000;
    while (!is_ready(f) && f->next_frame_ns <= until_ns) {
        f->now_ns = f->next_frame_ns;
        f->next_frame_ns += f->interval_ns;
        fake_expose(f);
    }
    if (is_ready(f))
        return SHEEN_V4L2_READY;
    f->now_ns = until_ns;
    return 0;
}

static int64_t fake_now_ns(void *self)
{
    return ((fake_v4l2 *)self)->now_ns;
}

size_t fake_v4l2_frame_bytes(const fake_v4l2 *f)
{
    size_t most = (size_t)f->stride_bytes * (size_t)f->height_px;
    for (size_t i = 0; i < f->n_payloads; i++)
        if (f->payload_bytes[i] > most)
            most = f->payload_bytes[i];
    return most;
}

bool fake_v4l2_is_clean(const fake_v4l2 *f)
{
    return !f->n_open && !f->n_mapped && !f->streaming;
}

void fake_v4l2_init(fake_v4l2 *f)
{
    *f = (fake_v4l2){.fourcc = V4L2_PIX_FMT_RGB24, .width_px = 32, .height_px = 24, .stride_bytes = 96};
    f->io = (sheen_v4l2_io){f,           fake_open, fake_ioctl, fake_mmap,
                            fake_munmap, fake_wait, fake_close, fake_now_ns};
    f->color = (sheen_colorimetry){V4L2_COLORSPACE_SRGB, V4L2_XFER_FUNC_NONE, 0,
                                   V4L2_QUANTIZATION_FULL_RANGE};
    f->interval_ns = 33333000;
    f->now_ns = 1000000000;
    fake_add_controls(f);
}

void fake_v4l2_play(fake_v4l2 *f, const sheen_session *s)
{
    sheen_err err;
    f->payloads = calloc(s->n_frames, sizeof *f->payloads);
    f->payload_bytes = calloc(s->n_frames, sizeof *f->payload_bytes);
    for (size_t i = 0; i < s->n_frames; i++) {
        const sheen_frame_info *g = &s->frames[i];
        assert_ok(sheen_session_payload(&f->payloads[i], &f->payload_bytes[i], s, g, &err), err);
        f->fourcc = g->fourcc ? g->fourcc : V4L2_PIX_FMT_MJPEG;
        f->width_px = g->width_px;
        f->height_px = g->height_px;
        f->stride_bytes = g->stride_bytes;
        f->color = g->color;
    }
    f->n_payloads = s->n_frames;
}

void fake_v4l2_release(fake_v4l2 *f)
{
    for (size_t i = 0; i < f->n_payloads; i++)
        free(f->payloads[i]);
    free(f->payloads);
    free(f->payload_bytes);
    f->payloads = NULL;
    f->payload_bytes = NULL;
    f->n_payloads = 0;
}

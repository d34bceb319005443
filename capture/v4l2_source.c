// SPDX-License-Identifier: Apache-2.0
// v4l2_source.c - v4l2:/dev/videoN, a camera as a source: its frames with the proof that its settings held.
//
// A frame is given out only if every locked setting was read back unchanged after it had come. One that was not is
// counted, the lock is set again and the picture settled anew; a camera that keeps doing it is given up.
#include "capture/v4l2_source.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <sys/eventfd.h>

#include "capture/source_backend.h"
#include "capture/v4l2_camera.h"
#include "capture/v4l2_prepare.h"

enum { MAX_RELOCKS = 3 };

typedef struct camera {
    const sheen_v4l2_io *io;
    sheen_v4l2_options options;
    int fd, wake_fd;
    char device[128];  // as it names itself, and its place
    char identity[80]; // what was plugged in when it was opened
    char lasting[256]; // by which it is found again; "": by the path alone
    sheen_v4l2_stream stream;
    sheen_v4l2_prepare prepare;
    int n_relocks; // in a row
} camera;

static void camera_close(void *self)
{
    camera *c = self;
    sheen_v4l2_stream_stop(&c->stream);
    if (c->fd >= 0)
        c->io->close(c->io->self, c->fd);
    if (c->wake_fd >= 0)
        close(c->wake_fd);
    free(c);
}

// Formats the opened node and starts its stream. Counts go on.
static sheen_status start_stream(camera *c, sheen_err *err)
{
    const sheen_source_counts counts = c->stream.counts;
    c->stream = (sheen_v4l2_stream){
        .io = c->io, .fd = c->fd, .wake_fd = c->wake_fd, .path = c->options.path, .counts = counts};
    c->prepare.stream = &c->stream;
    c->prepare.options = &c->options;
    sheen_status s = sheen_v4l2_camera_configure(&c->stream.format, &c->options, c->io, c->fd, err);
    if (!s && c->options.set_transfer)
        c->prepare.transfer = c->options.transfer;
    else if (!s)
        s = sheen_pixels_transfer(&c->prepare.transfer, c->stream.format.fourcc, &c->stream.format.color,
                                  err);
    return s ? s : sheen_v4l2_stream_start(&c->stream, err);
}

static sheen_status start(camera *c, sheen_err *err)
{
    const sheen_status s = start_stream(c, err);
    if (!s && c->options.lock)
        return sheen_v4l2_prepare_begin(&c->prepare, err);
    c->prepare.phase = SHEEN_V4L2_FINISHED;
    return s;
}

static void remember(camera *c)
{
    if (c->io->lasting_name)
        c->io->lasting_name(c->io->self, c->lasting, sizeof c->lasting, c->options.path);
    if (c->io->identity)
        c->io->identity(c->io->self, c->identity, sizeof c->identity, c->options.path);
}

static sheen_status open_camera(camera **out, const sheen_v4l2_io *io, const char *rest, sheen_err *err)
{
    camera *c = calloc(1, sizeof *c);
    if (!c)
        return sheen_fail_memory(err, sizeof *c, "a camera");
    c->io = io;
    c->fd = -1;
    c->wake_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    sheen_status s = c->wake_fd < 0
                         ? sheen_fail(err, SHEEN_EIO, "no file descriptor is left: close other programs")
                         : sheen_v4l2_options_parse(&c->options, rest, err);
    if (!s)
        s = sheen_v4l2_camera_open(&c->fd, c->device, io, c->options.path, err);
    if (!s)
        s = start(c, err);
    if (!s)
        remember(c);
    if (s)
        camera_close(c);
    else
        *out = c;
    return s;
}

static sheen_status camera_open(void **self_out, const char *rest, sheen_err *err)
{
    camera *c = NULL;
    const sheen_status s = open_camera(&c, &sheen_v4l2_kernel, rest, err);
    if (!s)
        *self_out = c;
    return s;
}

// Drivers that stamp the end of a frame: its exposure began at least this much earlier, which is all that is known.
static int64_t start_ns(const camera *c, const sheen_v4l2_frame *f)
{
    if (f->t_ns < 0 || !f->end_stamped)
        return f->t_ns;
    const double exposure_s = sheen_v4l2_lock_exposure_s(&c->prepare.lock);
    const int64_t t_ns = f->t_ns - c->stream.format.interval_ns - (int64_t)(1e9 * exposure_s);
    return t_ns > 0 ? t_ns : 0;
}

static void describe(const camera *c, const sheen_v4l2_frame *f, sheen_frame *frame)
{
    const sheen_v4l2_format *format = &c->stream.format;
    sheen_frame_info *info = &frame->info;
    info->width_px = format->width_px;
    info->height_px = format->height_px;
    info->fourcc = format->needed_bytes ? format->fourcc : 0;
    info->stride_bytes = format->stride_bytes;
    info->transfer = c->prepare.transfer;
    info->color = format->color;
    info->t_ns = start_ns(c, f);
    info->sequence = f->sequence;
    info->lock = c->options.lock ? SHEEN_LOCK_HELD : SHEEN_LOCK_OFF;
    snprintf(info->source, sizeof info->source, "v4l2:%.200s", c->options.path);
    snprintf(info->device, sizeof info->device, "%s", c->device);
    frame->extension = format->needed_bytes ? "raw" : "jpg";
    frame->data = f->data;
    frame->size_bytes = f->size_bytes;
}

// The proof. SHEEN_ETIMEOUT (and err left alone): this frame was not taken as the lock says, wait for others.
static sheen_status prove(camera *c, sheen_frame *frame, sheen_err *err)
{
    sheen_err what;
    sheen_status s = sheen_v4l2_lock_check(&c->prepare.lock, &frame->info, c->io, c->fd, c->options.path,
                                           &what);
    if (!s) {
        c->n_relocks = 0;
        return SHEEN_OK;
    }
    if (s != SHEEN_EDATA || ++c->n_relocks > MAX_RELOCKS)
        return err ? (*err = what).code : s;
    c->stream.counts.n_unlocked++;
    s = sheen_v4l2_lock_again(&c->prepare.lock, c->io, c->fd, c->options.path, err);
    sheen_v4l2_prepare_again(&c->prepare);
    return s ? s : SHEEN_ETIMEOUT;
}

static sheen_status camera_next(void *self, int timeout_ms, sheen_frame *frame, sheen_err *err)
{
    camera *c = self;
    const int64_t deadline_ns = c->io->now_ns(c->io->self) + (int64_t)timeout_ms * 1000000;
    for (;;) {
        const sheen_v4l2_frame *f;
        sheen_status s = sheen_v4l2_stream_next(&c->stream, deadline_ns, &f, err);
        if (s)
            return s;
        if (c->prepare.phase != SHEEN_V4L2_FINISHED)
            s = sheen_v4l2_prepare_frame(&c->prepare, f, start_ns(c, f), err);
        else {
            describe(c, f, frame);
            s = c->options.lock ? prove(c, frame, err) : SHEEN_OK;
            if (!s)
                return SHEEN_OK;
        }
        if (s && s != SHEEN_ETIMEOUT)
            return s;
        if (c->io->now_ns(c->io->self) >= deadline_ns)
            return sheen_fail(err, SHEEN_ETIMEOUT, "'%s' was not ready in time", c->options.path);
    }
}

static void let_go(camera *c)
{
    sheen_v4l2_stream_stop(&c->stream);
    if (c->fd >= 0)
        c->io->close(c->io->self, c->fd);
    c->fd = -1;
}

// Where it is looked for: the node's number may be another one now.
static const char *where(const camera *c)
{
    return c->lasting[0] ? c->lasting : c->options.path;
}

static sheen_status check_identity(const camera *c, const char *device, sheen_err *err)
{
    char identity[sizeof c->identity] = "";
    if (c->io->identity)
        c->io->identity(c->io->self, identity, sizeof identity, where(c));
    if (sheen_device_is_alike(device, c->device) && (!c->identity[0] || !strcmp(identity, c->identity)))
        return SHEEN_OK;
    return sheen_fail(
        err, SHEEN_ENODEV,
        "another camera is at '%.100s' now: %.60s %.40s instead of %.60s %.40s; plug the one that "
        "the session was begun with in again",
        where(c), device, identity, c->device, c->identity);
}

static sheen_status reopen(camera *c, sheen_err *err)
{
    char device[sizeof c->device];
    let_go(c);
    sheen_status s = sheen_v4l2_camera_open(&c->fd, device, c->io, where(c), err);
    if (!s)
        s = check_identity(c, device, err);
    if (!s) {
        snprintf(c->device, sizeof c->device, "%s", device);
        s = start_stream(c, err);
    }
    return s;
}

static sheen_status reset(camera *c, sheen_err *err)
{
    enum { BACK_MS = 10000 };
    if (!c->io->reset || !c->io->await || !c->identity[0])
        return sheen_fail(err, SHEEN_EUNSUP, "'%s' is no USB camera that could be reset", c->options.path);
    let_go(c);
    const int code = c->io->reset(c->io->self, c->identity);
    if (code == EACCES)
        return sheen_fail(err, SHEEN_EACCESS,
                          "no permission to reset the USB device of '%s': the udev rules of sheen give it",
                          c->options.path);
    if (code && code != ENODEV)
        return sheen_fail(err, SHEEN_EIO, "the USB device of '%s' cannot be reset: %s", c->options.path,
                          strerror(code));
    if (!c->io->await(c->io->self, where(c), c->wake_fd, BACK_MS))
        return sheen_fail(err, SHEEN_ENODEV, "'%s' did not come back after a reset", c->options.path);
    return reopen(c, err);
}

static sheen_status camera_recover(void *self, sheen_rung rung, sheen_err *err)
{
    camera *c = self;
    sheen_status s = SHEEN_OK;
    if (rung == SHEEN_RUNG_RESET)
        s = reset(c, err);
    else if (rung == SHEEN_RUNG_REOPEN || c->fd < 0)
        s = reopen(c, err);
    else {
        sheen_v4l2_stream_stop(&c->stream);
        s = start_stream(c, err);
    }
    if (!s && c->options.lock)
        s = sheen_v4l2_prepare_resume(&c->prepare, err);
    return s;
}

// Whoever holds the old node open keeps its number from the camera that comes back.
static bool camera_await(void *self, int timeout_ms)
{
    camera *c = self;
    let_go(c);
    return !c->io->await || c->io->await(c->io->self, where(c), c->wake_fd, timeout_ms);
}

static sheen_status camera_expose(void *self, double factor, double *exposure_s_out, sheen_err *err)
{
    camera *c = self;
    return sheen_v4l2_prepare_expose(&c->prepare, factor, exposure_s_out, err);
}

static sheen_status camera_follow(void *self, const sheen_frame_info *earlier, bool covered, bool *followed,
                                  sheen_err *err)
{
    camera *c = self;
    if (!c->options.lock || earlier->lock != SHEEN_LOCK_HELD || !earlier->n_controls ||
        !sheen_device_is_alike(earlier->device, c->device))
        return SHEEN_OK;
    *followed = true;
    return sheen_v4l2_prepare_follow(&c->prepare, earlier, covered, err);
}

static void camera_stop(void *self)
{
    const camera *c = self;
    const uint64_t one = 1;
    if (write(c->wake_fd, &one, sizeof one) < 0)
        return; // it is awake already
}

static void camera_counters(sheen_source_counts *out, const void *self)
{
    *out = ((const camera *)self)->stream.counts;
}

const sheen_source_backend sheen_source_v4l2 = {
    .scheme = "v4l2",
    .open = camera_open,
    .next = camera_next,
    .stop = camera_stop,
    .count = NULL,
    .counters = camera_counters,
    .recover = camera_recover,
    .expose = camera_expose,
    .follow = camera_follow,
    .await = camera_await,
    .close = camera_close,
};

sheen_status sheen_v4l2_source_open(sheen_source **src_out, const sheen_v4l2_io *io, const char *rest,
                                    sheen_err *err)
{
    camera *c = NULL;
    *src_out = NULL;
    const sheen_status s = open_camera(&c, io, rest, err);
    return s ? s : sheen_source_adopt(src_out, &sheen_source_v4l2, c, err);
}

// SPDX-License-Identifier: Apache-2.0
// v4l2_stream.c - buffers of a video node: requested, mapped, queued, waited for, copied, and given back.
#include "capture/v4l2_stream.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include <linux/videodev2.h>

#include "capture/v4l2_error.h"
#include "capture/v4l2_order.h"

enum { MIN_BUFFERS = 2 };

static struct v4l2_buffer a_buffer(int index)
{
    struct v4l2_buffer b;
    memset(&b, 0, sizeof b);
    b.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    b.memory = V4L2_MEMORY_MMAP;
    b.index = (uint32_t)index;
    return b;
}

static int request_buffers(sheen_v4l2_stream *s, uint32_t *count)
{
    struct v4l2_requestbuffers r;
    memset(&r, 0, sizeof r);
    r.count = *count;
    r.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    r.memory = V4L2_MEMORY_MMAP;
    const int result = sheen_v4l2_ioctl(s->io, s->fd, VIDIOC_REQBUFS, &r);
    *count = r.count;
    return result;
}

static sheen_status map_one(sheen_v4l2_stream *s, int i, sheen_err *err)
{
    struct v4l2_buffer b = a_buffer(i);
    if (sheen_v4l2_ioctl(s->io, s->fd, VIDIOC_QUERYBUF, &b) < 0)
        return sheen_v4l2_fail(err, errno, "get a buffer of", s->path);
    if (b.length < s->format.needed_bytes)
        return sheen_fail(err, SHEEN_EIO,
                          "'%s' has buffers of %lu bytes for frames of %zu: its driver is wrong", s->path,
                          (unsigned long)b.length, s->format.needed_bytes);
    do
        s->buffers[i] = s->io->mmap(s->io->self, s->fd, b.length, b.m.offset);
    while (!s->buffers[i] && errno == EINTR);
    if (!s->buffers[i])
        return sheen_v4l2_fail(err, errno, "map a buffer of", s->path);
    s->lengths_bytes[i] = b.length;
    s->n_buffers = i + 1;
    return SHEEN_OK;
}

static sheen_status map_buffers(sheen_v4l2_stream *s, sheen_err *err)
{
    uint32_t count = SHEEN_V4L2_MAX_BUFFERS;
    if (request_buffers(s, &count) < 0)
        return sheen_v4l2_fail(err, errno, "get buffers of", s->path);
    if (count < MIN_BUFFERS)
        return sheen_fail(err, SHEEN_ENOMEM,
                          "'%s' gives %lu buffers, fewer than it takes to stream: close other "
                          "programs, or ask for a smaller size",
                          s->path, (unsigned long)count);
    if (count > SHEEN_V4L2_MAX_BUFFERS)
        count = SHEEN_V4L2_MAX_BUFFERS;
    for (int i = 0; i < (int)count; i++) {
        const sheen_status st = map_one(s, i, err);
        if (st)
            return st;
    }
    for (size_t i = 0; i < SHEEN_V4L2_HOLD + 1; i++) {
        s->slots[i].data = malloc(s->format.size_bytes);
        if (!s->slots[i].data)
            return sheen_fail_memory(err, (double)s->format.size_bytes, "a frame");
    }
    return SHEEN_OK;
}

// Gives every buffer that is not there back to the driver. One that is refused is tried again the next time.
static sheen_status queue_all(sheen_v4l2_stream *s, sheen_err *err)
{
    int n_queued = 0, code = 0;
    for (int i = 0; i < s->n_buffers; i++) {
        struct v4l2_buffer b = a_buffer(i);
        if (!s->queued[i]) {
            s->queued[i] = sheen_v4l2_ioctl(s->io, s->fd, VIDIOC_QBUF, &b) == 0;
            if (!s->queued[i])
                code = errno;
        }
        n_queued += s->queued[i];
    }
    if (code == ENODEV || n_queued < MIN_BUFFERS)
        return sheen_v4l2_fail(err, code, "give a buffer back to", s->path);
    return SHEEN_OK;
}

sheen_status sheen_v4l2_stream_start(sheen_v4l2_stream *s, sheen_err *err)
{
    sheen_status st = map_buffers(s, err);
    if (!st)
        st = queue_all(s, err);
    if (!st) {
        int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        if (sheen_v4l2_ioctl(s->io, s->fd, VIDIOC_STREAMON, &type) < 0)
            st = sheen_v4l2_fail(err, errno, "start the stream of", s->path);
        else
            s->on = true;
    }
    if (st)
        sheen_v4l2_stream_stop(s);
    return st;
}

void sheen_v4l2_stream_stop(sheen_v4l2_stream *s)
{
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    uint32_t none = 0;
    if (s->on)
        sheen_v4l2_ioctl(s->io, s->fd, VIDIOC_STREAMOFF, &type); // all buffers are ours again
    for (int i = 0; i < s->n_buffers; i++)
        s->io->munmap(s->io->self, s->buffers[i], s->lengths_bytes[i]);
    if (s->n_buffers)
        request_buffers(s, &none);
    for (size_t i = 0; i < SHEEN_V4L2_HOLD + 1; i++) {
        free(s->slots[i].data);
        s->slots[i] = (sheen_v4l2_frame){0};
    }
    memset(s->queued, 0, sizeof s->queued);
    s->n_buffers = 0;
    s->lent = NULL;
    s->on = s->begun = false;
}

bool sheen_v4l2_jpeg_whole(const uint8_t *data, size_t size_bytes)
{
    while (size_bytes > 4 && !data[size_bytes - 1])
        size_bytes--;
    return size_bytes > 4 && data[0] == 0xff && data[1] == 0xd8 && data[size_bytes - 2] == 0xff &&
           data[size_bytes - 1] == 0xd9;
}

// Whether a buffer holds a whole frame; what it does not is counted.
static bool is_good(sheen_v4l2_stream *s, const struct v4l2_buffer *b)
{
    const size_t used = b->bytesused;
    if (b->flags & V4L2_BUF_FLAG_ERROR)
        s->counts.n_flagged++;
    else if (used > s->lengths_bytes[b->index] || used > s->format.size_bytes ||
             used < s->format.needed_bytes ||
             (!s->format.needed_bytes && !sheen_v4l2_jpeg_whole(s->buffers[b->index], used)))
        s->counts.n_short++;
    else
        return true;
    return false;
}

static int64_t stamp_of(const struct v4l2_buffer *b)
{
    if ((b->flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC)
        return -1;
    return (int64_t)b->timestamp.tv_sec * 1000000000 + (int64_t)b->timestamp.tv_usec * 1000;
}

static void take_buffer(sheen_v4l2_stream *s, const struct v4l2_buffer *b)
{
    sheen_v4l2_frame *f = sheen_v4l2_order_enter(s, b->sequence, stamp_of(b));
    const bool good = is_good(s, b);
    if (!f)
        return; // came after its turn
    f->rejected = !good;
    f->end_stamped = (b->flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) != V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
    f->size_bytes = good ? b->bytesused : 0;
    if (good)
        memcpy(f->data, s->buffers[b->index], f->size_bytes);
}

// One finished buffer, if there is one.
static sheen_status dequeue(sheen_v4l2_stream *s, sheen_err *err)
{
    struct v4l2_buffer b = a_buffer(0);
    if (sheen_v4l2_ioctl(s->io, s->fd, VIDIOC_DQBUF, &b) < 0)
        return errno == EAGAIN ? SHEEN_OK : sheen_v4l2_fail(err, errno, "get a frame from", s->path);
    if (b.index >= (uint32_t)s->n_buffers)
        return sheen_fail(err, SHEEN_EIO, "'%s' gave a buffer that it was not given: its driver is wrong",
                          s->path);
    s->queued[b.index] = false;
    take_buffer(s, &b);
    return queue_all(s, err);
}

// Waits for a buffer until until_ns. ETIMEOUT leaves err alone.
static sheen_status wait_for_buffer(sheen_v4l2_stream *s, int64_t until_ns, sheen_err *err)
{
    const int64_t left_ns = until_ns - s->io->now_ns(s->io->self);
    if (left_ns < 0)
        return SHEEN_ETIMEOUT;
    const int64_t left_ms = (left_ns + 999999) / 1000000;
    const int ready = s->io->wait(s->io->self, s->fd, s->wake_fd, left_ms > 60000 ? 60000 : (int)left_ms);
    if (ready < 0 && errno != EINTR && errno != EAGAIN)
        return sheen_v4l2_fail(err, errno, "wait for", s->path);
    if (ready > 0 && ready & SHEEN_V4L2_WOKEN)
        return sheen_fail(err, SHEEN_ECANCEL, "the camera was stopped");
    return ready > 0 ? dequeue(s, err) : SHEEN_OK;
}

sheen_status sheen_v4l2_stream_next(sheen_v4l2_stream *s, int64_t deadline_ns,
                                    const sheen_v4l2_frame **frame_out, sheen_err *err)
{
    if (s->lent)
        s->lent->used = false;
    s->lent = NULL;
    bool waited = false; // a deadline that has passed still gets what is ready
    for (;;) {
        const int64_t now_ns = s->io->now_ns(s->io->self);
        const int64_t give_up_ns = sheen_v4l2_order_patience(s, deadline_ns);
        s->lent = sheen_v4l2_order_take(s, now_ns >= give_up_ns && waited);
        if (s->lent) {
            *frame_out = s->lent;
            s->counts.n_frames++;
            return SHEEN_OK;
        }
        if (now_ns >= deadline_ns && waited)
            return sheen_fail(
                err, SHEEN_ETIMEOUT,
                "no frame came from '%s' in time: look at its cable, and whether its shutter is open",
                s->path);
        const int64_t until_ns = give_up_ns > now_ns ? give_up_ns : now_ns;
        const sheen_status st = wait_for_buffer(s, until_ns, err);
        if (st && st != SHEEN_ETIMEOUT)
            return st;
        waited = true;
    }
}

// SPDX-License-Identifier: Apache-2.0
// fake_queue.c - the fake camera's buffers and stream, by the rules of the kernel's videobuf2 with mmap only.
#include <errno.h>
#include <string.h>

#include "tests/fake/fake_parts.h"

enum { TYPE = V4L2_BUF_TYPE_VIDEO_CAPTURE };

static uint32_t abilities(const fake_v4l2 *f)
{
    return V4L2_BUF_CAP_SUPPORTS_MMAP | (f->arena ? V4L2_BUF_CAP_SUPPORTS_ORPHANED_BUFS : 0);
}

static void add_buffers(fake_v4l2 *f, int n, size_t length_bytes)
{
    for (int i = f->n_buffers; i < f->n_buffers + n; i++) {
        memset(&f->buffers[i], 0, sizeof f->buffers[i]);
        f->buffers[i].length_bytes = length_bytes;
        f->buffers[i].memory = f->arena ? f->arena + (size_t)i * FAKE_STEP_BYTES : NULL;
    }
    f->n_buffers += n;
}

void fake_queue_free(fake_v4l2 *f)
{
    f->streaming = false;
    f->n_buffers = 0;
}

static int request_buffers(fake_v4l2 *f, struct v4l2_requestbuffers *r, int i_file)
{
    if (r->type != TYPE || r->memory != V4L2_MEMORY_MMAP)
        return EINVAL;
    r->capabilities = abilities(f);
    r->flags = 0;
    memset(r->reserved, 0, sizeof r->reserved);
    if (f->streaming || f->n_mapped || (f->n_buffers && f->owner != i_file))
        return EBUSY;
    const int n = r->count > FAKE_MAX_BUFFERS ? FAKE_MAX_BUFFERS : (int)r->count;
    fake_queue_free(f);
    add_buffers(f, n, fake_v4l2_frame_bytes(f));
    f->owner = i_file;
    r->count = (uint32_t)n;
    return 0;
}

static int create_buffers(fake_v4l2 *f, struct v4l2_create_buffers *c, int i_file)
{
    if (c->format.type != TYPE || c->memory != V4L2_MEMORY_MMAP)
        return EINVAL;
    c->capabilities = abilities(f);
    c->flags = 0;
    memset(c->reserved, 0, sizeof c->reserved);
    c->index = (uint32_t)f->n_buffers;
    if (!c->count)
        return 0;
    if (f->n_buffers && f->owner != i_file)
        return EBUSY;
    if (c->format.fmt.pix.sizeimage < fake_v4l2_frame_bytes(f) ||
        c->format.fmt.pix.sizeimage > FAKE_STEP_BYTES)
        return EINVAL;
    const int room = FAKE_MAX_BUFFERS - f->n_buffers;
    if (!room)
        return ENOBUFS;
    c->count = c->count > (uint32_t)room ? (uint32_t)room : c->count;
    add_buffers(f, (int)c->count, c->format.fmt.pix.sizeimage);
    f->owner = i_file;
    return 0;
}

static void describe_buffer(const fake_v4l2 *f, struct v4l2_buffer *b)
{
    const uint32_t i = b->index;
    memset(b, 0, sizeof *b);
    b->index = i;
    b->type = TYPE;
    b->memory = V4L2_MEMORY_MMAP;
    b->length = (uint32_t)f->buffers[i].length_bytes;
    b->m.offset = i * (uint32_t)FAKE_STEP_BYTES;
    b->flags = f->faults.stamps_none ? V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN : V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
    b->flags |= f->faults.stamps_end ? V4L2_BUF_FLAG_TSTAMP_SRC_EOF : V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
    b->flags |= f->buffers[i].mapped ? V4L2_BUF_FLAG_MAPPED : 0;
    b->flags |= f->buffers[i].prepared && !f->buffers[i].queued && !f->buffers[i].done
                    ? V4L2_BUF_FLAG_PREPARED
                    : 0;
    b->flags |= f->buffers[i].queued ? V4L2_BUF_FLAG_QUEUED : 0;
    b->flags |= f->buffers[i].done ? V4L2_BUF_FLAG_DONE : 0;
    b->flags |= f->buffers[i].flagged ? V4L2_BUF_FLAG_ERROR : 0;
    b->bytesused = (uint32_t)f->buffers[i].bytes_used;
    b->sequence = f->buffers[i].sequence;
    b->field = V4L2_FIELD_NONE;
    b->timestamp.tv_sec = f->buffers[i].t_ns / 1000000000;
    b->timestamp.tv_usec = f->buffers[i].t_ns % 1000000000 / 1000;
}

static int dequeue(fake_v4l2 *f, struct v4l2_buffer *b)
{
    int first = -1;
    if (!f->streaming)
        return EINVAL;
    for (int i = 0; i < f->n_buffers; i++)
        if (f->buffers[i].done && !f->buffers[i].held &&
            (first < 0 || f->buffers[i].order < f->buffers[first].order))
            first = i;
    if (first < 0)
        return EAGAIN;
    f->buffers[first].done = f->buffers[first].prepared = false;
    b->index = (uint32_t)first;
    describe_buffer(f, b);
    return 0;
}

static int queue(fake_v4l2 *f, struct v4l2_buffer *b, bool prepare_only)
{
    const uint32_t i = b->index;
    if (f->buffers[i].queued || f->buffers[i].done || (prepare_only && f->buffers[i].prepared) ||
        (!f->arena && !f->buffers[i].memory))
        return EINVAL;
    f->buffers[i].prepared = true;
    f->buffers[i].queued = !prepare_only;
    f->buffers[i].flagged = false;
    f->buffers[i].bytes_used = 0;
    f->buffers[i].queued_order = f->n_given++;
    describe_buffer(f, b);
    return 0;
}

static int buffer_call(fake_v4l2 *f, unsigned long request, struct v4l2_buffer *b, int i_file)
{
    if (b->type != TYPE)
        return EINVAL;
    if (request != VIDIOC_QUERYBUF && f->n_buffers && f->owner != i_file)
        return EBUSY;
    if (request != VIDIOC_QUERYBUF && b->memory != V4L2_MEMORY_MMAP)
        return EINVAL;
    if (request == VIDIOC_DQBUF)
        return dequeue(f, b);
    if (b->index >= (uint32_t)f->n_buffers)
        return EINVAL;
    if (request != VIDIOC_QUERYBUF)
        return b->flags & V4L2_BUF_FLAG_REQUEST_FD ? EBADR : queue(f, b, request == VIDIOC_PREPARE_BUF);
    describe_buffer(f, b);
    return 0;
}

static int stream(fake_v4l2 *f, const int *type, bool on, int i_file)
{
    if (*type != TYPE)
        return EINVAL;
    if (f->n_buffers && f->owner != i_file)
        return EBUSY;
    if (on && !f->n_buffers)
        return EINVAL;
    if (on && f->streaming)
        return 0;
    f->streaming = on;
    f->next_frame_ns = f->now_ns + f->interval_ns;
    f->first_frame = f->n_frames;
    for (int i = 0; !on && i < f->n_buffers; i++)
        f->buffers[i].queued = f->buffers[i].done = f->buffers[i].prepared = false;
    return 0;
}

int fake_queue_call(fake_v4l2 *f, unsigned long request, void *arg, int i_file)
{
    switch (request) {
    case VIDIOC_REQBUFS:
        return request_buffers(f, arg, i_file);
    case VIDIOC_CREATE_BUFS:
        return create_buffers(f, arg, i_file);
    case VIDIOC_QUERYBUF:
    case VIDIOC_QBUF:
    case VIDIOC_DQBUF:
    case VIDIOC_PREPARE_BUF:
        return buffer_call(f, request, arg, i_file);
    case VIDIOC_STREAMON:
    case VIDIOC_STREAMOFF:
        if (request == VIDIOC_STREAMON)
            fake_v4l2_treat(f, FAKE_RESTART);
        return stream(f, arg, request == VIDIOC_STREAMON, i_file);
    default:
        return ENOTTY;
    }
}

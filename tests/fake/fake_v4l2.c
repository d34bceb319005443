// SPDX-License-Identifier: Apache-2.0
// fake_v4l2.c - the state machine: files, calls, faults that were planned.
#include "tests/fake/fake_v4l2.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/fake/fake_parts.h"

static int refuse(int code)
{
    errno = code;
    return -1;
}

void fake_v4l2_tick(fake_v4l2 *f)
{
    f->now_ns = f->clock_ns ? f->clock_ns() : f->now_ns + 1000;
    if (f->gone && f->faults.return_after_ns && f->now_ns >= f->unplugged_ns + f->faults.return_after_ns) {
        f->gone = false;
        f->node = f->faults.return_node;
        f->faults.unplug_at = f->faults.return_after_ns = 0;
        f->identity = f->faults.return_as ? f->faults.return_as : FAKE_IDENTITY;
        if (!f->n_payloads)
            fake_add_controls(f);
    }
}

void fake_v4l2_unplug(fake_v4l2 *f)
{
    f->gone = true;
    f->unplugged_ns = f->now_ns;
    for (int i = 0; i < FAKE_MAX_FILES; i++)
        f->files[i].gone = f->files[i].open;
    fake_queue_free(f);
}

int fake_v4l2_enter(fake_v4l2 *f, unsigned long request)
{
    fake_v4l2_tick(f);
    if (++f->n_calls == f->faults.fail_call) {
        if (f->faults.fail_errno == ENODEV)
            fake_v4l2_unplug(f);
        return refuse(f->faults.fail_errno);
    }
    if (request && request == f->faults.fail_request)
        return refuse(f->faults.fail_request_errno);
    return 0;
}

void fake_v4l2_treat(fake_v4l2 *f, fake_remedy by)
{
    if (f->faults.cure && by >= f->faults.cure && f->faults.stall_at && f->n_frames >= f->faults.stall_at)
        f->faults.stall_at = 0;
}

bool fake_v4l2_is_node(const fake_v4l2 *f, const char *path)
{
    char node[32];
    snprintf(node, sizeof node, "/dev/video%d", f->node);
    return !strcmp(path, node) || !strcmp(path, FAKE_LINK);
}

int fake_v4l2_open(fake_v4l2 *f, const char *path)
{
    int i = 0;
    if (fake_v4l2_enter(f, 0))
        return -1;
    if (f->gone || !fake_v4l2_is_node(f, path))
        return refuse(ENOENT);
    while (i < FAKE_MAX_FILES && f->files[i].open)
        i++;
    if (i == FAKE_MAX_FILES)
        return refuse(EMFILE);
    f->files[i] = (fake_file){.open = true, .priority = V4L2_PRIORITY_DEFAULT};
    f->n_open++;
    fake_v4l2_treat(f, FAKE_REOPEN);
    return FAKE_FD + i;
}

int fake_file_of(const fake_v4l2 *f, int fd)
{
    const int i = fd - FAKE_FD;
    return i >= 0 && i < FAKE_MAX_FILES && f->files[i].open ? i : -1;
}

void fake_v4l2_close(fake_v4l2 *f, int fd)
{
    const int i = fake_file_of(f, fd);
    if (i < 0)
        return;
    f->files[i].open = false;
    f->n_open--;
    if (f->owner == i)
        fake_queue_free(f);
}

// Calls that change something must wait while another file has a higher priority.
static bool needs_priority(unsigned long request)
{
    static const unsigned long calls[] = {
        VIDIOC_S_FMT,       VIDIOC_S_PARM,      VIDIOC_S_INPUT,  VIDIOC_S_CTRL,    VIDIOC_REQBUFS,
        VIDIOC_CREATE_BUFS, VIDIOC_S_EXT_CTRLS, VIDIOC_STREAMON, VIDIOC_STREAMOFF, VIDIOC_S_PRIORITY};
    for (size_t i = 0; i < sizeof calls / sizeof *calls; i++)
        if (calls[i] == request)
            return true;
    return false;
}

static uint32_t highest_priority(const fake_v4l2 *f)
{
    uint32_t most = 0;
    for (int i = 0; i < FAKE_MAX_FILES; i++)
        if (f->files[i].open && f->files[i].priority > most)
            most = f->files[i].priority;
    return most;
}

static int set_priority(fake_file *file, uint32_t priority)
{
    if (priority < V4L2_PRIORITY_BACKGROUND || priority > V4L2_PRIORITY_RECORD)
        return EINVAL;
    file->priority = priority;
    return 0;
}

static int dispatch(fake_v4l2 *f, unsigned long request, void *arg, int i_file)
{
    fake_file *file = &f->files[i_file];
    switch (request) {
    case VIDIOC_G_PRIORITY:
        *(uint32_t *)arg = highest_priority(f);
        return 0;
    case VIDIOC_S_PRIORITY:
        return set_priority(file, *(const uint32_t *)arg);
    case VIDIOC_QUERYCTRL:
        return fake_query_control(f, arg);
    case VIDIOC_QUERY_EXT_CTRL:
        return fake_query_ext_control(f, arg);
    case VIDIOC_QUERYMENU:
        return fake_query_menu(f, arg);
    case VIDIOC_G_CTRL:
    case VIDIOC_S_CTRL:
        return fake_access_control(f, arg, request == VIDIOC_S_CTRL, i_file);
    case VIDIOC_G_EXT_CTRLS:
    case VIDIOC_S_EXT_CTRLS:
    case VIDIOC_TRY_EXT_CTRLS:
        return fake_ext_controls(f, request, arg, i_file);
    case VIDIOC_SUBSCRIBE_EVENT:
    case VIDIOC_UNSUBSCRIBE_EVENT:
        return fake_subscribe(f, file, arg, request == VIDIOC_SUBSCRIBE_EVENT);
    case VIDIOC_DQEVENT:
        return fake_take_event(f, file, arg);
    default: {
        const int code = fake_format_call(f, request, arg);
        return code == ENOTTY ? fake_queue_call(f, request, arg, i_file) : code;
    }
    }
}

int fake_v4l2_ioctl(fake_v4l2 *f, int fd, unsigned long request, void *arg)
{
    const int i = fake_file_of(f, fd);
    if (fake_v4l2_enter(f, request))
        return -1;
    if (i < 0)
        return refuse(EBADF);
    if (f->gone || f->files[i].gone)
        return refuse(ENODEV);
    if (needs_priority(request) && f->files[i].priority < highest_priority(f))
        return refuse(EBUSY);
    const int code = dispatch(f, request, arg, i);
    return code ? refuse(code) : 0;
}

int fake_v4l2_poll(const fake_v4l2 *f, int fd)
{
    const int i = fake_file_of(f, fd);
    int events = i >= 0 && fake_has_event(&f->files[i]) ? POLLPRI : 0;
    if (i < 0 || f->gone || f->files[i].gone)
        return POLLERR | POLLHUP;
    if (!f->streaming || f->owner != i)
        return events | POLLERR;
    for (int k = 0; k < f->n_buffers; k++)
        if (f->buffers[k].done && !f->buffers[k].held)
            return events | POLLIN | POLLRDNORM;
    return events;
}

void fake_v4l2_run(fake_v4l2 *f, int64_t until_ns)
{
    while (f->streaming && f->next_frame_ns <= until_ns) {
        f->now_ns = f->next_frame_ns;
        f->next_frame_ns += f->interval_ns;
        fake_expose(f);
    }
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

void fake_v4l2_reset(fake_v4l2 *f)
{
    *f = (fake_v4l2){.fourcc = V4L2_PIX_FMT_RGB24, .width_px = 32, .height_px = 24, .stride_bytes = 96};
    f->color = (sheen_colorimetry){V4L2_COLORSPACE_SRGB, V4L2_XFER_FUNC_NONE, 0,
                                   V4L2_QUANTIZATION_FULL_RANGE};
    f->interval_ns = 33333000;
    f->owner = -1;
    f->identity = FAKE_IDENTITY;
    f->now_ns = 1000000000;
    fake_add_controls(f);
}

void fake_v4l2_release(fake_v4l2 *f)
{
    for (size_t i = 0; i < f->n_payloads; i++)
        free(f->payloads[i]);
    free(f->payloads);
    free(f->payload_bytes);
    free(f->recorded);
    f->payloads = NULL;
    f->payload_bytes = NULL;
    f->recorded = NULL;
    f->n_payloads = 0;
}

// SPDX-License-Identifier: Apache-2.0
// fake_seam.c - the fake camera's face in process: our own seam, where time passes by waiting only, unless clock_ns is
// set: then it is that clock's, which must be CLOCK_MONOTONIC.
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "tests/fake/fake_parts.h"
#include "tests/support.h"

static int seam_open(void *self, const char *path)
{
    return fake_v4l2_open(self, path);
}

static int seam_ioctl(void *self, int fd, unsigned long request, void *arg)
{
    return fake_v4l2_ioctl(self, fd, request, arg);
}

static int seam_close(void *self, int fd)
{
    fake_v4l2 *f = self;
    assert_true(fake_file_of(f, fd) >= 0);
    fake_v4l2_close(f, fd);
    return 0;
}

static void *seam_mmap(void *self, int fd, size_t length_bytes, int64_t offset_bytes)
{
    fake_v4l2 *f = self;
    const int64_t i = offset_bytes / FAKE_STEP_BYTES;
    if (fake_v4l2_enter(f, 0))
        return NULL;
    if (f->gone) {
        errno = ENODEV;
        return NULL;
    }
    if (fake_file_of(f, fd) < 0 || offset_bytes % FAKE_STEP_BYTES || i >= f->n_buffers ||
        f->buffers[i].memory || length_bytes != f->buffers[i].length_bytes) {
        errno = EINVAL;
        return NULL;
    }
    f->buffers[i].memory = calloc(1, length_bytes);
    f->buffers[i].mapped = true;
    f->n_mapped++;
    return f->buffers[i].memory;
}

static int seam_munmap(void *self, void *addr, size_t length_bytes)
{
    fake_v4l2 *f = self;
    for (int i = 0; i < FAKE_MAX_BUFFERS; i++)
        if (f->buffers[i].memory == addr) {
            assert_int_equal(length_bytes, f->buffers[i].length_bytes);
            free(addr);
            f->buffers[i].memory = NULL;
            f->buffers[i].mapped = f->buffers[i].queued = f->buffers[i].done = false;
            f->n_mapped--;
            return 0;
        }
    fail_msg("what was unmapped is no buffer");
    return -1;
}

static void sleep_until(int64_t t_ns)
{
    const struct timespec t = {(time_t)(t_ns / 1000000000), (long)(t_ns % 1000000000)};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL);
}

// By the machine's clock: what was due while nobody waited has come (and was lost, where no buffer was queued).
static int wait_by_clock(fake_v4l2 *f, int fd, int64_t until_ns)
{
    for (;;) {
        const int64_t now_ns = f->clock_ns();
        fake_v4l2_run(f, now_ns);
        f->now_ns = now_ns;
        if (fake_v4l2_poll(f, fd))
            return SHEEN_V4L2_READY;
        if (now_ns >= until_ns)
            return 0;
        sleep_until(f->streaming && f->next_frame_ns < until_ns ? f->next_frame_ns : until_ns);
    }
}

// Time passes here: frames come when they are due.
static int seam_wait(void *self, int fd, int wake_fd, int timeout_ms)
{
    fake_v4l2 *f = self;
    (void)wake_fd;
    if (fake_v4l2_enter(f, 0))
        return -1;
    assert_true(fake_file_of(f, fd) >= 0);
    const int64_t until_ns = f->now_ns + (int64_t)timeout_ms * 1000000;
    if (f->clock_ns)
        return wait_by_clock(f, fd, until_ns);
    while (!fake_v4l2_poll(f, fd) && f->streaming && f->next_frame_ns <= until_ns)
        fake_v4l2_run(f, f->next_frame_ns);
    if (fake_v4l2_poll(f, fd))
        return SHEEN_V4L2_READY;
    f->now_ns = until_ns;
    return 0;
}

static int64_t seam_now_ns(void *self)
{
    const fake_v4l2 *f = self;
    return f->clock_ns ? f->clock_ns() : f->now_ns;
}

static void seam_lasting_name(void *self, char *name, size_t size_bytes, const char *path)
{
    snprintf(name, size_bytes, "%s", fake_v4l2_is_node(self, path) ? FAKE_LINK : "");
}

static void seam_identity(void *self, char *text, size_t size_bytes, const char *path)
{
    const fake_v4l2 *f = self;
    snprintf(text, size_bytes, "%s", f->gone || !fake_v4l2_is_node(f, path) ? "" : f->identity);
}

static int seam_reset(void *self, const char *identity)
{
    fake_v4l2 *f = self;
    assert_string_equal(identity, FAKE_IDENTITY);
    assert_int_equal(f->n_open, 0);
    if (f->gone)
        return ENOENT;
    f->n_resets++;
    fake_v4l2_treat(f, FAKE_USB_RESET);
    fake_add_controls(f);
    return 0;
}

// As a wait for udev: it is not counted among the calls that may fail.
static int seam_await(void *self, const char *path, int wake_fd, int timeout_ms)
{
    fake_v4l2 *f = self;
    (void)wake_fd;
    assert_int_equal(f->n_open, 0); // whoever holds the old node open keeps its number from the camera
    if (f->gone) {
        f->now_ns += (int64_t)timeout_ms * 1000000;
        fake_v4l2_tick(f);
    }
    return !f->gone && fake_v4l2_is_node(f, path);
}

void fake_v4l2_init(fake_v4l2 *f)
{
    fake_v4l2_reset(f);
    f->io = (sheen_v4l2_io){.self = f,
                            .open = seam_open,
                            .ioctl = seam_ioctl,
                            .mmap = seam_mmap,
                            .munmap = seam_munmap,
                            .wait = seam_wait,
                            .close = seam_close,
                            .now_ns = seam_now_ns,
                            .lasting_name = seam_lasting_name,
                            .identity = seam_identity,
                            .reset = seam_reset,
                            .await = seam_await};
}

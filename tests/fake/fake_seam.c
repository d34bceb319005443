// SPDX-License-Identifier: Apache-2.0
// fake_seam.c - the fake camera's face in process: our own seam, where time passes by waiting only.
#include <errno.h>
#include <stdlib.h>

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

// Time passes here: frames come when they are due.
static int seam_wait(void *self, int fd, int wake_fd, int timeout_ms)
{
    fake_v4l2 *f = self;
    (void)wake_fd;
    if (fake_v4l2_enter(f, 0))
        return -1;
    assert_true(fake_file_of(f, fd) >= 0);
    const int64_t until_ns = f->now_ns + (int64_t)timeout_ms * 1000000;
    while (!fake_v4l2_poll(f, fd) && f->streaming && f->next_frame_ns <= until_ns)
        fake_v4l2_run(f, f->next_frame_ns);
    if (fake_v4l2_poll(f, fd))
        return SHEEN_V4L2_READY;
    f->now_ns = until_ns;
    return 0;
}

static int64_t seam_now_ns(void *self)
{
    return ((fake_v4l2 *)self)->now_ns;
}

void fake_v4l2_init(fake_v4l2 *f)
{
    fake_v4l2_reset(f);
    f->io = (sheen_v4l2_io){f,           seam_open, seam_ioctl, seam_mmap,
                            seam_munmap, seam_wait, seam_close, seam_now_ns};
}

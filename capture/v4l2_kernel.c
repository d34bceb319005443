// SPDX-License-Identifier: Apache-2.0
// v4l2_kernel.c - the seam's real side: system calls, and what udev and libusb know of the device.
#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include "capture/devices.h"
#include "capture/v4l2_io.h"

static int kernel_open(void *self, const char *path)
{
    (void)self;
    return open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC);
}

static int kernel_ioctl(void *self, int fd, unsigned long request, void *arg)
{
    (void)self;
    return ioctl(fd, request, arg);
}

static void *kernel_mmap(void *self, int fd, size_t length_bytes, int64_t offset_bytes)
{
    (void)self;
    void *addr = mmap(NULL, length_bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, (off_t)offset_bytes);
    return addr == MAP_FAILED ? NULL : addr;
}

static int kernel_munmap(void *self, void *addr, size_t length_bytes)
{
    (void)self;
    return munmap(addr, length_bytes);
}

// What is wrong with a node (POLLERR, POLLHUP) is told by the next DQBUF.
static int kernel_wait(void *self, int fd, int wake_fd, int timeout_ms)
{
    (void)self;
    struct pollfd fds[2] = {{.fd = fd, .events = POLLIN}, {.fd = wake_fd, .events = POLLIN}};
    const int n = poll(fds, wake_fd < 0 ? 1 : 2, timeout_ms);
    if (n <= 0)
        return n;
    return (fds[0].revents ? SHEEN_V4L2_READY : 0) | (fds[1].revents ? SHEEN_V4L2_WOKEN : 0);
}

static int kernel_close(void *self, int fd)
{
    (void)self;
    return close(fd);
}

static int64_t kernel_now_ns(void *self)
{
    (void)self;
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static void kernel_lasting_name(void *self, char *name, size_t size_bytes, const char *path)
{
    (void)self;
    sheen_device_lasting_name(name, size_bytes, path);
}

static void kernel_identity(void *self, char *text, size_t size_bytes, const char *path)
{
    (void)self;
    sheen_device_identity(text, size_bytes, path);
}

static int kernel_reset(void *self, const char *identity)
{
    (void)self;
    return sheen_device_reset(identity);
}

static int kernel_await(void *self, const char *path, int wake_fd, int timeout_ms)
{
    (void)self;
    return sheen_device_await(path, wake_fd, timeout_ms);
}

const sheen_v4l2_io sheen_v4l2_kernel = {
    .self = NULL,
    .open = kernel_open,
    .ioctl = kernel_ioctl,
    .mmap = kernel_mmap,
    .munmap = kernel_munmap,
    .wait = kernel_wait,
    .close = kernel_close,
    .now_ns = kernel_now_ns,
    .lasting_name = kernel_lasting_name,
    .identity = kernel_identity,
    .reset = kernel_reset,
    .await = kernel_await,
};

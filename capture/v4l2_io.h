// SPDX-License-Identifier: Apache-2.0
// v4l2_io.h - the seam between our V4L2 code and the kernel: everything that it asks of a video node.
//
// Each function means what the call it is named after means, with its return values and errno, where nothing else is
// said. `self` is handed back as the first argument. Tests put a camera of their own behind it (tests/fake).
#ifndef SHEEN_CAPTURE_V4L2_IO_H
#define SHEEN_CAPTURE_V4L2_IO_H

#include <stddef.h>
#include <stdint.h>

enum { SHEEN_V4L2_READY = 1, SHEEN_V4L2_WOKEN = 2 };

typedef struct sheen_v4l2_io {
    void *self;
    int (*open)(void *self, const char *path); // O_RDWR | O_NONBLOCK | O_CLOEXEC
    int (*ioctl)(void *self, int fd, unsigned long request, void *arg);
    void *(*mmap)(void *self, int fd, size_t length_bytes, int64_t offset_bytes); // shared; NULL: failed
    int (*munmap)(void *self, void *addr, size_t length_bytes);
    // Waits until fd has a buffer (or an error) to give, or wake_fd (-1: none) can be read. 0: time is over; -1:
    // errno; else SHEEN_V4L2_READY, SHEEN_V4L2_WOKEN, or both.
    int (*wait)(void *self, int fd, int wake_fd, int timeout_ms);
    int (*close)(void *self, int fd);
    int64_t (*now_ns)(void *self); // CLOCK_MONOTONIC, the clock of the buffers' timestamps
    // What follows may be NULL: it cannot be had here.
    // The name of the node that stays with the camera when it is unplugged and comes back; "" where there is none.
    void (*lasting_name)(void *self, char *name, size_t size_bytes, const char *path);
    // What is plugged in at the node, so that another camera of the same make can be told: "046d:0825 SERIAL"; "": unknown.
    void (*identity)(void *self, char *text, size_t size_bytes, const char *path);
    // Resets the USB device that was plugged in as `identity` says. 0, or errno; ENOENT: there is none.
    int (*reset)(void *self, const char *identity);
    // Waits until the node may be there (1), time is over (0), or wake_fd can be read (0).
    int (*await)(void *self, const char *path, int wake_fd, int timeout_ms);
} sheen_v4l2_io;

extern const sheen_v4l2_io sheen_v4l2_kernel; // v4l2_kernel.c

#endif

// SPDX-License-Identifier: Apache-2.0
// fake_preload_calls.c - the calls of the C library that lead to a video node, caught; all others go where they went.
#define _GNU_SOURCE // NOLINT: RTLD_NEXT
#undef _FORTIFY_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/select.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include "tests/fake/fake_preload.h"

enum { SLICE_MS = 5 };

// The next definition of this function, which ours hides.
#define REAL(name, ...)                                                                                      \
    static __VA_ARGS__;                                                                                      \
    if (!real) {                                                                                             \
        void *at = dlsym(RTLD_NEXT, name);                                                                   \
        memcpy(&real, &at, sizeof at);                                                                       \
    }

static mode_t mode_of(int flags, va_list more)
{
    return flags & (O_CREAT | O_TMPFILE) ? va_arg(more, mode_t) : 0;
}

#define DEFINE_OPEN(function)                                                                                \
    int function(const char *path, int flags, ...)                                                           \
    {                                                                                                        \
        REAL(#function, int (*real)(const char *, int, ...))                                                 \
        va_list more;                                                                                        \
        va_start(more, flags);                                                                               \
        const mode_t mode = mode_of(flags, more);                                                            \
        va_end(more);                                                                                        \
        return fake_camera_has_path(path) ? fake_camera_open(path, flags) : real(path, flags, mode);         \
    }
DEFINE_OPEN(open)
DEFINE_OPEN(open64)

#define DEFINE_OPENAT(function)                                                                              \
    int function(int dir, const char *path, int flags, ...)                                                  \
    {                                                                                                        \
        REAL(#function, int (*real)(int, const char *, int, ...))                                            \
        va_list more;                                                                                        \
        va_start(more, flags);                                                                               \
        const mode_t mode = mode_of(flags, more);                                                            \
        va_end(more);                                                                                        \
        return fake_camera_has_path(path) ? fake_camera_open(path, flags) : real(dir, path, flags, mode);    \
    }
DEFINE_OPENAT(openat)
DEFINE_OPENAT(openat64)

// What programs built with FORTIFY call.
#define DEFINE_OPEN_2(function)                                                                              \
    int function(const char *path, int flags);                                                               \
    int function(const char *path, int flags)                                                                \
    {                                                                                                        \
        REAL(#function, int (*real)(const char *, int))                                                      \
        return fake_camera_has_path(path) ? fake_camera_open(path, flags) : real(path, flags);               \
    }
DEFINE_OPEN_2(__open_2)   // NOLINT
DEFINE_OPEN_2(__open64_2) // NOLINT

int close(int fd)
{
    REAL("close", int (*real)(int))
    if (fake_camera_has_fd(fd))
        fake_camera_close(fd);
    return real(fd);
}

int ioctl(int fd, unsigned long request, ...)
{
    REAL("ioctl", int (*real)(int, unsigned long, ...))
    va_list more;
    va_start(more, request);
    void *arg = va_arg(more, void *);
    va_end(more);
    return fake_camera_has_fd(fd) ? fake_camera_ioctl(fd, request, arg) : real(fd, request, arg);
}

#define DEFINE_MMAP(function)                                                                                \
    void *function(void *at_address, size_t length, int protection, int flags, int fd, off_t offset)         \
    {                                                                                                        \
        REAL(#function, void *(*real)(void *, size_t, int, int, int, off_t))                                 \
        int file = fd;                                                                                       \
        if (fd > 0 && !(flags & MAP_ANONYMOUS) && fake_camera_has_fd(fd) &&                                  \
            !fake_camera_map(&file, fd, length, offset))                                                     \
            return MAP_FAILED;                                                                               \
        return real(at_address, length, protection, flags, file, offset);                                    \
    }
DEFINE_MMAP(mmap)
DEFINE_MMAP(mmap64)

// The camera can be neither read nor written.
ssize_t read(int fd, void *data, size_t size)
{
    REAL("read", ssize_t(*real)(int, void *, size_t))
    if (fake_camera_has_fd(fd)) {
        errno = EINVAL;
        return -1;
    }
    return real(fd, data, size);
}

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int answer_poll(struct pollfd *fds, nfds_t n)
{
    int ready = 0;
    for (nfds_t i = 0; i < n; i++) {
        if (fds[i].fd >= 0 && fake_camera_has_fd(fds[i].fd))
            fds[i].revents = (short)(fake_camera_poll(fds[i].fd) & (fds[i].events | POLLERR | POLLHUP));
        ready += fds[i].revents != 0;
    }
    return ready;
}

// In slices: what an eventfd cannot tell (POLLPRI) is looked up between them.
int poll(struct pollfd *fds, nfds_t n, int timeout_ms)
{
    REAL("poll", int (*real)(struct pollfd *, nfds_t, int))
    const double until_s = now_s() + timeout_ms / 1e3;
    bool any = false;
    for (nfds_t i = 0; i < n; i++)
        any = any || (fds[i].fd >= 0 && fake_camera_has_fd(fds[i].fd));
    if (!any)
        return real(fds, n, timeout_ms);
    for (;;) {
        const int r = real(fds, n, 0), ready = r < 0 ? r : answer_poll(fds, n);
        if (ready || (timeout_ms >= 0 && now_s() >= until_s))
            return ready;
        const int left_ms = timeout_ms < 0 ? SLICE_MS : (int)(1e3 * (until_s - now_s())) + 1;
        const int slept = real(fds, n, left_ms < SLICE_MS ? left_ms : SLICE_MS);
        if (slept < 0)
            return slept;
    }
}

// One fake file's part in a select(): its bits in the answer, taken out of what the kernel is asked.
static int answer_select(int n, const fd_set ask[3], fd_set answer[3])
{
    static const int events[3] = {POLLIN | POLLERR | POLLHUP, POLLOUT, POLLPRI};
    int ready = 0;
    for (int fd = 0; fd < n; fd++)
        for (int k = 0; k < 3; k++)
            if (FD_ISSET(fd, &ask[k]) && fake_camera_has_fd(fd)) {
                const bool is = (fake_camera_poll(fd) & events[k]) != 0;
                if (is)
                    FD_SET(fd, &answer[k]);
                ready += is;
            }
    return ready;
}

int select(int n, fd_set *in, fd_set *out, fd_set *except, struct timeval *timeout)
{
    REAL("select", int (*real)(int, fd_set *, fd_set *, fd_set *, struct timeval *))
    fd_set *sets[3] = {in, out, except}, ask[3], others[3], answer[3];
    bool any = false;
    for (int k = 0; k < 3; k++) {
        FD_ZERO(&ask[k]);
        if (sets[k])
            ask[k] = *sets[k];
        others[k] = ask[k];
        for (int fd = 0; fd < n; fd++)
            if (FD_ISSET(fd, &ask[k]) && fake_camera_has_fd(fd)) {
                any = true;
                FD_CLR(fd, &others[k]);
            }
    }
    if (!any)
        return real(n, in, out, except, timeout);
    const double until_s = timeout ? now_s() + (double)timeout->tv_sec + 1e-6 * (double)timeout->tv_usec
                                   : 1e300;
    for (;;) {
        struct timeval slice = {0, 1000};
        memcpy(answer, others, sizeof answer);
        int ready = real(n, &answer[0], &answer[1], &answer[2], &slice);
        if (ready < 0)
            return ready;
        ready += answer_select(n, ask, answer);
        if (ready || now_s() >= until_s) {
            for (int k = 0; k < 3; k++)
                if (sets[k])
                    *sets[k] = answer[k];
            return ready;
        }
    }
}

#define DEFINE_STAT(function, type)                                                                          \
    int function(const char *path, struct type *st)                                                          \
    {                                                                                                        \
        REAL(#function, int (*real)(const char *, struct type *))                                            \
        if (!fake_camera_has_path(path))                                                                     \
            return real(path, st);                                                                           \
        memset(st, 0, sizeof *st);                                                                           \
        st->st_mode = S_IFCHR | 0660;                                                                        \
        st->st_rdev = makedev(81, (unsigned)fake_camera_node());                                             \
        return 0;                                                                                            \
    }
DEFINE_STAT(stat, stat)
DEFINE_STAT(lstat, stat)
DEFINE_STAT(stat64, stat64)
DEFINE_STAT(lstat64, stat64)

#define DEFINE_FSTAT(function, type)                                                                         \
    int function(int fd, struct type *st)                                                                    \
    {                                                                                                        \
        REAL(#function, int (*real)(int, struct type *))                                                     \
        const int r = real(fd, st);                                                                          \
        if (!r && fake_camera_has_fd(fd)) {                                                                  \
            st->st_mode = S_IFCHR | 0660;                                                                    \
            st->st_rdev = makedev(81, (unsigned)fake_camera_node());                                         \
        }                                                                                                    \
        return r;                                                                                            \
    }
DEFINE_FSTAT(fstat, stat)
DEFINE_FSTAT(fstat64, stat64)

int access(const char *path, int mode)
{
    REAL("access", int (*real)(const char *, int))
    return fake_camera_has_path(path) ? 0 : real(path, mode);
}

// How v4l2-ctl finds out what kind of device a node is. libstdc++ reads the descriptor: it must be a file.
static FILE *open_uevent(const char *path)
{
    char wanted[64], text[64];
    const int node = fake_camera_node();
    snprintf(wanted, sizeof wanted, "/sys/dev/char/81:%d/uevent", node);
    const int fd = strcmp(path, wanted) != 0 ? -1 : memfd_create("uevent", MFD_CLOEXEC);
    if (fd < 0)
        return NULL;
    const int n = snprintf(text, sizeof text, "MAJOR=81\nMINOR=%d\nDEVNAME=video%d\n", node, node);
    return pwrite(fd, text, (size_t)n, 0) == n ? fdopen(fd, "r") : NULL;
}

#define DEFINE_FOPEN(function)                                                                               \
    FILE *function(const char *path, const char *mode)                                                       \
    {                                                                                                        \
        REAL(#function, FILE *(*real)(const char *, const char *))                                           \
        FILE *file = open_uevent(path);                                                                      \
        return file ? file : real(path, mode);                                                               \
    }
DEFINE_FOPEN(fopen)
DEFINE_FOPEN(fopen64)

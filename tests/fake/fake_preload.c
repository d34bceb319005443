// SPDX-License-Identifier: Apache-2.0
// fake_preload.c - the fake camera's other face: /dev/videoN for a program that knows nothing of it (with_camera.c).
//
// An opened node is an eventfd, kept readable while the camera's state would wake a select() for reading, so that any
// way of waiting works on it. Buffers lie in one memfd, which mappings of the node are sent to. A thread makes frames on
// the machine's clock. Memory that a program hands in is copied by the kernel, so that a bad pointer gives EFAULT.
#define _GNU_SOURCE // NOLINT: memfd_create, process_vm_readv
#include "tests/fake/fake_preload.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>

#include "tests/fake/fake_parts.h"

enum { MAX_ARGUMENT_BYTES = 1 << 14, MAX_EXT_CONTROLS = 1024 };

static fake_v4l2 camera;
static pthread_mutex_t lock = PTHREAD_RECURSIVE_MUTEX_INITIALIZER_NP; // our own mmap() comes by here, too
static int memory_fd = -1;
static bool runs; // the thread
static struct {
    int fd; // the eventfd; 0: none
    bool raised;
} files[FAKE_MAX_FILES];

static int64_t clock_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static void give_up(const char *why)
{
    fprintf(stderr, "fake camera: %s\n", why);
    _exit(99);
}

static void take_lock(void)
{
    pthread_mutex_lock(&lock);
}

static void leave_lock(void)
{
    pthread_mutex_unlock(&lock);
}

static void load_recording(const char *file)
{
    struct stat st;
    const int fd = (int)strtol(file, NULL, 10);
    if (fstat(fd, &st) || st.st_size < (off_t)sizeof(fake_recording))
        give_up("the recording was not handed over");
    uint8_t *data = mmap(NULL, (size_t)st.st_size, PROT_READ, MAP_PRIVATE, fd, 0);
    const fake_recording *r = (const void *)data;
    if (data == MAP_FAILED || memcmp(r->magic, FAKE_MAGIC, sizeof r->magic) != 0)
        give_up("the recording is not one");
    const fake_recorded_frame *frames = (const void *)(data + sizeof *r);
    camera.payloads = calloc(r->n_frames, sizeof *camera.payloads);
    camera.payload_bytes = calloc(r->n_frames, sizeof *camera.payload_bytes);
    camera.recorded = calloc(r->n_frames, sizeof *camera.recorded);
    if (!camera.payloads || !camera.payload_bytes || !camera.recorded)
        give_up("out of memory");
    for (size_t i = 0; i < r->n_frames; i++) {
        camera.payloads[i] = data + frames[i].at_bytes;
        camera.payload_bytes[i] = frames[i].size_bytes;
        camera.recorded[i] = frames[i].info;
    }
    camera.n_payloads = r->n_frames;
    camera.fourcc = r->fourcc;
    camera.width_px = (int)r->width_px;
    camera.height_px = (int)r->height_px;
    camera.stride_bytes = (int)r->stride_bytes;
    camera.color = r->color;
    fake_play_settings(&camera, 0);
}

static void __attribute__((constructor)) make_camera(void)
{
    const char *plan = getenv(FAKE_ENV_PLAN), *file = getenv(FAKE_ENV_FILE);
    fake_v4l2_reset(&camera);
    camera.clock_ns = clock_ns;
    camera.now_ns = clock_ns();
    if (file)
        load_recording(file);
    const char *wrong = plan ? fake_v4l2_plan(&camera, plan) : NULL;
    if (wrong)
        give_up(wrong);
    pthread_atfork(take_lock, leave_lock, leave_lock);
}

static bool make_arena(void)
{
    const size_t size_bytes = (size_t)FAKE_MAX_BUFFERS * FAKE_STEP_BYTES;
    if (camera.arena)
        return true;
    memory_fd = memfd_create("fake camera", MFD_CLOEXEC);
    if (memory_fd < 0 || ftruncate(memory_fd, (off_t)size_bytes))
        return false;
    void *arena = mmap(NULL, size_bytes, PROT_READ | PROT_WRITE, MAP_SHARED, memory_fd, 0);
    if (arena == MAP_FAILED)
        return false;
    camera.arena = arena;
    return true;
}

// Each eventfd can be read exactly while its file has something to say.
static void raise_files(void)
{
    for (int i = 0; i < FAKE_MAX_FILES; i++) {
        eventfd_t one = 1;
        const bool want = files[i].fd && fake_v4l2_poll(&camera, FAKE_FD + i) & ~POLLPRI;
        if (!files[i].fd || want == files[i].raised)
            continue;
        files[i].raised = want;
        if (want ? eventfd_write(files[i].fd, one) : eventfd_read(files[i].fd, &one))
            give_up("its eventfd failed");
    }
}

static void *make_frames(void *unused)
{
    (void)unused;
    for (;;) {
        take_lock();
        const int64_t now_ns = clock_ns();
        fake_v4l2_run(&camera, now_ns);
        raise_files();
        const int64_t soon_ns = now_ns + 5000000;
        const int64_t next_ns = camera.streaming && camera.next_frame_ns < soon_ns ? camera.next_frame_ns
                                                                                   : soon_ns;
        leave_lock();
        const struct timespec until = {next_ns / 1000000000, next_ns % 1000000000};
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL);
    }
    return NULL;
}

static void start_thread(void)
{
    pthread_t thread;
    if (runs)
        return;
    runs = pthread_create(&thread, NULL, make_frames, NULL) == 0;
    if (!runs)
        give_up("no thread");
    pthread_detach(thread);
}

static int index_of(int fd)
{
    for (int i = 0; fd > 0 && i < FAKE_MAX_FILES; i++)
        if (files[i].fd == fd)
            return i;
    return -1;
}

bool fake_camera_has_fd(int fd)
{
    take_lock();
    const bool has = index_of(fd) >= 0;
    leave_lock();
    return has;
}

bool fake_camera_has_path(const char *path)
{
    return path && !strncmp(path, "/dev/v", 6) && fake_v4l2_is_node(&camera, path) && !camera.gone;
}

int fake_camera_node(void)
{
    return camera.node;
}

int fake_camera_open(const char *path, int flags)
{
    take_lock();
    const int made = make_arena() ? fake_v4l2_open(&camera, path) : -1;
    int fd = -1;
    if (made >= 0) {
        fd = eventfd(0, EFD_CLOEXEC | (flags & O_NONBLOCK ? EFD_NONBLOCK : 0));
        if (fd < 0)
            fake_v4l2_close(&camera, made);
        else {
            files[made - FAKE_FD].fd = fd;
            files[made - FAKE_FD].raised = false;
            start_thread();
            raise_files();
        }
    }
    leave_lock();
    return fd;
}

int fake_camera_close(int fd)
{
    take_lock();
    const int i = index_of(fd);
    if (i >= 0) {
        fake_v4l2_close(&camera, FAKE_FD + i);
        files[i].fd = 0;
        raise_files();
    }
    leave_lock();
    return i;
}

// From the program's memory, or into it. A pointer that leads nowhere: EFAULT.
static bool copy(void *ours, void *theirs, size_t size_bytes, bool into_theirs)
{
    const struct iovec a = {ours, size_bytes}, b = {theirs, size_bytes};
    const ssize_t n = !size_bytes   ? 0
                      : into_theirs ? process_vm_writev(getpid(), &a, 1, &b, 1, 0)
                                    : process_vm_readv(getpid(), &a, 1, &b, 1, 0);
    if (n == (ssize_t)size_bytes)
        return true;
    errno = EFAULT;
    return false;
}

static int call(int i, unsigned long request, void *arg)
{
    take_lock();
    const int r = fake_v4l2_ioctl(&camera, FAKE_FD + i, request, arg);
    const int code = errno;
    raise_files();
    leave_lock();
    errno = code;
    return r;
}

// A call that the driver does not have is refused before its argument is looked at.
static bool knows(unsigned long request)
{
    static const unsigned long calls[] = {
        VIDIOC_QUERYCAP,    VIDIOC_ENUM_FMT,      VIDIOC_ENUM_FRAMESIZES, VIDIOC_ENUM_FRAMEINTERVALS,
        VIDIOC_G_FMT,       VIDIOC_TRY_FMT,       VIDIOC_S_FMT,           VIDIOC_G_PARM,
        VIDIOC_S_PARM,      VIDIOC_ENUMINPUT,     VIDIOC_G_INPUT,         VIDIOC_S_INPUT,
        VIDIOC_REQBUFS,     VIDIOC_CREATE_BUFS,   VIDIOC_QUERYBUF,        VIDIOC_QBUF,
        VIDIOC_DQBUF,       VIDIOC_PREPARE_BUF,   VIDIOC_STREAMON,        VIDIOC_STREAMOFF,
        VIDIOC_G_PRIORITY,  VIDIOC_S_PRIORITY,    VIDIOC_QUERYCTRL,       VIDIOC_QUERY_EXT_CTRL,
        VIDIOC_QUERYMENU,   VIDIOC_G_CTRL,        VIDIOC_S_CTRL,          VIDIOC_G_EXT_CTRLS,
        VIDIOC_S_EXT_CTRLS, VIDIOC_TRY_EXT_CTRLS, VIDIOC_SUBSCRIBE_EVENT, VIDIOC_UNSUBSCRIBE_EVENT,
        VIDIOC_DQEVENT,
    };
    for (size_t i = 0; i < sizeof calls / sizeof *calls; i++)
        if (calls[i] == request)
            return true;
    return false;
}

// A list of controls lies in memory of its own.
static int call_with_list(int i, unsigned long request, struct v4l2_ext_controls *c)
{
    struct v4l2_ext_control list[MAX_EXT_CONTROLS], *theirs = c->controls;
    const size_t size_bytes = c->count * sizeof *list;
    if (c->count > MAX_EXT_CONTROLS) {
        errno = EINVAL;
        return -1;
    }
    if (!copy(list, theirs, size_bytes, false))
        return -1;
    c->controls = list;
    const int r = call(i, request, c), code = errno;
    c->controls = theirs;
    if (!copy(list, theirs, size_bytes, true))
        return -1;
    errno = code;
    return r;
}

// A blocking DQBUF waits until there is something to say.
static void wait_for_frame(int i, int fd)
{
    const struct timespec a_little = {0, 1000000};
    for (;;) {
        take_lock();
        const int events = fake_v4l2_poll(&camera, FAKE_FD + i) & ~POLLPRI;
        leave_lock();
        if (events || fcntl(fd, F_GETFL) & O_NONBLOCK)
            return;
        nanosleep(&a_little, NULL);
    }
}

int fake_camera_ioctl(int fd, unsigned long request, void *arg)
{
    _Alignas(16) uint8_t local[MAX_ARGUMENT_BYTES];
    request &= 0xffffffff; // some programs hand it in as an int
    const size_t size_bytes = _IOC_SIZE(request);
    take_lock();
    const int i = index_of(fd);
    leave_lock();
    if (!knows(request)) {
        errno = ENOTTY;
        return -1;
    }
    if (!copy(local, arg, size_bytes, false))
        return -1;
    if (request == VIDIOC_DQBUF)
        wait_for_frame(i, fd);
    const bool list = request == VIDIOC_G_EXT_CTRLS || request == VIDIOC_S_EXT_CTRLS ||
                      request == VIDIOC_TRY_EXT_CTRLS;
    const int r = list ? call_with_list(i, request, (void *)local) : call(i, request, local);
    const int code = errno;
    if ((!r || list) && _IOC_DIR(request) & _IOC_READ && !copy(local, arg, size_bytes, true))
        return -1;
    errno = code;
    return r;
}

bool fake_camera_map(int *file, int fd, size_t length_bytes, off_t offset_bytes)
{
    take_lock();
    const int64_t i = offset_bytes / FAKE_STEP_BYTES;
    const bool fine = index_of(fd) >= 0 && offset_bytes % FAKE_STEP_BYTES == 0 && i < camera.n_buffers &&
                      length_bytes <= (camera.buffers[i].length_bytes + 4095) / 4096 * 4096;
    if (fine)
        camera.buffers[i].mapped = true;
    leave_lock();
    *file = memory_fd;
    errno = EINVAL;
    return fine;
}

int fake_camera_poll(int fd)
{
    take_lock();
    const int events = fake_v4l2_poll(&camera, FAKE_FD + index_of(fd));
    leave_lock();
    return events;
}

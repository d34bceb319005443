// SPDX-License-Identifier: Apache-2.0
// libcamera_inbox.c - a ring under a mutex, and an eventfd that wakes whoever waits.
#include "capture/libcamera_inbox.h"

#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <unistd.h>

#include <sys/eventfd.h>

#include "base/clock.h"

struct sheen_libcamera_inbox {
    int wake_fd;           // counts what happened: a request is finished, unplugged, stopped
    atomic_bool stopped;   // set from anywhere
    pthread_mutex_t mutex; // of the rest
    void *requests[SHEEN_LIBCAMERA_MAX_REQUESTS];
    int i_first, n_requests;
    bool unplugged;
};

sheen_status sheen_libcamera_inbox_open(sheen_libcamera_inbox **inbox_out, sheen_err *err)
{
    sheen_libcamera_inbox *inbox = calloc(1, sizeof *inbox);
    *inbox_out = NULL;
    if (!inbox)
        return sheen_fail(err, SHEEN_ENOMEM, "out of memory");
    inbox->wake_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (inbox->wake_fd < 0) {
        free(inbox);
        return sheen_fail(err, SHEEN_EIO, "no file descriptor is left: close other programs");
    }
    pthread_mutex_init(&inbox->mutex, NULL);
    *inbox_out = inbox;
    return SHEEN_OK;
}

void sheen_libcamera_inbox_close(sheen_libcamera_inbox **inbox)
{
    if (!*inbox)
        return;
    close((*inbox)->wake_fd);
    pthread_mutex_destroy(&(*inbox)->mutex);
    free(*inbox);
    *inbox = NULL;
}

static void wake(const sheen_libcamera_inbox *inbox)
{
    const uint64_t one = 1;
    if (write(inbox->wake_fd, &one, sizeof one) < 0)
        return; // it is awake already
}

void sheen_libcamera_inbox_put(sheen_libcamera_inbox *inbox, void *request)
{
    pthread_mutex_lock(&inbox->mutex);
    if (inbox->n_requests < SHEEN_LIBCAMERA_MAX_REQUESTS) // there are never more
        inbox->requests[(inbox->i_first + inbox->n_requests++) % SHEEN_LIBCAMERA_MAX_REQUESTS] = request;
    pthread_mutex_unlock(&inbox->mutex);
    wake(inbox);
}

void sheen_libcamera_inbox_unplug(sheen_libcamera_inbox *inbox)
{
    pthread_mutex_lock(&inbox->mutex);
    inbox->unplugged = true;
    pthread_mutex_unlock(&inbox->mutex);
    wake(inbox);
}

bool sheen_libcamera_inbox_is_unplugged(sheen_libcamera_inbox *inbox)
{
    pthread_mutex_lock(&inbox->mutex);
    const bool unplugged = inbox->unplugged;
    pthread_mutex_unlock(&inbox->mutex);
    return unplugged;
}

void sheen_libcamera_inbox_stop(sheen_libcamera_inbox *inbox)
{
    inbox->stopped = true;
    wake(inbox);
}

void sheen_libcamera_inbox_clear(sheen_libcamera_inbox *inbox)
{
    pthread_mutex_lock(&inbox->mutex);
    inbox->n_requests = 0;
    inbox->unplugged = false;
    pthread_mutex_unlock(&inbox->mutex);
}

// The first request, NULL where there is none; *unplugged as it is then.
static void *pop(sheen_libcamera_inbox *inbox, bool *unplugged)
{
    void *request = NULL;
    pthread_mutex_lock(&inbox->mutex);
    if (inbox->n_requests) {
        request = inbox->requests[inbox->i_first];
        inbox->i_first = (inbox->i_first + 1) % SHEEN_LIBCAMERA_MAX_REQUESTS;
        inbox->n_requests--;
    }
    *unplugged = inbox->unplugged;
    pthread_mutex_unlock(&inbox->mutex);
    return request;
}

void sheen_libcamera_inbox_sleep(sheen_libcamera_inbox *inbox, int timeout_ms)
{
    struct pollfd wait = {.fd = inbox->wake_fd, .events = POLLIN};
    uint64_t n;
    if (poll(&wait, 1, timeout_ms) > 0 && read(inbox->wake_fd, &n, sizeof n) < 0)
        return; // somebody else was quicker: whoever waits looks for himself
}

sheen_status sheen_libcamera_inbox_take(sheen_libcamera_inbox *inbox, int64_t deadline_ns, const char *name,
                                        void **request, sheen_err *err)
{
    enum { LONGEST_MS = 60000 };
    for (;;) {
        bool unplugged;
        if (inbox->stopped)
            return sheen_fail(err, SHEEN_ECANCEL, "the camera was stopped");
        *request = pop(inbox, &unplugged);
        if (*request)
            return SHEEN_OK;
        if (unplugged)
            return sheen_fail(
                err, SHEEN_ENODEV,
                "cannot get a frame from '%.80s': the camera is gone; plug it in and give the same "
                "command again",
                name);
        const int64_t left_ns = deadline_ns - sheen_clock_ns();
        if (left_ns <= 0)
            return sheen_fail(err, SHEEN_ETIMEOUT, "no frame came from '%.80s' in time: look at its cable",
                              name);
        const int64_t left_ms = left_ns / 1000000 + 1;
        sheen_libcamera_inbox_sleep(inbox, (int)(left_ms < LONGEST_MS ? left_ms : LONGEST_MS));
    }
}

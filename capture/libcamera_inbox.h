// SPDX-License-Identifier: Apache-2.0
// libcamera_inbox.h - finished requests on their way from libcamera's thread to the one that reads frames.
//
// Any thread may put; one takes. A request is a pointer that the inbox never follows.
#ifndef SHEEN_CAPTURE_LIBCAMERA_INBOX_H
#define SHEEN_CAPTURE_LIBCAMERA_INBOX_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SHEEN_LIBCAMERA_MAX_REQUESTS = 32 }; // in the inbox at once

typedef struct sheen_libcamera_inbox sheen_libcamera_inbox;

// ENOMEM, EIO (no file descriptor is left).
sheen_status sheen_libcamera_inbox_open(sheen_libcamera_inbox **inbox_out, sheen_err *err);
void sheen_libcamera_inbox_close(sheen_libcamera_inbox **inbox);

void sheen_libcamera_inbox_put(sheen_libcamera_inbox *inbox, void *request);
// The device was unplugged: told once what was finished has been taken.
void sheen_libcamera_inbox_unplug(sheen_libcamera_inbox *inbox);
bool sheen_libcamera_inbox_is_unplugged(sheen_libcamera_inbox *inbox);
// Ends the waiting for good; also from a signal handler.
void sheen_libcamera_inbox_stop(sheen_libcamera_inbox *inbox);
// Forgets requests, and that a device was unplugged.
void sheen_libcamera_inbox_clear(sheen_libcamera_inbox *inbox);

// The next finished request, or why there is none until deadline_ns (CLOCK_MONOTONIC). ETIMEOUT, ECANCEL (stopped), ENODEV
// (unplugged). name: of the camera, for the sentence.
sheen_status sheen_libcamera_inbox_take(sheen_libcamera_inbox *inbox, int64_t deadline_ns, const char *name,
                                        void **request, sheen_err *err);
// Sleeps until something happens, timeout_ms at most.
void sheen_libcamera_inbox_sleep(sheen_libcamera_inbox *inbox, int timeout_ms);

#ifdef __cplusplus
}
#endif
#endif

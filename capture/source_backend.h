// SPDX-License-Identifier: Apache-2.0
// source_backend.h - what a kind of source provides. To add one: fill in this struct in a file of its own
// and list it in source.c.
#ifndef SHEEN_CAPTURE_SOURCE_BACKEND_H
#define SHEEN_CAPTURE_SOURCE_BACKEND_H

#include "capture/source.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_source_backend {
    // What stands before the colon of its URIs: "replay". Lower case, unique.
    const char *scheme;

    // Opens the device or recording named by `rest`, the URI after the colon (not empty), and makes it ready to
    // deliver; may block for as long as a device takes to answer. On success *self_out is the backend's own state,
    // which the other functions get; on failure nothing stays open and *self_out is not looked at. The sentence
    // need not name the URI: the caller does.
    sheen_status (*open)(void **self_out, const char *rest, sheen_err *err);

    // Waits at most timeout_ms for the next frame and describes it in *frame, which comes with its info filled
    // in as unknown and everything else zero. The payload, the mask and the extension must stay where they are
    // until the next call of `next` or `close`. info.source is set here: where this very payload first came from.
    // ETIMEOUT: none yet, may be called again. EEND: no more will come. ENODEV: the device went away. ECANCEL:
    // `stop` was called while it waited. After anything but OK and ETIMEOUT it is not called again, unless `recover`
    // has succeeded meanwhile.
    sheen_status (*next)(void *self, int timeout_ms, sheen_frame *frame, sheen_err *err);

    // Wakes a `next` that waits in another thread. Called from any thread or a signal handler, so it may only do
    // what is async-signal-safe (write to an eventfd). NULL where `next` never waits.
    void (*stop)(void *self);

    // Number of frames in all, or -1. NULL: never known.
    int64_t (*count)(const void *self);

    // What became of its frames. NULL: a recording, which loses none.
    void (*counters)(sheen_source_counts *out, const void *self);

    // Tries to make a device deliver again that has stalled, failed or come back: one rung of the ladder (ladder.h).
    // The settings of the session are set and proven anew before the next frame is given out. EUNSUP: has no such
    // remedy, try the next; ENODEV: it is not there. After a failure it may be called again, as may `close`. NULL: a
    // recording.
    sheen_status (*recover)(void *self, sheen_rung rung, sheen_err *err);
    // As sheen_source_expose. NULL: cannot.
    sheen_status (*expose)(void *self, double factor, double *exposure_s_out, sheen_err *err);
    // As sheen_source_follow. NULL: has no settings.
    sheen_status (*follow)(void *self, const sheen_frame_info *earlier, bool covered, bool *followed,
                           sheen_err *err);
    // Waits at most timeout_ms for a device that went away; true as soon as it may be there. NULL: just tries again.
    bool (*await)(void *self, int timeout_ms);

    // Closes and frees everything, whatever state it is in. Never fails.
    void (*close)(void *self);
} sheen_source_backend;

extern const sheen_source_backend sheen_source_replay;    // replay.c
extern const sheen_source_backend sheen_source_v4l2;      // v4l2_source.c
extern const sheen_source_backend sheen_source_libcamera; // libcamera_source.cc, where the build has it

// A source over a backend's state that was opened by other means. Takes `self` over, also where it fails (ENOMEM).
sheen_status sheen_source_adopt(sheen_source **src_out, const sheen_source_backend *backend, void *self,
                                sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

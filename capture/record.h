// SPDX-License-Identifier: Apache-2.0
// record.h - frames from a source into a session, payload exactly as delivered plus its sidecar.
#ifndef SHEEN_CAPTURE_RECORD_H
#define SHEEN_CAPTURE_RECORD_H

#include "base/progress.h"
#include "base/session.h"
#include "capture/source.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_record_options {
    size_t count;   // stop after so many frames; 0: when the source ends
    int timeout_ms; // longest wait for a sign of life of the source; 0: 10 s
    bool set_role;  // give every frame `role` instead of the source's own
    sheen_role role;
    // Of a live source: asked between its frames whether the next one is wanted; returns when it was asked for, in
    // CLOCK_MONOTONIC nanoseconds, or -1. The frame recorded then is the first whose exposure began after that.
    // NULL: every frame is wanted.
    int64_t (*wanted)(void *self);
    // Looks at a frame before it is recorded. What it returns (with its sentence) other than OK ends the recording
    // without that frame. NULL: none.
    sheen_status (*check)(void *self, const sheen_frame *frame, sheen_err *err);
    void *self;              // for both
    sheen_progress progress; // step "recording": done of total frames, total 0 where it is not known
} sheen_record_options;

typedef struct sheen_record_report {
    size_t n_recorded; // frames that are new in the session
    size_t n_present;  // frames that it had already, and that were not recorded twice
} sheen_record_report;

// Records until the source ends or `count` frames came (each frame of a live source is a new one). A frame that the session has already (same origin, sequence
// number and digest, and same name where the source names it) counts as recorded. A frame's name is the source's
// where that is free, else the next number. Each frame is complete on the disk before the next is asked for, so
// that a power cut loses at most the one in flight; *report is right also when it fails.
// ETIMEOUT, ENODEV, ECANCEL, EIO (disk), EDATA (the source gave none), and what the source reports.
sheen_status sheen_record(sheen_session *session, sheen_source *src, const sheen_record_options *options,
                          sheen_record_report *report, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

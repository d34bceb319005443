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

// What becomes of a frame that a policy has looked at.
typedef enum sheen_verdict {
    SHEEN_VERDICT_PASS,  // not this one
    SHEEN_VERDICT_OFFER, // record it if the disk keeps up with the camera
    SHEEN_VERDICT_TAKE,  // record it: once taken it is not lost
} sheen_verdict;

// Which frames of a live source are recorded. One is taken like this:
//     ask     until it says since when a frame is wanted
//     look    at each frame whose exposure began after that, until it says OFFER or TAKE
//     stored  once that frame is safe on the disk
// All are called by the thread that called sheen_record; each may be NULL. What they return other than OK ends the
// recording (with their sentence; SHEEN_EEND: as it should end). Every frame that they see is proven and settled where
// the source proves its frames (docs/capture.md).
typedef struct sheen_record_policy {
    void *self;
    // Between frames: *since_ns, CLOCK_MONOTONIC, is when the wanted frame was asked for, or -1: not yet, look again
    // after the next frame. It may take its time (a turntable that moves): what the camera delivers meanwhile is old
    // and is passed over. NULL: every frame is wanted.
    sheen_status (*ask)(void *self, int64_t *since_ns, sheen_err *err);
    // *verdict comes as TAKE. It may set frame->info.role and the turntable's angles. NULL: the first one is taken
    // (offered where there is no `ask`: a recording of all that comes).
    sheen_status (*look)(void *self, sheen_frame *frame, sheen_verdict *verdict, sheen_err *err);
    // The frame as it stands in the session now. One that was there already (a replay) is told, too.
    sheen_status (*stored)(void *self, const sheen_frame_info *info, sheen_err *err);
} sheen_record_policy;

// Puts a frame on the disk, as sheen_session_write_frame does. Called by the writer's thread.
typedef sheen_status sheen_record_write(void *self, const sheen_session *s, sheen_frame_info *info,
                                        const char *extension, const void *payload, size_t size_bytes,
                                        sheen_err *err);

typedef struct sheen_record_options {
    size_t count;   // stop after so many frames; 0: when the source ends
    int timeout_ms; // longest wait for a sign of life of the source; then something is done (ladder.h); 0: 10 s
    int bracket;    // put each frame together from so many exposures (2 to SHEEN_BRACKET_MAX); 0: one
    double patience_s; // how long to wait for the person where nothing else helps; 0: not at all
    bool set_role;     // give every frame `role` instead of the source's own
    sheen_role role;
    sheen_record_policy
        policy; // of a recording every frame is recorded that `look` likes; `ask` may end it only
    // Looks at a frame that is about to be recorded, whatever the policy. What it returns (with its sentence) other
    // than OK ends the recording without that frame. NULL: none.
    sheen_status (*check)(void *self, const sheen_frame *frame, sheen_err *err);
    void *check_self;
    // Told in between: what was tried with a camera that stalls, what the person is asked to do, a disk that is too
    // slow. NULL: nobody is.
    void (*notice)(void *self, const char *text);
    void *notice_self;
    size_t queue_bytes;        // payloads that may wait for the disk; 0: 64 MB
    sheen_record_write *write; // NULL: sheen_session_write_frame
    void *write_self;
    sheen_progress progress; // step "recording": done of total frames, total 0 where it is not known
} sheen_record_options;

typedef struct sheen_record_report {
    size_t n_recorded; // frames that are new in the session
    size_t n_present;  // frames that it had already, and that were not recorded twice
    size_t n_skipped;  // frames that were offered, and passed over because the disk was too slow
    size_t n_lost;     // frames that were taken, and could not be written (the sentence says why)
    int n_recovered;   // stalls of the camera that were got over
} sheen_record_report;

// Records until the source ends, the policy does, or `count` frames came (each frame of a live source is a new one). A
// frame that the session has already (same origin, sequence number and digest, and same name where the source names
// it) counts as recorded. A frame's name is the source's where that is free, else the next number. Frames are written by a thread of their own, in the order in which they were
// taken, each whole before the next; a frame that was taken waits in memory, and the camera waits where that is full, a
// frame that is only offered is then passed over. What was taken is written whatever ends the recording. *report is
// right also when it fails.
// ETIMEOUT, ENODEV, ECANCEL, EIO (disk), EDATA (the source gave none), and what the source reports.
sheen_status sheen_record(sheen_session *session, sheen_source *src, const sheen_record_options *options,
                          sheen_record_report *report, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

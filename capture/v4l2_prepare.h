// SPDX-License-Identifier: Apache-2.0
// v4l2_prepare.h - what happens between the start of a stream and the first frame that may be used.
//
//     WARM_UP   the automatics find their values; then the lock is set
//     SETTLE    the picture comes to rest
//     PROBE     half the exposure: the picture must get darker, else the camera only says that it obeys
//     RETURN    the locked exposure again: the picture must be what it was
//     READY
#ifndef SHEEN_CAPTURE_V4L2_PREPARE_H
#define SHEEN_CAPTURE_V4L2_PREPARE_H

#include "capture/settle.h"
#include "capture/v4l2_lock.h"
#include "capture/v4l2_options.h"
#include "capture/v4l2_stream.h"

typedef enum sheen_v4l2_phase {
    SHEEN_V4L2_WARM_UP,
    SHEEN_V4L2_SETTLE,
    SHEEN_V4L2_PROBE,
    SHEEN_V4L2_RETURN,
    SHEEN_V4L2_FINISHED
} sheen_v4l2_phase;

typedef struct sheen_v4l2_prepare {
    sheen_v4l2_stream *stream;
    const sheen_v4l2_options *options;
    sheen_transfer transfer;
    sheen_v4l2_lock lock;
    bool locked; // `lock` is whole
    sheen_v4l2_phase phase;
    bool probed;  // once is enough: later changes are settled only
    int n_frames; // of this phase
    int64_t changed_ns;
    sheen_settle settle;
    float rgb[3]; // light of the settled picture
    int32_t exposure, probe_exposure;
    int32_t base_exposure; // that the lock first said; 0: not asked for yet
} sheen_v4l2_prepare;

// The stream has begun. With a camera whose exposure is fixed already, the lock is set at once. As sheen_v4l2_lock_set.
sheen_status sheen_v4l2_prepare_begin(sheen_v4l2_prepare *p, sheen_err *err);
// Settings were set again: back to SETTLE.
void sheen_v4l2_prepare_again(sheen_v4l2_prepare *p);
// The stream was started anew, maybe of a camera that was plugged in anew: the same lock is set again (where there was one
// already), and everything is proven again. As sheen_v4l2_prepare_begin.
sheen_status sheen_v4l2_prepare_resume(sheen_v4l2_prepare *p, sheen_err *err);
// The lock is set now, with the settings of an earlier frame (but for an exposure that the options name), and all is
// proven; covered: without the probe, which wants light. EUNSUP where one of them is not taken, with its name; as sheen_v4l2_prepare_begin.
sheen_status sheen_v4l2_prepare_follow(sheen_v4l2_prepare *p, const sheen_frame_info *earlier, bool covered,
                                       sheen_err *err);
// Exposes `factor` times as long as the lock first said, and has the picture settle; the lock then holds that value.
// EUNSUP where the camera does not take it, ENODEV, EIO.
sheen_status sheen_v4l2_prepare_expose(sheen_v4l2_prepare *p, double factor, double *exposure_s_out,
                                       sheen_err *err);
// Takes a frame of the stream whose exposure began at start_ns (-1: not known); the phase says when it is finished.
// EDATA where the picture does not rest or does not obey, EUNSUP (the lock), ENODEV, EIO, ENOMEM.
sheen_status sheen_v4l2_prepare_frame(sheen_v4l2_prepare *p, const sheen_v4l2_frame *frame, int64_t start_ns,
                                      sheen_err *err);

#endif

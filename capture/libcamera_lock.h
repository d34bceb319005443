// SPDX-License-Identifier: Apache-2.0
// libcamera_lock.h - decides which frames of a libcamera camera were taken as the session's settings say.
//
//     WARM_UP   the automatics find exposure, gain and white balance
//     SETTLE    these are asked for with every request; settings reach the picture some requests later
//     HELD      the first frame with them says what they really became; each later one must say the very same
//
// What counts is only what the pipeline states about each finished request. One that states nothing is not locked.
#ifndef SHEEN_CAPTURE_LIBCAMERA_LOCK_H
#define SHEEN_CAPTURE_LIBCAMERA_LOCK_H

#include <stdbool.h>

#include "base/session.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum sheen_libcamera_phase {
    SHEEN_LIBCAMERA_WARM_UP,
    SHEEN_LIBCAMERA_SETTLE,
    SHEEN_LIBCAMERA_HELD
} sheen_libcamera_phase;

typedef struct sheen_libcamera_lock {
    sheen_libcamera_phase phase;
    bool is_raw;       // a mosaic: white balance does not touch it
    double exposure_s; // asked for; 0: what the automatic finds
    int mains_hz;      // exposure in whole half periods of the lamps; 0: any
    bool resumed;      // `held` is of before
    int n_frames;      // of this phase, or that did not match in a row
    sheen_frame_pipeline want, held;
} sheen_libcamera_lock;

typedef struct sheen_libcamera_abilities { // controls that the camera has
    bool exposure, gain, colour_gains;
} sheen_libcamera_abilities;

// At the beginning (all zero but the wishes), and again whenever the stream begins anew, maybe of a camera that was plugged
// in again: what was asked for is then asked for again, and frames must be as those before.
// EUNSUP where the camera, here called `name`, cannot be held to its settings through libcamera, with what to do.
sheen_status sheen_libcamera_lock_begin(sheen_libcamera_lock *lock, const sheen_libcamera_abilities *can,
                                        const char *name, sheen_err *err);
// A finished request. *keep: its frame was taken under the lock. EUNSUP (the pipeline does not say), EDATA (it does not
// keep to what it is told).
sheen_status sheen_libcamera_lock_frame(bool *keep, sheen_libcamera_lock *lock,
                                        const sheen_frame_pipeline *says, const char *name, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

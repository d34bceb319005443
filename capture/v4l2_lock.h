// SPDX-License-Identifier: Apache-2.0
// v4l2_lock.h - the radiometric lock: every automatic off, everything that changes numbers fixed, each read back.
#ifndef SHEEN_CAPTURE_V4L2_LOCK_H
#define SHEEN_CAPTURE_V4L2_LOCK_H

#include "base/session.h"
#include "capture/v4l2_controls.h"
#include "capture/v4l2_options.h"

typedef struct sheen_v4l2_setting {
    uint32_t id;
    int32_t value; // as it was read back when it was set
    char name[40];
} sheen_v4l2_setting;

typedef struct sheen_v4l2_lock {
    sheen_v4l2_setting settings[SHEEN_FRAME_MAX_CONTROLS];
    int n_settings;
} sheen_v4l2_lock;

typedef struct sheen_v4l2_lock_options {
    double exposure_s;                     // 0: as it stands, to a whole number of half periods
    int mains_hz;                          // 0: any exposure will do
    const sheen_v4l2_exposures *exposures; // that the camera has in truth
} sheen_v4l2_lock_options;

// The exposure that a camera has in truth and that is nearest, as a ratio, to the one that is wanted.
double sheen_v4l2_exposure_near(const sheen_v4l2_exposures *e, double want_s);

// True where the camera's exposure is under automatic control now.
bool sheen_v4l2_is_automatic(const sheen_v4l2_controls *c);

// Sets the lock. EUNSUP where a control refuses or does not keep its value, with the names of all that do; ENODEV, EIO.
sheen_status sheen_v4l2_lock_set(sheen_v4l2_lock *lock, const sheen_v4l2_lock_options *o,
                                 const sheen_v4l2_io *io, int fd, const char *path, sheen_err *err);
// Gives the lock's settings the values that an earlier frame has for them, the exposure's only where keep_exposure is
// false, and reads each back. EUNSUP with the name of one that is not taken; ENODEV, EIO.
sheen_status sheen_v4l2_lock_follow(sheen_v4l2_lock *lock, const sheen_frame_info *earlier,
                                    bool keep_exposure, const sheen_v4l2_io *io, int fd, const char *path,
                                    sheen_err *err);
// Reads every setting back into f->controls. EDATA where one is not as locked, with its name; ENODEV, EIO.
sheen_status sheen_v4l2_lock_check(const sheen_v4l2_lock *lock, sheen_frame_info *f, const sheen_v4l2_io *io,
                                   int fd, const char *path, sheen_err *err);
// Sets again what the lock had set.
sheen_status sheen_v4l2_lock_again(const sheen_v4l2_lock *lock, const sheen_v4l2_io *io, int fd,
                                   const char *path, sheen_err *err);
// Exposure time in seconds where the lock knows it, else 0.
double sheen_v4l2_lock_exposure_s(const sheen_v4l2_lock *lock);

#endif

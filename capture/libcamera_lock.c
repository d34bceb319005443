// SPDX-License-Identifier: Apache-2.0
// libcamera_lock.c - the lock of a libcamera camera, from what each request says of itself.
#include "capture/libcamera_lock.h"

#include <math.h>

enum { WARM_UP_FRAMES = 15, SETTLE_FRAMES = 30, MAX_STRAY_FRAMES = 30 };
// A sensor counts exposure in rows and gain in steps: what it makes of a wish differs by a few percent, or a row.
static const double wish_share = 0.05, wish_us = 50;
static const double held_share = 1e-3; // and then stays

sheen_status sheen_libcamera_lock_begin(sheen_libcamera_lock *lock, const sheen_libcamera_abilities *can,
                                        const char *name, sheen_err *err)
{
    const char *lacks = !can->exposure                        ? "its exposure"
                        : !can->gain                          ? "its gain"
                        : !lock->is_raw && !can->colour_gains ? "its white balance"
                                                              : NULL;
    if (lacks)
        return sheen_fail(
            err, SHEEN_EUNSUP,
            "the settings of '%.80s' cannot be locked: libcamera does not control %s (of USB cameras it "
            "never does); use v4l2:/dev/videoN, or add '?lock=off' to record without a lock",
            name, lacks);
    lock->resumed = lock->resumed || lock->phase == SHEEN_LIBCAMERA_HELD;
    lock->phase = lock->want.exposure_us > 0 ? SHEEN_LIBCAMERA_SETTLE : SHEEN_LIBCAMERA_WARM_UP;
    lock->n_frames = 0;
    return SHEEN_OK;
}

static bool is_near(double a, double b, double share, double least)
{
    return fabs(a - b) <= fmax(share * fabs(b), least);
}

static bool matches(const sheen_libcamera_lock *lock, const sheen_frame_pipeline *says,
                    const sheen_frame_pipeline *wanted, double share, double least_us)
{
    return is_near(says->exposure_us, wanted->exposure_us, share, least_us) &&
           is_near(says->analogue_gain, wanted->analogue_gain, share, 0) &&
           (lock->is_raw || (is_near(says->red_gain, wanted->red_gain, share, 0) &&
                             is_near(says->blue_gain, wanted->blue_gain, share, 0)));
}

// What is asked for from now on: as the automatics left it, the exposure as the person or the lamps want it, and the
// gain such that the picture stays as bright.
static void choose(sheen_libcamera_lock *lock, const sheen_frame_pipeline *says)
{
    lock->want = *says;
    if (lock->exposure_s > 0) {
        lock->want.exposure_us = 1e6 * lock->exposure_s;
        return;
    }
    if (!lock->mains_hz)
        return;
    const double half_period_us = 0.5e6 / lock->mains_hz;
    const double n = fmax(floor(says->exposure_us / half_period_us + 0.5), 1);
    lock->want.exposure_us = n * half_period_us;
    lock->want.analogue_gain = fmax(says->analogue_gain * says->exposure_us / lock->want.exposure_us, 1);
}

static bool says_enough(const sheen_libcamera_lock *lock, const sheen_frame_pipeline *says)
{
    return says->exposure_us > 0 && says->analogue_gain > 0 &&
           (lock->is_raw || (says->red_gain > 0 && says->blue_gain > 0));
}

// A frame that is not as wanted; after too many in a row the camera is given up.
static sheen_status stray(sheen_libcamera_lock *lock, const sheen_frame_pipeline *says, int most,
                          const char *name, sheen_err *err)
{
    if (++lock->n_frames <= most)
        return SHEEN_OK;
    return sheen_fail(
        err, SHEEN_EDATA,
        "the camera '%.80s' did not keep its settings: asked for %.0f us at a gain of %.3g, it takes "
        "%.0f us at %.3g; choose an exposure that it has (exposure_ms=...)",
        name, lock->want.exposure_us, lock->want.analogue_gain, says->exposure_us, says->analogue_gain);
}

sheen_status sheen_libcamera_lock_frame(bool *keep, sheen_libcamera_lock *lock,
                                        const sheen_frame_pipeline *says, const char *name, sheen_err *err)
{
    *keep = false;
    if (!says_enough(lock, says))
        return lock->phase == SHEEN_LIBCAMERA_WARM_UP && ++lock->n_frames < WARM_UP_FRAMES
                   ? SHEEN_OK // the first ones may know little
                   : sheen_fail(err, SHEEN_EUNSUP,
                                "libcamera does not say under which settings '%.80s' took its frames, so "
                                "they cannot "
                                "be called locked; use v4l2:/dev/videoN, or add '?lock=off'",
                                name);
    switch (lock->phase) {
    case SHEEN_LIBCAMERA_WARM_UP:
        if (++lock->n_frames < WARM_UP_FRAMES)
            return SHEEN_OK;
        choose(lock, says);
        lock->phase = SHEEN_LIBCAMERA_SETTLE;
        lock->n_frames = 0;
        return SHEEN_OK;
    case SHEEN_LIBCAMERA_SETTLE:
        if (!matches(lock, says, &lock->want, wish_share, wish_us) ||
            (lock->resumed && !matches(lock, says, &lock->held, held_share, 0)))
            return stray(lock, says, SETTLE_FRAMES, name, err);
        lock->held = *says;
        lock->phase = SHEEN_LIBCAMERA_HELD;
        break;
    default:
        if (!matches(lock, says, &lock->held, held_share, 0) ||
            (!lock->is_raw && !is_near(says->digital_gain, lock->held.digital_gain, held_share, 0)))
            return stray(lock, says, MAX_STRAY_FRAMES, name, err);
    }
    lock->n_frames = 0;
    *keep = true;
    return SHEEN_OK;
}

// SPDX-License-Identifier: Apache-2.0
// source.h - one way to get frames, whatever they come from.
//
//     sheen_source *src;
//     if (sheen_source_open(&src, "replay:penguin.session", &err)) ...
//     while ((s = sheen_source_next(src, timeout_ms, &frame, &err)) == SHEEN_OK)
//         use(&frame);                    // frame.data is lent until the next call
//     sheen_source_close(&src);           // NULL-safe, sets src to NULL
//
// A source belongs to the thread that opened it; only sheen_source_stop may be called from another
// thread or from a signal handler. How to add one: source_backend.h.
#ifndef SHEEN_CAPTURE_SOURCE_H
#define SHEEN_CAPTURE_SOURCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/session.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_source sheen_source;

// One frame as delivered, with all that its sidecar will say.
typedef struct sheen_frame {
    sheen_frame_info info; // name: "" where the source gives none; file and payload_digest are not set
    const char *extension; // of the payload's file: "jpg", "png", "raw"
    const uint8_t *data;   // payload; lent by the source until the next call
    size_t size_bytes;
    const uint8_t *mask; // the object's mask as a PNG file, lent likewise; NULL: none
    size_t mask_bytes;
} sheen_frame;

// What became of a camera's frames since it was opened; all zero where a source loses none.
typedef struct sheen_source_counts {
    int64_t n_frames;   // good ones, whether they were then used or not
    int64_t n_dropped;  // gaps in the driver's numbers: never delivered
    int64_t n_flagged;  // rejected: the driver says that they are damaged
    int64_t n_short;    // rejected: fewer bytes than a frame, or a JPEG without its end
    int64_t n_late;     // rejected: came after their turn had passed
    int64_t n_unlocked; // rejected: the settings that were read back with them were not those of the lock
} sheen_source_counts;

// Opens a source by URI:
//     replay:SESSION[?role=input|calibration|test|background]    frames of a session, in the order of their names
//     v4l2:/dev/videoN[?option&option...]             a camera; options: docs/capture.md
// EARG (unknown kind or option), EUNSUP (a kind of source that this build is without), and what the
// source itself reports: ENODEV, EACCESS, EIO, EFORMAT, EDATA (no frames in it).
sheen_status sheen_source_open(sheen_source **src_out, const char *uri, sheen_err *err);

// Waits at most timeout_ms (>= 0) for the next frame. ETIMEOUT (call again), EEND (the recording is over),
// ENODEV (unplugged), ECANCEL (sheen_source_stop was called), EIO, EFORMAT, ENOMEM.
sheen_status sheen_source_next(sheen_source *src, int timeout_ms, sheen_frame *frame, sheen_err *err);

// The frame's picture, its curve left as it is. EFORMAT, EUNSUP, ENOMEM.
sheen_status sheen_frame_develop(sheen_raster *out, const sheen_frame *frame, sheen_err *err);

// True where two frames' `device` name the same kind of camera, whatever its place on the bus.
bool sheen_device_is_alike(const char *a, const char *b);

// How many frames it has in all, -1 where that is not known (a camera).
int64_t sheen_source_count(const sheen_source *src);

void sheen_source_counters(sheen_source_counts *out, const sheen_source *src);
// True for a camera: frames come whether one asks for them or not.
bool sheen_source_is_live(const sheen_source *src);

// From now on frames are exposed `factor` times as long as the lock of the source says (1: as it says), as near as the
// device can; the next frame that is given out was, and the picture had come to rest. *exposure_s_out is the time. EUNSUP:
// this source cannot, or is not locked.
sheen_status sheen_source_expose(sheen_source *src, double factor, double *exposure_s_out, sheen_err *err);

// From now on the lock holds the settings of an earlier frame of this camera, as far as that frame knows them; what the
// URI fixes stays. covered: no light enters the lens, so that half the exposure cannot prove anything. To be called before
// the first frame. *followed false: nothing to do (a frame of another camera, taken
// without a lock, or no camera). EUNSUP where the camera does not take them.
sheen_status sheen_source_follow(sheen_source *src, const sheen_frame_info *earlier, bool covered,
                                 bool *followed, sheen_err *err);

// What can be tried with a device that stalls, from the mildest on (ladder.h climbs it).
typedef enum sheen_rung {
    SHEEN_RUNG_RESTART, // the stream
    SHEEN_RUNG_REOPEN,  // close, open by the name that lasts
    SHEEN_RUNG_RESET,   // of the USB device, then as REOPEN
    SHEEN_RUNG_COUNT
} sheen_rung;

bool sheen_source_can_recover(const sheen_source *src);
// After OK frames can be waited for again, taken under the same settings. EUNSUP (no such remedy), ENODEV, EIO, ...
sheen_status sheen_source_recover(sheen_source *src, sheen_rung rung, sheen_err *err);
// Waits at most timeout_ms for a device that went away; true as soon as it may be there again.
bool sheen_source_await(sheen_source *src, int timeout_ms);

void sheen_source_stop(sheen_source *src);
void sheen_source_close(sheen_source **src);

// The URI's schemes that this build can open, in a fixed order; NULL ends the list.
const char *const *sheen_source_schemes(void);

#ifdef __cplusplus
}
#endif
#endif

// SPDX-License-Identifier: Apache-2.0
// libcamera_frames.h - decides what becomes of each finished request's frame: order, damage and lock, all counted.
#ifndef SHEEN_CAPTURE_LIBCAMERA_FRAMES_H
#define SHEEN_CAPTURE_LIBCAMERA_FRAMES_H

#include "capture/libcamera_lock.h"
#include "capture/source.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_libcamera_frames {
    sheen_frame_info info; // of every frame: format, colours, device
    size_t needed_bytes;   // of a raw frame
    bool locked;           // frames count only under the lock
    sheen_libcamera_lock lock;
    bool begun; // false: numbers begin anew
    int64_t last_sequence;
    sheen_source_counts counts;
} sheen_libcamera_frames;

// What the stream is: `name` and `id` of the camera; info.fourcc (0: JPEG), sizes and colours are set. Says how many bytes
// a frame needs and which curve it has, `transfer` (NULL: the one that goes with its colours). EIO (`claim`, as libcamera says it, cannot
// be), EUNSUP.
sheen_status sheen_libcamera_frames_describe(sheen_libcamera_frames *f, const char *name, const char *id,
                                             const char *claim, const sheen_transfer *transfer,
                                             sheen_err *err);
// A finished request's number: true where its frame has its turn and is whole, as far as libcamera says.
bool sheen_libcamera_frames_turn(sheen_libcamera_frames *f, int64_t sequence, bool success);
// A frame that had its turn, and what the pipeline says of it. *frame comes with data (lent), size_bytes and info.t_ns; where
// it is kept the rest is filled in as it is handed over. EUNSUP, EDATA: of the lock.
sheen_status sheen_libcamera_frames_judge(bool *keep, sheen_frame *frame, sheen_libcamera_frames *f,
                                          const sheen_frame_pipeline *says, const char *name, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

// SPDX-License-Identifier: Apache-2.0
// session_masks.h - masks of a session's frames from what hides the board, and what hides the scene behind it.
#ifndef SHEEN_POSE_SESSION_MASKS_H
#define SHEEN_POSE_SESSION_MASKS_H

#include "base/camera.h"
#include "base/session.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_session_masks {
    sheen_image *masks;   // [n_frames] of the caller, who releases what is put into them
    size_t n_backgrounds; // pictures without the object that were used
} sheen_session_masks;

// Masks, as board_masks.h says, of frames that have poses. Of an object that turned, the frame of role background that belongs
// to a frame's round (one without a round: to frames without) shows what the object hides beyond the board. EDATA, ENOMEM,
// and what the files say.
sheen_status sheen_session_masks_make(sheen_session_masks *out, const sheen_session *s,
                                      const sheen_camera *camera, const sheen_poses *poses,
                                      const sheen_frame_info *const *frames, size_t n_frames, int n_threads,
                                      sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

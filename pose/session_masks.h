// SPDX-License-Identifier: Apache-2.0
// session_masks.h - masks of a session's frames from what hides the board, and what hides the scene behind it.
#ifndef SHEEN_POSE_SESSION_MASKS_H
#define SHEEN_POSE_SESSION_MASKS_H

#include "base/camera.h"
#include "base/session.h"

#ifdef __cplusplus
extern "C" {
#endif

// masks[n_frames], as board_masks.h says, of frames that have poses; the caller releases them. Of an object that turned, the
// frame of role background that belongs to a frame's round (one without a round: to frames without) shows what the object
// hides beyond the board; *n_backgrounds: how many were used. EDATA, ENOMEM, and what the files say.
sheen_status sheen_session_masks_make(sheen_image *masks, size_t *n_backgrounds, const sheen_session *s,
                                      const sheen_camera *camera, const sheen_poses *poses,
                                      const sheen_frame_info *const *frames, size_t n_frames, int n_threads,
                                      sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

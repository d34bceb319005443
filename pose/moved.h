// SPDX-License-Identifier: Apache-2.0
// moved.h - what moved between the frames of a session: the camera, or the object on its board.
//
// The boards' poses alone say only how camera and board moved against each other. Three things tell more: a table turns
// about one axis, exactly, which no hand does; on any table, also one on which the board is shifted by hand, the board's
// plane stays what it was to a camera that stands still; and beside the board one sees a background that stands still where
// the camera does.
#ifndef SHEEN_POSE_MOVED_H
#define SHEEN_POSE_MOVED_H

#include <stdbool.h>
#include <stddef.h>

#include "base/board.h"
#include "base/camera.h"
#include "base/image.h"
#include "base/session.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum sheen_moved {
    SHEEN_MOVED_UNKNOWN, // nothing to go by: it has to be told
    SHEEN_MOVED_CAMERA,
    SHEEN_MOVED_OBJECT,
    SHEEN_MOVED_BOTH // or neither case of the two: not to be fitted as one
} sheen_moved;

typedef struct sheen_moved_frame {
    double rt_cam_board[6];
    double covariance[36]; // as sheen_turntable_pose
    double asked_rad;      // commanded angle of a table; NaN: none
    int round; // of a table; the camera may be put elsewhere between two, so these are not compared
    const sheen_image
        *light; // of the camera's size, one channel, 0..1 in equal steps for the eye; NULL: not looked at
} sheen_moved_frame;

typedef struct sheen_moved_verdict {
    sheen_moved moved;
    bool on_axis;      // the poses turn about one axis
    bool table_turned; // commanded angles differ
    bool off_table;    // the board's plane tilts or rises before the camera within a round, as on no table
    int n_patches;     // of background with anything on it, over all pairs of neighbouring frames
    double still;      // share of them that stayed as they were; NaN where there are too few
    char reason[200];  // one clause for a person
} sheen_moved_verdict;

// Frames in the order in which they were taken. Background is what lies outside of the board's rectangle, of half
// sides half_board_m, and the space above it up to height_m. ENOMEM, EARG (camera).
sheen_status sheen_moved_find(sheen_moved_verdict *out, const sheen_camera *camera,
                              const double half_board_m[2], double height_m, const sheen_moved_frame *frames,
                              size_t n_frames, sheen_err *err);

// The same for a session's frames with a pose, at most `most` of them; pictures are read one after the other.
sheen_status sheen_moved_in_session(sheen_moved_verdict *out, const sheen_session *s,
                                    const sheen_camera *camera, const sheen_board *board,
                                    const sheen_poses *poses, size_t most, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

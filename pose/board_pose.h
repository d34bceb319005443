// SPDX-License-Identifier: Apache-2.0
// board_pose.h - where the camera stood: one frame's pose from what it shows of the board.
#ifndef SHEEN_POSE_BOARD_POSE_H
#define SHEEN_POSE_BOARD_POSE_H

#include <stdbool.h>
#include <stddef.h>

#include "base/board.h"
#include "base/camera.h"
#include "calib/view.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SHEEN_POSE_MIN_SADDLES = 6 };

typedef struct sheen_board_pose {
    double rt_cam_board[6];
    double covariance[36]; // of rt_cam_board (radians, metres), row-major, from the residuals' own scatter
    bool from_tags; // fewer than SHEEN_POSE_MIN_SADDLES saddles: from the tags' corners, several times worse
    int n_points, n_outliers;
    double rms_px;       // per axis, of the inliers
    double tag_error_px; // median distance of the tags' centres from where the pose puts them
} sheen_board_pose;

// EDATA, with the reason in err: no board in view, too few points or all in a strip, points that do not fit the
// camera, or saddles that contradict the tags. is_inlier[view->n_saddles] may be NULL; all false where the pose
// came from tags. ENOMEM, EARG (bad camera).
sheen_status sheen_board_pose_find(sheen_board_pose *out, bool *is_inlier, const sheen_camera *camera,
                                   const sheen_board *board, const sheen_board_view *view, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

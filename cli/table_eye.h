// SPDX-License-Identifier: Apache-2.0
// table_eye.h - the camera as the one that knows how far a turntable has turned: by the board in its frames.
#ifndef SHEEN_CLI_TABLE_EYE_H
#define SHEEN_CLI_TABLE_EYE_H

#include "base/board.h"
#include "base/camera.h"
#include "calib/detect.h"
#include "capture/source.h"
#include "pose/board_pose.h"

typedef struct sheen_cli_eye {
    const sheen_session *session;
    sheen_camera camera;
    sheen_board board;
    sheen_tag_detector *detector; // NULL: the session has no camera or no board, nothing is seen
    char reference[64];           // the frame that rt_reference belongs to
    double rt_reference[6];
} sheen_cli_eye;

// Reads the session's camera and board. Lends the session.
sheen_status sheen_cli_eye_init(sheen_cli_eye *e, const sheen_session *s, sheen_err *err);
void sheen_cli_eye_release(sheen_cli_eye *e);
// The board's pose in a frame. EDATA: not in view, or the frame has not the camera's size.
sheen_status sheen_cli_eye_pose(sheen_board_pose *pose, sheen_cli_eye *e, const sheen_frame *frame,
                                sheen_err *err);
// The turn about the board's z that takes one pose to the other, degrees in (-180, 180], positive counter-clockwise seen
// from above; whatever the axis' tilt.
double sheen_cli_eye_turn_deg(const double rt_cam_board_from[6], const double rt_cam_board_to[6]);
// For sheen_turn_options.see; self is the eye.
sheen_status sheen_cli_eye_see(void *self, const sheen_frame *frame, const sheen_frame_info *reference,
                               double *angle_deg, sheen_err *err);

#endif

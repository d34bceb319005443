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
    bool any_axis;    // a table that a person turns by hand need not turn about one axis
    bool has_axis;    // another frame of the reference's round shows about which axis the table turns
    double rt_far[6]; // that frame's
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
// How far a pose is from all that a turn about one axis makes of `from`, the axis being that of the turn from `from` to `other`, by 30
// degrees or more: what a camera that was moved in between leaves. Shift at the board's origin.
void sheen_cli_eye_off_axis(double *off_deg, double *shift_m, const double rt_cam_board_from[6],
                            const double rt_cam_board_other[6], const double rt_cam_board_now[6]);
// For sheen_turn_options.see; self is the eye. EUNSUP: the frame does not turn about the axis of the others of the reference's round (the
// camera was moved).
sheen_status sheen_cli_eye_see(void *self, const sheen_frame *frame, const sheen_frame_info *reference,
                               double *angle_deg, sheen_err *err);

#endif

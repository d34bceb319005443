// SPDX-License-Identifier: Apache-2.0
// board_survey.h - several boards about an object: where they are to each other, and every frame's pose in the frame
// of the first, by one bundle adjustment over all frames.
//
// p_cam = rt_cam_ref (rt_ref_board p_board): six unknowns a frame, six for each board but the first. A board that was
// moved, or is seen wrongly, does not fit where the others are: that board is then left out of that frame, and said.
#ifndef SHEEN_POSE_BOARD_SURVEY_H
#define SHEEN_POSE_BOARD_SURVEY_H

#include <stdbool.h>
#include <stddef.h>

#include "base/board.h"
#include "base/camera.h"
#include "calib/view.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_survey_board {
    bool found;                // false: no frame ties it to the first board; `reason` says so
    double rt_ref_board[6];    // from this board's frame to the first one's
    double covariance[36];     // of it; zero for the first
    int n_frames;              // in which it counts
    int n_moved;               // in which it stands elsewhere, and is left out
    double moved_m, moved_rad; // how far, in the last of them
    char reason[160];
} sheen_survey_board;

typedef struct sheen_survey_frame {
    bool found;
    double rt_cam_ref[6];
    double covariance[36]; // of it, with what is uncertain about the boards
    double rms_px;         // per axis, of the points that count
    int n_points, n_outliers, n_boards;
    char reason[160]; // why there is none; or what is to be said of it
} sheen_survey_frame;

typedef struct sheen_survey {
    sheen_survey_board *boards; // [n_boards]
    sheen_survey_frame *frames; // [n_frames]
    size_t n_boards, n_frames;
    double rms_px; // per axis, over all points that count
} sheen_survey;

// views[n_frames][n_boards], as sheen_boards_observe gives them. EDATA: no frame has a pose; ENOMEM, EARG (camera).
sheen_status sheen_survey_solve(sheen_survey *out, const sheen_camera *camera, const sheen_board_set *boards,
                                const sheen_board_view *views, size_t n_frames, sheen_err *err);
void sheen_survey_release(sheen_survey *survey);

#ifdef __cplusplus
}
#endif
#endif

// SPDX-License-Identifier: Apache-2.0
// board_survey_private.h - what the survey's solution and its report share. Used inside pose only.
#ifndef SHEEN_POSE_BOARD_SURVEY_PRIVATE_H
#define SHEEN_POSE_BOARD_SURVEY_PRIVATE_H

#include <stdbool.h>

#include "base/pose3.h"
#include "pose/board_survey.h"

// What one frame shows of one board.
typedef struct sheen_survey_group {
    const sheen_board_view *view;
    bool posed, counts, moved;
    sheen_Rt Rt_cam_board;    // from this board alone
    bool *use;                // [view->n_saddles]
    double *error_px;         // likewise
    double own_px, median_px; // median error by a pose of its own (expected), and by the common one
} sheen_survey_group;

typedef struct sheen_survey_problem {
    const sheen_camera *camera;
    size_t n_frames, n_boards;
    sheen_survey_group *groups; // [n_frames][n_boards]
    sheen_Rt *Rt_cam_ref;       // [n_frames]
    bool *framed;               // [n_frames]
    sheen_Rt *Rt_ref_board;     // [n_boards]
    bool *tied;                 // [n_boards]
    double *S, *rhs;            // [6 n_boards][6 n_boards]; the first board's rows are kept at the identity
    double *V, *W, *g;          // [n_frames]: 36, 6 x 6 n_boards, 6
    double chi2;
    size_t n_points;
} sheen_survey_problem;

static inline sheen_survey_group *sheen_survey_at(const sheen_survey_problem *p, size_t frame, size_t board)
{
    return &p->groups[frame * p->n_boards + board];
}

// From the solved problem: where a board and a frame stand, how well known (sigma2: variance of a coordinate, px^2;
// S_inverse: of the boards' reduced equations), and what speaks against them.
void sheen_survey_report_board(sheen_survey_board *out, const sheen_survey_problem *p, size_t b,
                               double sigma2, const double *S_inverse);
void sheen_survey_report_frame(sheen_survey_frame *out, const sheen_survey_problem *p, size_t f,
                               double sigma2, const double *S_inverse);

#endif

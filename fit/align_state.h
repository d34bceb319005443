// SPDX-License-Identifier: Apache-2.0
// align_state.h - what aligning photographs works on: every point as every photograph shows it (align.c, align_observe.c,
// align_proof.c, align_solve.c only).
#ifndef SHEEN_FIT_ALIGN_STATE_H
#define SHEEN_FIT_ALIGN_STATE_H

#include <math.h>

#include "base/pose3.h"
#include "fit/align.h"
#include "fit/align_points.h"

typedef struct sheen_align_observation {
    float rgb[3];       // of the photograph, as it is
    float rgb_dq[3][2]; // per pixel
    float q_dx[2][6];   // pixels per (w, d)
    float y;            // luminance over gain, without what is predicted
    float residual, weight;
    uint8_t valid;
} sheen_align_observation;

// A pose moves by a small rotation about the object's middle c and a translation, in the camera's axes:
// p_cam' = c + exp(w) (p_cam - c) + d.
typedef struct sheen_align_pose {
    sheen_Rt Rt_cam_obj;
    double moved[6], log_gain[3];    // since the start
    double per_gain[3];              // exp(-log_gain), by sheen_align_set_gains
    double prior_px;                 // of each number
    double centre_cam[3], px_per[6]; // about how many pixels a unit of each number moves the object's points
} sheen_align_pose;

typedef struct sheen_align_state {
    const sheen_align_options *o;
    const sheen_photos *photos;
    const sheen_align_points *points;
    sheen_align_pose *views;       // [n_views]
    sheen_align_observation *seen; // [n_views][n_points]
    double *A, *b, *scratch;
    double spacing_px, scale, prior_ev, white_lin;
    size_t n_views, n_points, i_view;
    int parity;    // points of this parity count
    size_t stride; // and of them every stride-th
} sheen_align_state;

static inline sheen_align_observation *sheen_align_at(const sheen_align_state *st, size_t view, size_t point)
{
    return &st->seen[view * st->n_points + point];
}

static inline void sheen_align_set_gains(const sheen_align_state *st)
{
    for (size_t v = 0; v < st->n_views; v++)
        for (int c = 0; c < 3; c++)
            st->views[v].per_gain[c] = exp(-st->views[v].log_gain[c]);
}

// Looks every point of the stride up in every photograph by the present poses, through a 5 x 5 Gaussian. ECANCEL.
sheen_status sheen_align_observe(sheen_align_state *st, sheen_err *err);
// Luminances by the present gains, each point's D, residuals and weights, and their scale.
void sheen_align_measure(sheen_align_state *st);
// D, residuals and weights by the present scale; returns the robust scale of the points of the parity in use.
double sheen_align_settle(const sheen_align_state *st);

// The normal equations of all poses, prior included, into A (lower triangle) and b. ENOMEM.
sheen_status sheen_align_equations(sheen_align_state *st, sheen_err *err);
// One step of all poses; *step_px: the largest rms motion. EDATA, ENOMEM.
sheen_status sheen_align_move(sheen_align_state *st, double *step_px, sheen_err *err);
// One step of all gains. ENOMEM.
sheen_status sheen_align_solve_gains(sheen_align_state *st, sheen_err *err);

// rms motion of the object's points in the picture since the start.
double sheen_align_moved_px(const sheen_align_pose *v);
// Whether the poses, or the gains, in st can be better than the `given` ones, by how far they are agreed on and how far poses went. The
// finest sampling and all points must be in use, for poses the final gains, for gains the present poses. ENOMEM, ECANCEL.
sheen_status sheen_align_poses_believable(int *believable, sheen_align_state *st,
                                          const sheen_align_pose *given, sheen_err *err);
sheen_status sheen_align_gains_believable(int *believable, sheen_align_state *st,
                                          const sheen_align_pose *given, sheen_err *err);

#endif

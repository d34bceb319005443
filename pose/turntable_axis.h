// SPDX-License-Identifier: Apache-2.0
// turntable_axis.h - a turntable's axis and the angle of every step, from poses of the board that turns on it.
//
// The camera stands still. Every pose is rt_cam_table, a turn by angle[i] about the table's z, rt_table_board:
// 10 unknowns for axis and board, one for each view, by least squares under the poses' own covariances; views that
// do not fit (the board slipped, the camera was touched) are left out.
#ifndef SHEEN_POSE_TURNTABLE_AXIS_H
#define SHEEN_POSE_TURNTABLE_AXIS_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SHEEN_TURNTABLE_MIN_VIEWS = 3, SHEEN_TURNTABLE_MAX_VIEWS = 100000 };

typedef struct sheen_turntable_pose {
    double rt_cam_board[6];
    double covariance[36]; // of it, row-major; all zero: unknown (one thousandth of a radian and of a metre)
} sheen_turntable_pose;

typedef struct sheen_turntable_view {
    bool used;        // false: left out, as it does not turn about the axis of the others
    double angle_rad; // about the table's z, counter-clockwise seen from above; view `first`: 0; in (-pi, pi]
    double sigma_rad; // one standard deviation of the angle from view `first`
    double misfit;    // distance from the model in standard deviations of the pose; about 1 where all is well
    double axis_gradient[10]; // how the angle follows the ten common unknowns; for sheen_turntable_step
    double own_variance;
} sheen_turntable_view;

// Frame "table": z along the axis, away from the paper's back (along the board's z as far as may be); origin
// where the axis comes nearest to the board's origin; x along the board's x (or y) in view `first`.
typedef struct sheen_turntable {
    double rt_cam_table[6];
    double rt_table_board[6]; // in view `first`
    double sigma_axis_rad;    // one standard deviation of the axis' direction, the larger of two
    double sigma_origin_m;    // and of its place across it
    double
        scatter; // of the poses about the model, in parts of what their covariances say; the sigmas contain it
    size_t first, n_used, n_views;
    sheen_turntable_view *views;
    double covariance[100]; // of the ten common unknowns
} sheen_turntable;

// EDATA: fewer than SHEEN_TURNTABLE_MIN_VIEWS poses (that fit), or all at nearly the same angle; EARG: too many, or
// not finite; ENOMEM.
sheen_status sheen_turntable_solve(sheen_turntable *out, const sheen_turntable_pose *poses, size_t n_poses,
                                   sheen_err *err);
void sheen_turntable_release(sheen_turntable *table);

// The angle from view i to view j, in (-pi, pi], and its standard deviation (either output may be NULL).
void sheen_turntable_step(double *angle_rad, double *sigma_rad, const sheen_turntable *table, size_t i,
                          size_t j);

// Commanded against measured: measured = offset + gain * asked, over the used views for which asked_rad is not NaN.
typedef struct sheen_turntable_gain {
    double gain;                           // 1: as asked; negative: turns the other way
    double sigma_gain;                     // one standard deviation
    double offset_rad, rms_rad, worst_rad; // deviations from that line
    size_t i_worst, n;
} sheen_turntable_gain;

// Starts from the sign that fits better and steps no larger than pi / 4 beside the line; EDATA: fewer than three
// different angles, or angles that follow no line.
sheen_status sheen_turntable_compare(sheen_turntable_gain *out, const sheen_turntable *table,
                                     const double *asked_rad, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

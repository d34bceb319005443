// SPDX-License-Identifier: Apache-2.0
// calibrate_problem.h - the least-squares problem of a calibration in plain numbers, as calibrate_mrcal.c solves it.
//
// Frame "grid" is mrcal's: origin at the upper left inner corner, x right and y down along the corners, z into
// the paper.
#ifndef SHEEN_CALIB_CALIBRATE_PROBLEM_H
#define SHEEN_CALIB_CALIBRATE_PROBLEM_H

#include <stdbool.h>
#include <stddef.h>

#include "base/camera.h"

typedef struct sheen_problem {
    sheen_camera camera;          // seed in, solution out
    int n_frames, n_cols, n_rows; // corners of the grid
    double spacing_m;
    double *rt_cam_grid;  // [n_frames][6], seed in, solution out
    double *observations; // [n_frames][n_rows][n_cols][3]: x, y in px, weight; weight < 0: missing or outlier
    double warp_m[2];     // deflection of the grid's middle along its z
    double *residuals_px; // [n_frames][n_rows][n_cols][2], out
} sheen_problem;

typedef enum sheen_problem_stage {
    SHEEN_PROBLEM_POSES,      // the lens is held
    SHEEN_PROBLEM_CORE,       // poses and focal length, principal point
    SHEEN_PROBLEM_EVERYTHING, // and distortion, the board's warp, with regularisation (a splined lens: no core)
} sheen_problem_stage;

// Numbers of observations: 3 * this.
static inline size_t sheen_problem_corners(const sheen_problem *p)
{
    return (size_t)p->n_frames * (size_t)p->n_cols * (size_t)p->n_rows;
}

// EDATA where nothing came out that is finite.
sheen_status sheen_problem_solve(sheen_problem *p, sheen_problem_stage stage, sheen_err *err);

// What the noise of corners leaves uncertain.
typedef struct sheen_uncertainty {
    // Standard deviation (px, largest direction) of the projection of n points at distance_m through the pixels q_px[2n]
    double *sigma_px; // [n]
    const double *q_px;
    size_t n; // may be 0
    double distance_m;
    // [m][m] of the lens parameters, m = camera.n_intrinsics; zero where the solve holds one. May be NULL
    double *lens_covariance;
} sheen_uncertainty;

// Of a solved problem, for corner noise of sigma_px per axis. EDATA where the normal equations cannot be factorised;
// ENOMEM.
sheen_status sheen_problem_uncertainty(const sheen_uncertainty *out, const sheen_problem *p, double sigma_px,
                                       sheen_err *err);
// dq_dlens[2][n_intrinsics]: how the projection of a point moves with the lens parameters.
sheen_status sheen_lens_gradient(double *dq_dlens, const sheen_camera *camera, const double p_cam[3],
                                 sheen_err *err);

#endif

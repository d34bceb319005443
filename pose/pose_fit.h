// SPDX-License-Identifier: Apache-2.0
// pose_fit.h - the pose that brings points of the board to their pixels, by least squares.
#ifndef SHEEN_POSE_POSE_FIT_H
#define SHEEN_POSE_POSE_FIT_H

#include <stdbool.h>
#include <stddef.h>

#include "base/camera.h"

#ifdef __cplusplus
extern "C" {
#endif

// Points, and room to work in; arrays of n as said.
typedef struct sheen_pose_points {
    size_t n;
    double *p_board;            // [n][3], metres; z = 0 for the seed
    double *q_px;               // [n][2]
    bool *use;                  // [n]
    double *whiten;             // [n][3]: residuals count as (w0 x + w1 y, w2 y); 1 0 1 after init
    double *p_cam, *fit_px, *J; // scratch: [n][3], [n][2], [n][2][3]
} sheen_pose_points;

sheen_status sheen_pose_points_init(sheen_pose_points *points, size_t n, sheen_err *err);
void sheen_pose_points_release(sheen_pose_points *points);

// A pose from the points in use, which lie in the board's plane: homography over undistorted directions. EDATA
// where they do not determine one.
sheen_status sheen_pose_seed(double rt_cam_board[6], const sheen_camera *camera, sheen_pose_points *points,
                             sheen_err *err);

// Weighs the points by their covariances (xx, xy, yy; any common unit): residuals are whitened so that their mean
// square stays one in squared pixels. All points count alike where a covariance is not positive definite.
void sheen_pose_points_weigh(sheen_pose_points *points, const double (*covariance)[3]);

// Levenberg-Marquardt from a seed, over the points in use, through the full lens model; *rms_px is per axis, of
// whitened residuals.
// EDATA where it does not end at a pose in front of the camera.
sheen_status sheen_pose_refine(double rt_cam_board[6], double *rms_px, const sheen_camera *camera,
                               sheen_pose_points *points, sheen_err *err);

// Whitened pixel distance of every point (in use or not) from where the pose puts it; NaN behind the camera.
sheen_status sheen_pose_errors(double *error_px, const double rt_cam_board[6], const sheen_camera *camera,
                               sheen_pose_points *points, sheen_err *err);

// Covariance of rt_cam_board[6] for whitened noise of sigma_px per axis over the points in use. EDATA where they do
// not determine the pose.
sheen_status sheen_pose_covariance(double covariance[36], const double rt_cam_board[6], double sigma_px,
                                   const sheen_camera *camera, sheen_pose_points *points, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

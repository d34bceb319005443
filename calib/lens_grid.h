// SPDX-License-Identifier: Apache-2.0
// lens_grid.h - how projections over the image move with the lens parameters, beyond what a moved camera explains.
//
// A calibration cannot tell a turned or moved camera from moved boards. What of the parameters' effect G = dq/db on
// points at one distance is left when the best rigid motion is taken out is M = (I - J (J'J)^-1 J') G, J the
// derivatives by that motion; the variance of point i is M_i C M_i' for lens parameters of covariance C.
#ifndef SHEEN_CALIB_LENS_GRID_H
#define SHEEN_CALIB_LENS_GRID_H

#include <stdbool.h>
#include <stddef.h>

#include "base/camera.h"

enum { SHEEN_LENS_GRID_COLS = 18, SHEEN_LENS_GRID_ROWS = 14, SHEEN_LENS_GRID_MAX = 18 * 14 };

typedef struct sheen_lens_grid {
    size_t n, n_lens;
    double q_px[2 * SHEEN_LENS_GRID_MAX], p_cam[3 * SHEEN_LENS_GRID_MAX];
    double J[2 * SHEEN_LENS_GRID_MAX][6]; // by rotation and translation of the point
    double *M;                            // [2n][n_lens]
} sheen_lens_grid;

// The middles of a grid over the image for which `wanted` (NULL: all) says yes, at distance_m. EDATA where the lens
// has no inverse there or too few points are wanted. Release after failure, too.
sheen_status sheen_lens_grid_init(sheen_lens_grid *g, const sheen_camera *camera, double distance_m,
                                  bool (*wanted)(const void *self, const double q_px[2]), const void *self,
                                  sheen_err *err);
void sheen_lens_grid_release(sheen_lens_grid *g);
// Takes out of values[2n][n_columns] what the rigid motion explains.
bool sheen_lens_grid_project_out(const sheen_lens_grid *g, double *values, size_t n_columns);
// trace(M_i C M_i') for C[n_lens][n_lens].
double sheen_lens_grid_variance(const sheen_lens_grid *g, size_t i, const double *C);
// dq/d(rotation, translation) of a point, from dq/dp (2 x 3).
void sheen_motion_gradient(double J[2][6], const double dq_dp[6], const double p[3]);

#endif

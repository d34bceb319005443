// SPDX-License-Identifier: Apache-2.0
// homography.h - the projective map from a plane to a picture, and the pose that it implies.
#ifndef SHEEN_CALIB_HOMOGRAPHY_H
#define SHEEN_CALIB_HOMOGRAPHY_H

#include <stdbool.h>
#include <stddef.h>

#include "base/pose3.h"

#ifdef __cplusplus
extern "C" {
#endif

// H (row-major, scaled to H[8] = 1 in normalised coordinates) with q ~ H (x, y, 1), by least squares of the
// linear equations over n >= 4 pairs; xy and q hold 2n numbers. False where the points do not determine it
// (fewer than 4, on a line, not finite).
bool sheen_homography_fit(double H[9], const double *xy, const double *q, size_t n);
// q = H (x, y, 1). False where the point lies on or behind the line that goes to infinity.
bool sheen_homography_apply(double q[2], const double H[9], const double xy[2]);

// The pose of the plane z = 0 of frame A, seen from B, whose H maps its (x, y) to (X/Z, Y/Z) in B. The plane's
// origin need not be in view; `xy` is a point that is in front of B (it decides the sign). False where H is
// singular.
bool sheen_homography_pose(sheen_Rt *Rt_B_A, const double H[9], const double xy[2]);

#ifdef __cplusplus
}
#endif
#endif

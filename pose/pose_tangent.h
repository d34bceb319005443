// SPDX-License-Identifier: Apache-2.0
// pose_tangent.h - small differences between poses: as six numbers, and what a covariance says of them.
//
// A pose is moved on the left: R' = exp(w) R, t' = t + d. The six numbers (w, d), radians and metres, have no
// singular place, unlike a difference of Rodrigues vectors.
#ifndef SHEEN_POSE_POSE_TANGENT_H
#define SHEEN_POSE_POSE_TANGENT_H

#include <stdbool.h>

#include "base/pose3.h"

#ifdef __cplusplus
extern "C" {
#endif

// The (w, d) that moves Rt_from to Rt_to.
void sheen_pose_difference(double wd[6], const sheen_Rt *Rt_to, const sheen_Rt *Rt_from);

// Rt moved by (w, d). `out` may be Rt.
void sheen_pose_move(sheen_Rt *out, const sheen_Rt *Rt, const double wd[6]);

// The inverse covariance of (w, d) from the covariance of rt (Rodrigues, translation), row-major. False where the
// covariance is not positive definite: all zero, for one, where a pose was imported.
bool sheen_pose_information(double information[36], const double rt[6], const double covariance[36]);

// The other way: covariance of rt from that of (w, d).
void sheen_pose_covariance_of_rt(double covariance[36], const double rt[6], const double of_wd[36]);

// a' P b for 6 x 6 P.
double sheen_pose_product(const double a[6], const double P[36], const double b[6]);

#ifdef __cplusplus
}
#endif
#endif

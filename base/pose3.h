// SPDX-License-Identifier: Apache-2.0
// pose3.h - rigid transformations, in mrcal's notation.
//
// rt_A_B is six numbers, a Rodrigues rotation and then a translation (metres):
// it takes a point given in frame B to frame A. Inner letters meet:
//
//     rt_cam_obj = compose(rt_cam_board, rt_board_obj)        rt_obj_cam = invert(rt_cam_obj)
//
// sheen_Rt is the matrix form, for loops over many points. Outputs may be the
// same array as an input.
#ifndef SHEEN_BASE_POSE3_H
#define SHEEN_BASE_POSE3_H

typedef struct sheen_Rt {
    double R[3][3]; // row-major
    double t[3];
} sheen_Rt;

void sheen_Rt_from_rt(sheen_Rt *Rt_A_B, const double rt_A_B[6]);
void sheen_rt_from_Rt(double rt_A_B[6], const sheen_Rt *Rt_A_B);

void sheen_rt_compose(double rt_A_C[6], const double rt_A_B[6], const double rt_B_C[6]);
void sheen_rt_invert(double rt_B_A[6], const double rt_A_B[6]);
void sheen_Rt_compose(sheen_Rt *Rt_A_C, const sheen_Rt *Rt_A_B, const sheen_Rt *Rt_B_C);
void sheen_Rt_invert(sheen_Rt *Rt_B_A, const sheen_Rt *Rt_A_B);

// A point (rotated and moved) and a direction (rotated only).
void sheen_Rt_point(double p_A[3], const sheen_Rt *Rt_A_B, const double p_B[3]);
void sheen_Rt_direction(double v_A[3], const sheen_Rt *Rt_A_B, const double v_B[3]);

// Angle of the rotation between two poses, and distance between their origins.
double sheen_rt_angle_rad(const double rt_A_B[6], const double rt_A_C[6]);

// The left Jacobian L of the rotation r: exp(r + dr) = exp(L dr) exp(r) to first order, so that a change dr of
// a Rodrigues vector turns by w = L dr, in frame A.
void sheen_r_left_jacobian(double L[3][3], const double r_A_B[3]);

// The rotation nearest (in the Frobenius norm) to a 3x3 matrix which is one up to
// rounding, by Newton's iteration of the polar decomposition. False, and R untouched,
// where the matrix is further than `tolerance` (per element) from any rotation, is not
// finite, or mirrors.
int sheen_R_orthonormalize(double R[3][3], double tolerance);

#endif

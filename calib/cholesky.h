// SPDX-License-Identifier: Apache-2.0
// cholesky.h - small dense symmetric systems: A = L L', row-major, n up to a few dozen.
#ifndef SHEEN_CALIB_CHOLESKY_H
#define SHEEN_CALIB_CHOLESKY_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

// Replaces the lower triangle of A[n*n] by L; the upper one is neither read nor written. False, with A half
// done, where A is not positive definite beyond rounding (or not finite).
bool sheen_cholesky(double *A, int n);
// b[n] becomes the solution of L L' x = b.
void sheen_cholesky_solve(double *b, const double *L, int n);
// inverse[n*n] of L L', both triangles.
void sheen_cholesky_invert(double *inverse, const double *L, int n);

#ifdef __cplusplus
}
#endif
#endif

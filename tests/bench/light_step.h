// SPDX-License-Identifier: Apache-2.0
// light_step.h - the light step as a problem of its own: 20,000 samples, some 1,800 nodes, noise and outliers.
#ifndef SHEEN_TESTS_BENCH_LIGHT_STEP_H
#define SHEEN_TESTS_BENCH_LIGHT_STEP_H

#include "fit/light_matrix.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct light_step {
    sheen_light_matrix m; // values set
    float *y;             // [n_samples] A x_true + noise, 5 % of them outliers
    double *x_true;       // [n_nodes]
    double scale;         // of the Lorentzian: the noise
} light_step;

void light_step_make(light_step *p, size_t n_samples, uint64_t seed);
void light_step_release(light_step *p);
// E of eq. (9) at x.
double light_step_objective(const light_step *p, const double *x);

// Solves it with Ceres (bounds, Cauchy loss, conjugate gradients), x from where it is. Returns 0 where Ceres was not built in.
int light_step_ceres(double *x, const light_step *p, int max_iterations);

#ifdef __cplusplus
}
#endif
#endif

// SPDX-License-Identifier: Apache-2.0
// robust.h - the M-estimator of equations (9) to (11).
//
// Eq. (10) squares the scaled residual, z = (r / sigma_err)^2, and eq. (11) squares it again: log(1 + z^2 / 2). Taken
// together that is log(1 + (r / sigma_err)^4 / 2), which is flat about r = 0. The Lorentzian of the literature, and of the
// paper's own words, is log(1 + (r / sigma_err)^2 / 2). The second is the default; both are here.
#ifndef SHEEN_FIT_ROBUST_H
#define SHEEN_FIT_ROBUST_H

#include <stddef.h>

typedef enum sheen_loss {
    SHEEN_LOSS_LORENTZIAN, // log(1 + (r/s)^2 / 2)
    SHEEN_LOSS_QUARTIC,    // log(1 + (r/s)^4 / 2), eq. (10) and (11) to the letter
} sheen_loss;

// rho of one residual, and the weight by which an iteratively reweighted least-squares step counts it: rho'(r) / r
// times a constant, so that the Lorentzian's is 1 at r = 0.
double sheen_loss_rho(sheen_loss loss, double residual, double scale);
double sheen_loss_weight(sheen_loss loss, double residual, double scale);

// E of eq. (9): the mean of rho over n residuals.
double sheen_loss_mean(sheen_loss loss, const double *residuals, size_t n, double scale);

// 1.4826 times the median absolute residual: the standard deviation of Gaussian residuals whatever the outliers.
// scratch: n numbers.
double sheen_robust_scale(const double *residuals, size_t n, double *scratch);

#endif

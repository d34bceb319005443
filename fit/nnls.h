// SPDX-License-Identifier: Apache-2.0
// nnls.h - non-negative light intensities under the M-estimator: the (L_l, k_S) half of section 4.3.
#ifndef SHEEN_FIT_NNLS_H
#define SHEEN_FIT_NNLS_H

#include "fit/light_matrix.h"
#include "fit/robust.h"

typedef struct sheen_nnls_options {
    sheen_loss loss;
    double scale;         // sigma_err
    int max_rounds;       // reweightings
    int sweeps_per_round; // coordinate sweeps between two reweightings
    double tolerance;     // relative decrease of E in a round that ends it
} sheen_nnls_options;

// Lowers E(x) = mean rho(y - A x) over x >= 0 by coordinate descent on reweighted least squares (each round's quadratic
// touches the Lorentzian's E from above, so E never rises; the quartic has no such guarantee). m: values set for the current sigma. x [n_nodes]: start and result.
// residual [n_samples]: y - A x of the result. weight [n_samples]: scratch. Returns E.
double sheen_nnls(const sheen_light_matrix *m, const float *y, double *x, double *residual, double *weight,
                  const sheen_nnls_options *options);

#endif

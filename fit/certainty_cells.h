// SPDX-License-Identifier: Apache-2.0
// certainty_cells.h - how much a fit's equations scatter from one piece of the surface to the next.
//
// Residuals are not independent: an error of the texture is in all photographs of a place and in its neighbours. So the scores
// s = sum w r J are summed over cells of the surface first, and their scatter B = sum_cells s s' between cells takes the place of the
// residuals' variance: C = A^-1 B A^-1 (the cluster-robust covariance of White 1980 and Liang and Zeger 1986).
#ifndef SHEEN_FIT_CERTAINTY_CELLS_H
#define SHEEN_FIT_CERTAINTY_CELLS_H

#include <stddef.h>

#include "base/status.h"
#include "fit/residual.h"

typedef struct sheen_score_cells {
    float low[3], per_m; // of the grid of cells
    size_t n_parameters;
    double *score; // [cells][n_parameters]
} sheen_score_cells;

// Cells about the places of all the pixels, twelve along the longest side. ENOMEM.
sheen_status sheen_score_cells_init(sheen_score_cells *c, const sheen_residual *residuals, size_t n_views,
                                    size_t n_parameters, sheen_err *err);
void sheen_score_cells_release(sheen_score_cells *c);

// Adds factor times J[n_parameters] to the cell of p_obj.
void sheen_score_cells_add(sheen_score_cells *c, const float p_obj[3], double factor, const double *J);

// variance[n_parameters]: the diagonal of A^-1 B A^-1, and *along that of a combination v. inverse: A^-1, symmetric.
void sheen_score_cells_variance(double *variance, double *along, const sheen_score_cells *c,
                                const double *inverse, const double *v);

#endif

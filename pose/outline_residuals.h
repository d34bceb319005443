// SPDX-License-Identifier: Apache-2.0
// outline_residuals.h - distances from outlines to borders as they enter the fit, and what they say of its worth.
#ifndef SHEEN_POSE_OUTLINE_RESIDUALS_H
#define SHEEN_POSE_OUTLINE_RESIDUALS_H

#include <stdbool.h>
#include <stddef.h>

#include "pose/outline_fit.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_outline_residual {
    double distance_px, length_px;    // to the border; of the outline that it stands for
    double J[SHEEN_OUTLINE_UNKNOWNS]; // how the outline moves along its normal; 0 for what is not free
    size_t i_group;                   // those whose errors may go together
} sheen_outline_residual;

typedef struct sheen_outline_residuals {
    sheen_outline_residual *list;
    size_t n, capacity, n_groups;
    double length_px; // of all outlines where the mask is known, border found or not
    double far2_px2;  // squared distance at which the weight is a quarter
    double offset_weight,
        offset_sigma_px; // what is expected of the offset: as a residual of that weight; its sigma
} sheen_outline_residuals;

// Geman and McClure's weight of a distance, times the outline's length.
double sheen_outline_weight(const sheen_outline_residuals *all, const sheen_outline_residual *r);

// The fit's covariance from what each group would do to it if it were left out: a jackknife, to first order. Errors
// inside of a group may be correlated as they will (a mask's, a mesh's, those of a frame's pose); those of different
// groups are taken to be independent. Infinite on the diagonal where one group alone determines an unknown; zero
// rows for what is not free. H: the weighted normal matrix.
//     C = (F - 1) / F sum_f m_f m_f' / c^2 + p p',  m_f = (H - H_f)^-1 g_f,  g_f = sum_f w J r
// c: how much less the weighted equations give way than H says, since weights fall with the distance; p: what the
// offset's expectation would do if it were off by its sigma.
// MacKinnon and White 1985 (HC3), by clusters as in Bell and McCaffrey 2002.
sheen_status sheen_outline_covariance(double covariance[SHEEN_OUTLINE_UNKNOWNS * SHEEN_OUTLINE_UNKNOWNS],
                                      const double *H, const sheen_outline_residuals *all,
                                      const bool is_free[SHEEN_OUTLINE_UNKNOWNS], sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

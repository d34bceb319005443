// SPDX-License-Identifier: Apache-2.0
// calibrate_outliers.c - rejects corners by the length of their residual against a robust sigma.
//
// Residuals (x, y) with sigma per axis have a length with median sigma sqrt(2 ln 2) (Rayleigh). mrcal's own
// rejection is not used: libmrcal 2.2 loses the memory of a whole solver at each of its rounds.
#include "calib/calibrate_outliers.h"
#include "base/order.h"

#include <math.h>
#include <stdlib.h>

static const double MEDIAN_OF_RAYLEIGH = 1.1774100225154747; // sqrt(2 ln 2)
static const double LEAST_SIGMA_PX = 0.01;                   // perfect corners have no outliers

sheen_status sheen_problem_reject(int *n_out, double *longest, sheen_problem *p, double limit, sheen_err *err)
{
    const size_t n = sheen_problem_corners(p);
    double *length = malloc(n * sizeof *length);
    if (!length)
        return sheen_fail_memory(err, (double)n * sizeof *length, "a calibration");
    size_t n_used = 0;
    for (size_t i = 0; i < n; i++)
        if (p->observations[3 * i + 2] > 0)
            length[n_used++] = hypot(p->residuals_px[2 * i], p->residuals_px[2 * i + 1]);
    *n_out = 0;
    *longest = 0;
    if (n_used) {
        qsort(length, n_used, sizeof *length, sheen_ascending);
        const double sigma_px = fmax(LEAST_SIGMA_PX, length[n_used / 2] / MEDIAN_OF_RAYLEIGH);
        const double limit_px = limit * sigma_px;
        *longest = length[n_used - 1] / sigma_px;
        for (size_t i = 0; i<n && * longest> limit; i++)
            if (p->observations[3 * i + 2] > 0 &&
                !(hypot(p->residuals_px[2 * i], p->residuals_px[2 * i + 1]) <= limit_px)) {
                p->observations[3 * i + 2] = -1;
                ++*n_out;
            }
    }
    free(length);
    return SHEEN_OK;
}

// SPDX-License-Identifier: Apache-2.0
// robust.c - Lorentzian M-estimator and the scale of residuals.
#include "fit/robust.h"

#include <math.h>
#include <stdlib.h>

double sheen_loss_rho(sheen_loss loss, double residual, double scale)
{
    const double z = residual * residual / (scale * scale);
    return log1p(0.5 * (loss == SHEEN_LOSS_QUARTIC ? z * z : z));
}

double sheen_loss_weight(sheen_loss loss, double residual, double scale)
{
    const double z = residual * residual / (scale * scale);
    return loss == SHEEN_LOSS_QUARTIC ? 2 * z / (1 + 0.5 * z * z) : 1 / (1 + 0.5 * z);
}

double sheen_loss_mean(sheen_loss loss, const double *residuals, size_t n, double scale)
{
    double sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += sheen_loss_rho(loss, residuals[i], scale);
    return n ? sum / (double)n : 0;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double sheen_robust_scale(const double *residuals, size_t n, double *scratch)
{
    if (!n)
        return 0;
    for (size_t i = 0; i < n; i++)
        scratch[i] = fabs(residuals[i]);
    qsort(scratch, n, sizeof *scratch, compare);
    return 1.4826 * scratch[n / 2];
}

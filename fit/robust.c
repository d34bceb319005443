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

static void swap(double *x, size_t a, size_t b)
{
    const double t = x[a];
    x[a] = x[b];
    x[b] = t;
}

// The value that would stand at place k were x sorted (Hoare's selection).
static double select_kth(double *x, size_t n, size_t k)
{
    size_t first = 0, last = n - 1;
    while (first < last) {
        const double pivot = x[first + (last - first) / 2];
        size_t i = first, j = last;
        for (;;) {
            while (x[i] < pivot)
                i++;
            while (x[j] > pivot)
                j--;
            if (i >= j)
                break;
            swap(x, i++, j--);
        }
        // All of first .. j are at most the pivot, all after j at least
        if (k <= j)
            last = j;
        else
            first = j + 1;
    }
    return x[k];
}

double sheen_robust_scale(const double *residuals, size_t n, double *scratch)
{
    if (!n)
        return 0;
    for (size_t i = 0; i < n; i++)
        scratch[i] = fabs(residuals[i]);
    return 1.4826 * select_kth(scratch, n, n / 2);
}

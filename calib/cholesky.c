// SPDX-License-Identifier: Apache-2.0
// cholesky.c - Cholesky's decomposition, row by row.
#include "calib/cholesky.h"

#include <math.h>
#include <stddef.h>

bool sheen_cholesky(double *A, int n)
{
    for (int i = 0; i < n; i++) {
        double *Li = A + (ptrdiff_t)i * n;
        const double diagonal = Li[i];
        for (int j = 0; j <= i; j++) {
            const double *Lj = A + (ptrdiff_t)j * n;
            double sum = Li[j];
            for (int k = 0; k < j; k++)
                sum -= Li[k] * Lj[k];
            if (j < i) {
                Li[j] = sum / Lj[j];
                continue;
            }
            // what is left of the diagonal is rounding alone: the columns depend on each other
            if (!(sum > 1e-14 * diagonal) || !isfinite(sum))
                return false;
            Li[i] = sqrt(sum);
        }
    }
    return true;
}

void sheen_cholesky_solve(double *b, const double *L, int n)
{
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++)
            b[i] -= L[(ptrdiff_t)i * n + k] * b[k];
        b[i] /= L[(ptrdiff_t)i * n + i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++)
            b[i] -= L[(ptrdiff_t)k * n + i] * b[k];
        b[i] /= L[(ptrdiff_t)i * n + i];
    }
}

void sheen_cholesky_invert(double *inverse, const double *L, int n)
{
    for (int i = 0; i < n; i++) {
        double *column = inverse + (ptrdiff_t)i * n; // the inverse is symmetric: its columns are its rows
        for (int k = 0; k < n; k++)
            column[k] = k == i;
        sheen_cholesky_solve(column, L, n);
    }
}

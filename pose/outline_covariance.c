// SPDX-License-Identifier: Apache-2.0
// outline_covariance.c - what a fit of outlines is worth, from how its groups of residuals pull against each other.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "calib/cholesky.h"
#include "pose/outline_residuals.h"

enum { N = SHEEN_OUTLINE_UNKNOWNS };

static const double MIN_BREAD = 0.3; // weights that nearly let go of everything say nothing
static const double TINY = 1e-9;     // on the diagonal, where nothing determines an unknown

// Of one group: its share of the equations.
typedef struct share {
    double H[N * N], g[N];
} share;

double sheen_outline_weight(const sheen_outline_residuals *all, const sheen_outline_residual *r)
{
    const double k = all->far2_px2 / (all->far2_px2 + r->distance_px * r->distance_px);
    return k * k * r->length_px;
}

static void add_up(share *shares, const sheen_outline_residuals *all)
{
    for (size_t i = 0; i < all->n; i++) {
        const sheen_outline_residual *r = &all->list[i];
        share *s = &shares[r->i_group];
        const double w = sheen_outline_weight(all, r);
        for (int u = 0; u < N; u++) {
            s->g[u] += w * r->J[u] * r->distance_px;
            for (int v = 0; v < N; v++)
                s->H[N * u + v] += w * r->J[u] * r->J[v];
        }
    }
}

// Mean slope of weight times distance over mean weight (Huber 1981, chapter 7).
static double bread(const sheen_outline_residuals *all)
{
    double slope = 0, weights = 0;
    for (size_t i = 0; i < all->n; i++) {
        const double d2 = all->list[i].distance_px * all->list[i].distance_px,
                     w = sheen_outline_weight(all, &all->list[i]);
        weights += w;
        slope += w * (all->far2_px2 - 3 * d2) / (all->far2_px2 + d2);
    }
    return fmax(MIN_BREAD, slope / fmax(weights, TINY));
}

// Where the fit goes without a share of the equations; H: the lower triangle.
static bool leave_out(double moved[N], const double *H, const share *s, const bool is_free[N])
{
    double A[N * N];
    for (int u = 0; u < N; u++) {
        for (int v = 0; v <= u; v++)
            A[N * u + v] = H[N * u + v] - s->H[N * u + v];
        A[N * u + u] += is_free[u] ? TINY : 1;
    }
    memcpy(moved, s->g, N * sizeof *moved);
    if (!sheen_cholesky(A, N))
        return false;
    sheen_cholesky_solve(moved, A, N);
    return true;
}

static void add_square(double covariance[N * N], const double moved[N], double weight)
{
    for (int u = 0; u < N; u++)
        for (int v = 0; v < N; v++)
            covariance[N * u + v] += weight * moved[u] * moved[v];
}

sheen_status sheen_outline_covariance(double covariance[N * N], const double *H,
                                      const sheen_outline_residuals *all, const bool is_free[N],
                                      sheen_err *err)
{
    memset(covariance, 0, N * N * sizeof *covariance);
    share *shares = calloc(all->n_groups + 1, sizeof *shares);
    if (!shares)
        return sheen_fail_memory(err, (double)all->n_groups * sizeof *shares, "outlines");
    add_up(shares, all);
    const double c = bread(all);
    double n_groups = 0, moved[N] = {0};
    bool determined = true;
    for (size_t f = 0; f < all->n_groups && determined; f++)
        if (shares[f].H[N * 3 + 3] + shares[f].H[N * 4 + 4] + shares[f].H[N * 5 + 5] > 0) {
            n_groups++;
            determined = leave_out(moved, H, &shares[f], is_free);
            add_square(covariance, moved, 1 / (c * c));
        }
    free(shares);
    for (int i = 0; i < N * N; i++)
        covariance[i] *= (n_groups - 1) / fmax(n_groups, 1);
    const share expected = {.g[SHEEN_OUTLINE_OFFSET] = all->offset_weight * all->offset_sigma_px}; // all stay
    determined = determined && n_groups > 1 && leave_out(moved, H, &expected, is_free);
    add_square(covariance, moved, 1);
    for (int u = 0; u < N; u++)
        for (int v = 0; v < N; v++)
            if (!is_free[u] || !is_free[v] || !determined)
                covariance[N * u + v] = u == v && is_free[u] ? (double)INFINITY : 0;
    return SHEEN_OK;
}

// SPDX-License-Identifier: Apache-2.0
// nnls.c - iteratively reweighted, non-negative coordinate descent over a sparse matrix by columns.
//
// The minimum along one coordinate is closed: x_l <- max(0, x_l + sum w A r / sum w A^2). It needs a pass over the
// column's pairs, and a second one to update the residuals where x_l moved. Most nodes are dark and stay so: only the
// first sweep of a round looks at them.
#include "fit/nnls.h"

#include <stdbool.h>

static void set_residual(const sheen_light_matrix *m, const float *y, const double *x, double *residual)
{
    for (size_t s = 0; s < m->n_samples; s++)
        residual[s] = (double)y[s];
    for (size_t l = 0; l < m->n_nodes; l++)
        if (x[l] > 0)
            for (size_t k = m->column_start[l]; k < m->column_start[l + 1]; k++)
                residual[m->sample[k]] -= x[l] * (double)m->value[k];
}

// One pass over all nodes, or over those that are lit.
static void sweep(const sheen_light_matrix *m, double *x, double *residual, const double *weight,
                  bool lit_only)
{
    for (size_t l = 0; l < m->n_nodes; l++) {
        if (lit_only && !(x[l] > 0))
            continue;
        double slope = 0, curvature = 0;
        for (size_t k = m->column_start[l]; k < m->column_start[l + 1]; k++) {
            const double a = (double)m->value[k], wa = weight[m->sample[k]] * a;
            slope += wa * residual[m->sample[k]];
            curvature += wa * a;
        }
        // A node in the far tails of a few lobes only would need an enormous value to matter: it stays dark
        if (curvature < 1e-3)
            continue;
        const double moved = x[l] + slope / curvature, next = moved > 0 ? moved : 0, step = next - x[l];
        if (step == 0)
            continue;
        x[l] = next;
        for (size_t k = m->column_start[l]; k < m->column_start[l + 1]; k++)
            residual[m->sample[k]] -= step * (double)m->value[k];
    }
}

double sheen_nnls(const sheen_light_matrix *m, const float *y, double *x, double *residual, double *weight,
                  const sheen_nnls_options *options)
{
    set_residual(m, y, x, residual);
    double cost = sheen_loss_mean(options->loss, residual, m->n_samples, options->scale);
    for (int round = 0; round < options->max_rounds; round++) {
        for (size_t s = 0; s < m->n_samples; s++)
            weight[s] = sheen_loss_weight(options->loss, residual[s], options->scale);
        for (int i = 0; i < options->sweeps_per_round; i++)
            sweep(m, x, residual, weight, i > 0);
        const double now = sheen_loss_mean(options->loss, residual, m->n_samples, options->scale);
        const double gain = cost - now;
        cost = now;
        if (gain <= options->tolerance * now)
            break;
    }
    return cost;
}

// SPDX-License-Identifier: Apache-2.0
// certainty_cells.c - sums scores by cell, and carries each cell's sum through the inverse.
#include "fit/certainty_cells.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 12, CELLS = SIDE * SIDE * SIDE };

sheen_status sheen_score_cells_init(sheen_score_cells *c, const sheen_residual *residuals, size_t n_views,
                                    size_t n_parameters, sheen_err *err)
{
    float low[3] = {HUGE_VALF, HUGE_VALF, HUGE_VALF}, high[3] = {-HUGE_VALF, -HUGE_VALF, -HUGE_VALF};
    float longest = 0;
    *c = (sheen_score_cells){.n_parameters = n_parameters};
    for (size_t v = 0; v < n_views; v++)
        for (size_t i = 0; i < residuals[v].count; i++)
            for (int k = 0; k < 3; k++) {
                low[k] = fminf(low[k], residuals[v].pixels[i].p_obj[k]);
                high[k] = fmaxf(high[k], residuals[v].pixels[i].p_obj[k]);
            }
    for (int k = 0; k < 3; k++)
        longest = fmaxf(longest, high[k] - low[k]);
    memcpy(c->low, low, sizeof c->low);
    c->per_m = longest > 0 ? SIDE / longest : 0;
    c->score = calloc(CELLS * n_parameters + 1, sizeof *c->score);
    return c->score ? SHEEN_OK : sheen_fail_memory(err, 8.0 * CELLS * (double)n_parameters, "uncertainties");
}

void sheen_score_cells_release(sheen_score_cells *c)
{
    free(c->score);
    c->score = NULL;
}

void sheen_score_cells_add(sheen_score_cells *c, const float p_obj[3], double factor, const double *J)
{
    size_t cell = 0;
    for (int k = 0; k < 3; k++) {
        const float at = (p_obj[k] - c->low[k]) * c->per_m;
        cell = SIDE * cell + (size_t)fminf(SIDE - 1, fmaxf(0, at));
    }
    double *score = c->score + cell * c->n_parameters;
    for (size_t a = 0; a < c->n_parameters; a++)
        score[a] += factor * J[a];
}

void sheen_score_cells_variance(double *variance, double *along, const sheen_score_cells *c,
                                const double *inverse, const double *v)
{
    const size_t N = c->n_parameters;
    memset(variance, 0, N * sizeof *variance);
    *along = 0;
    for (size_t cell = 0; cell < CELLS; cell++) {
        const double *score = c->score + cell * N;
        double by_v = 0;
        size_t k = 0;
        while (k < N && score[k] == 0)
            k++;
        if (k == N)
            continue;
        for (size_t a = 0; a < N; a++) {
            double moved = 0;
            for (size_t b = 0; b < N; b++)
                moved += inverse[a * N + b] * score[b];
            variance[a] += moved * moved;
            by_v += v[a] * moved;
        }
        *along += by_v * by_v;
    }
}

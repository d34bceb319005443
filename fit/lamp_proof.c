// SPDX-License-Identifier: Apache-2.0
// lamp_proof.c - photographs of a texel predicted by one another, with and without a lamp.
#include "fit/lamp_proof.h"

#include <math.h>
#include <stdlib.h>

#include "fit/robust.h"

enum { MOST_VIEWS = 64, REWEIGHTS = 2 };

void sheen_lamp_proof_release(sheen_lamp_proof *p)
{
    sheen_lamp_samples_release(&p->samples);
    free(p->first);
    *p = (sheen_lamp_proof){0};
}

// Weighted median of d.
static double median_of(const double *d, const double *weight, size_t n)
{
    uint8_t order[MOST_VIEWS] = {0};
    double total = 0, below = 0;
    for (size_t i = 0; i < n; i++) {
        size_t k = i;
        for (; k && d[order[k - 1]] > d[i]; k--)
            order[k] = order[k - 1];
        order[k] = (uint8_t)i;
        total += weight[i];
    }
    for (size_t k = 0; k < n; k++)
        if ((below += weight[order[k]]) >= 0.5 * total)
            return d[order[k]];
    return d[order[n - 1]];
}

// What each of n photographs of a texel is wrong by where the others predict it.
static void left_out_residuals(double *residual, const double *d, const double *weight, size_t n,
                               double scale)
{
    double w[MOST_VIEWS], mean = median_of(d, weight, n), total = 0;
    for (int round = 0; round <= REWEIGHTS; round++) {
        double sum = 0;
        total = 0;
        for (size_t i = 0; i < n; i++) {
            w[i] = weight[i] * sheen_loss_weight(SHEEN_LOSS_LORENTZIAN, d[i] - mean, scale);
            total += w[i];
            sum += w[i] * d[i];
        }
        mean = sum / total;
    }
    for (size_t i = 0; i < n; i++)
        residual[i] = (d[i] - mean) * total / fmax(total - w[i], 1e-9 * total);
}

typedef struct measure {
    const sheen_lamp_proof *proof;
    const float *all, *own; // [count] light of all lamps, and of the lamp in question
    double level;           // its typical light
    double scale;
} measure;

// Adds a texel's cost with and without the lamp, where it shines.
static void add_texel(double *with, double *without, const measure *m, size_t texel)
{
    const size_t begin = m->proof->first[texel], end = m->proof->first[texel + 1];
    double d[2][MOST_VIEWS], weight[MOST_VIEWS], residual[2][MOST_VIEWS];
    size_t n = 0;
    int shines = 0;
    for (size_t i = begin; i < end && n < MOST_VIEWS; i++, n++) {
        const sheen_lamp_sample *s = &m->proof->samples.at[i];
        d[0][n] = (double)s->Y - (double)m->all[i];
        d[1][n] = d[0][n] + (double)m->own[i];
        weight[n] = (double)s->weight;
        shines |= (double)m->own[i] > m->level;
    }
    if (!shines)
        return;
    for (int k = 0; k < 2; k++)
        left_out_residuals(residual[k], d[k], weight, n, m->scale);
    for (size_t i = 0; i < n; i++) {
        const sheen_lamp_sample *s = &m->proof->samples.at[begin + i];
        if (!((double)m->own[begin + i] > m->level))
            continue;
        for (int k = 0; k < 2; k++)
            if (!(s->clipped && residual[k][i] < 0)) // white is a lower bound
                *(k ? without : with) += weight[i] *
                                         sheen_loss_rho(SHEEN_LOSS_LORENTZIAN, residual[k][i], m->scale);
    }
}

static double explained_by(measure *m)
{
    const size_t n = m->proof->samples.count;
    double sum = 0, square = 0, with = 0, without = 0;
    for (size_t i = 0; i < n; i++) {
        sum += (double)m->own[i];
        square += (double)m->own[i] * (double)m->own[i];
    }
    if (!(sum > 0))
        return 0;
    m->level = 0.5 * square / sum;
    for (size_t t = 0; t < m->proof->n_texels; t++)
        add_texel(&with, &without, m, t);
    return without > 0 ? 1 - with / without : 0;
}

sheen_status sheen_lamp_proof_explained(double *explained, const sheen_lamp_proof *proof,
                                        const sheen_lamp *lamps, size_t n, size_t first,
                                        const sheen_lobe_shape *lobe, const sheen_lamp_fit_options *options,
                                        sheen_err *err)
{
    const size_t count = proof->samples.count;
    float *all = malloc((count + 1) * sizeof *all), *own = malloc((count + 1) * sizeof *own);
    sheen_status s = all && own ? sheen_lamp_predict(all, lamps, n, lobe, &proof->samples, options, err)
                                : sheen_fail_memory(err, 8.0 * (double)count, "samples");
    measure m = {.proof = proof, .all = all, .own = own, .scale = options->scale};
    for (size_t l = first; l < n && !s; l++) {
        if ((s = sheen_lamp_predict(own, &lamps[l], 1, lobe, &proof->samples, options, err)))
            break;
        explained[l - first] = explained_by(&m);
    }
    free(all);
    free(own);
    return s;
}

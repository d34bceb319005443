// SPDX-License-Identifier: Apache-2.0
// lamp_proof.c - photographs of a texel predicted by one another, with and without a lamp.
#include "fit/lamp_proof.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
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

// Texels are summed in pieces of this many, in their order: the same for any number of threads.
enum { PIECE = 256 };

typedef struct measure {
    const sheen_lamp_proof *proof;
    const float *all;   // [count] light of all lamps
    const float *light; // [count][n_lamps] of each
    size_t n_lamps, lamp;
    double level; // the lamp's typical light
    double scale;
    double (*piece)[2]; // [n_pieces] cost with it and without
} measure;

static double own_light(const measure *m, size_t sample)
{
    return (double)m->light[sample * m->n_lamps + m->lamp];
}

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
        d[1][n] = d[0][n] + own_light(m, i);
        weight[n] = (double)s->weight;
        shines |= own_light(m, i) > m->level;
    }
    if (!shines)
        return;
    for (int k = 0; k < 2; k++)
        left_out_residuals(residual[k], d[k], weight, n, m->scale);
    for (size_t i = 0; i < n; i++) {
        const sheen_lamp_sample *s = &m->proof->samples.at[begin + i];
        if (!(own_light(m, begin + i) > m->level))
            continue;
        for (int k = 0; k < 2; k++)
            if (!(s->clipped && residual[k][i] < 0)) // white is a lower bound
                *(k ? without : with) += weight[i] *
                                         sheen_loss_rho(SHEEN_LOSS_LORENTZIAN, residual[k][i], m->scale);
    }
}

static void add_pieces(void *self, size_t begin, size_t end)
{
    measure *m = self;
    for (size_t piece = begin; piece < end; piece++)
        for (size_t t = piece * PIECE; t < (piece + 1) * PIECE && t < m->proof->n_texels; t++)
            add_texel(&m->piece[piece][0], &m->piece[piece][1], m, t);
}

static double explained_by(measure *m, int n_threads)
{
    const size_t n = m->proof->samples.count, n_pieces = (m->proof->n_texels + PIECE - 1) / PIECE;
    double sum = 0, square = 0, with = 0, without = 0;
    for (size_t i = 0; i < n; i++) {
        sum += own_light(m, i);
        square += own_light(m, i) * own_light(m, i);
    }
    if (!(sum > 0))
        return 0;
    m->level = 0.5 * square / sum;
    memset(m->piece, 0, n_pieces * sizeof *m->piece);
    sheen_parallel_for(n_pieces, 1, n_threads, add_pieces, m);
    for (size_t i = 0; i < n_pieces; i++) {
        with += m->piece[i][0];
        without += m->piece[i][1];
    }
    return without > 0 ? 1 - with / without : 0;
}

sheen_status sheen_lamp_proof_explained(double *explained, const sheen_lamp_proof *proof,
                                        const sheen_lamp *lamps, size_t n, size_t first,
                                        const sheen_lobe_shape *lobe, const sheen_lamp_fit_options *options,
                                        sheen_err *err)
{
    const size_t count = proof->samples.count;
    float *all = calloc(count + 1, sizeof *all), *light = malloc((count * n + 1) * sizeof *light);
    measure m = {.proof = proof, .all = all, .light = light, .n_lamps = n, .scale = options->scale};
    m.piece = malloc((proof->n_texels / PIECE + 1) * sizeof *m.piece);
    const sheen_status s = all && light && m.piece
                               ? sheen_lamp_light(light, lamps, n, lobe, &proof->samples, options, err)
                               : sheen_fail_memory(err, 4.0 * (double)(count * (n + 1)), "samples");
    for (size_t i = 0; i < count * n && !s; i++)
        all[i / n] += light[i];
    for (m.lamp = first; m.lamp < n && !s; m.lamp++)
        explained[m.lamp - first] = explained_by(&m, options->n_threads);
    free(all);
    free(light);
    free(m.piece);
    return s;
}

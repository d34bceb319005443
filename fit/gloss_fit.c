// SPDX-License-Identifier: Apache-2.0
// gloss_fit.c - clusters of colours, and reweighted non-negative least squares for their shares.
#include "fit/gloss_fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fit/lamp_fit.h"
#include "fit/robust.h"

enum { MAX = SHEEN_GLOSS_MAX, FOLDS = 2, LLOYD = 8, ROUNDS = 9, SWEEPS = 30, CLUSTERED = 3000 };

static const double worth_keeping = 0.97; // of what is wrong with fewer clusters
static const double worth_having = 0.8;   // of what is wrong with one, where the object turned
static const double widest_scale =
    0.5; // a share far from the truth makes all its cluster's samples look like outliers
static const float narrowest = 0.02f; // width of a cluster, in roots of light

// A sample at which the lamps' highlights matter.
typedef struct point {
    const sheen_lamp_sample *sample;
    double light; // predicted for a gloss of 1
    int cluster;
} point;

typedef struct points {
    point *at;
    float (*weight)[MAX]; // [n] of the clusters in hand
    size_t n, step;       // clusters of colours come from every step-th
    double scale;
} points;

static double distance2(const float a[3], const float b[3])
{
    double sum = 0;
    for (int c = 0; c < 3; c++)
        sum += ((double)a[c] - (double)b[c]) * ((double)a[c] - (double)b[c]);
    return sum;
}

static void assign(points *p, const sheen_gloss *g)
{
    for (size_t i = 0; i < p->n; i += p->step) {
        const float *root = p->at[i].sample->texture_root;
        int best = 0;
        for (int k = 1; k < g->n; k++)
            if (distance2(root, g->root[k]) < distance2(root, g->root[best]))
                best = k;
        p->at[i].cluster = best;
    }
}

// Mean and, by channel, spread of each cluster; clusters without points stay where they are. count: [n].
static void measure(sheen_gloss *g, double (*spread2)[3], size_t *count, const points *p)
{
    double sum[MAX][3] = {{0}}, square[MAX][3] = {{0}};
    memset(count, 0, (size_t)g->n * sizeof *count);
    for (size_t i = 0; i < p->n; i += p->step) {
        const int k = p->at[i].cluster;
        count[k]++;
        for (int c = 0; c < 3; c++) {
            const double x = (double)p->at[i].sample->texture_root[c];
            sum[k][c] += x;
            square[k][c] += x * x;
        }
    }
    for (int k = 0; k < g->n; k++)
        for (int c = 0; c < 3; c++) {
            const double n = (double)count[k], mean = count[k] ? sum[k][c] / n : (double)g->root[k][c];
            g->root[k][c] = (float)mean;
            spread2[k][c] = count[k] ? fmax(0, square[k][c] - n * mean * mean) : 0;
        }
}

// Half of the mean distance from a cluster to the one nearest to it.
static float width_of(const sheen_gloss *g)
{
    double sum = 0;
    for (int a = 0; a < g->n; a++) {
        double least = HUGE_VAL;
        for (int b = 0; b < g->n; b++)
            if (b != a)
                least = fmin(least, distance2(g->root[a], g->root[b]));
        sum += sqrt(least);
    }
    return fmaxf(narrowest, (float)(0.3 * sum / g->n));
}

// One cluster more: the one whose colours differ most in all is cut in the channel in which they do. False: nothing to cut.
static int add_cluster(sheen_gloss *g, points *p)
{
    double spread2[MAX][3];
    size_t count[MAX];
    int widest = 0, channel = 0;
    assign(p, g);
    measure(g, spread2, count, p);
    for (int k = 0; k < g->n; k++)
        for (int c = 0; c < 3; c++)
            if (spread2[k][c] > spread2[widest][channel]) {
                widest = k;
                channel = c;
            }
    if (!(spread2[widest][channel] > 1e-9) || g->n == MAX)
        return 0;
    const float half = (float)sqrt(spread2[widest][channel] / (double)count[widest]);
    memcpy(g->root[g->n], g->root[widest], sizeof g->root[widest]);
    g->root[widest][channel] -= half;
    g->root[g->n++][channel] += half;
    for (int i = 0; i < LLOYD; i++) {
        assign(p, g);
        measure(g, spread2, count, p);
    }
    g->width = width_of(g);
    return 1;
}

static void weigh(points *p, const sheen_gloss *g)
{
    for (size_t i = 0; i < p->n; i++)
        sheen_gloss_weights(p->weight[i], g, p->at[i].sample->texture_root);
}

static double share_at(const sheen_gloss *g, const float weight[MAX])
{
    double share = 0;
    for (int k = 0; k < g->n; k++)
        share += (double)(weight[k] * g->share[k]);
    return share;
}

static double residual(const point *q, double share)
{
    return sheen_lamp_residual(q->sample, share * q->light);
}

// Is the point one of those that a fold keeps for the test? fold < 0: none is.
static int is_left_out(const point *q, int fold)
{
    return (int)(q->sample->view % FOLDS) == fold;
}

// Non-negative least squares by coordinate descent; a weak pull towards `usual` decides where there is no evidence.
static void solve(sheen_gloss *g, const double A[MAX][MAX], const double *b, double usual)
{
    double trace = 0;
    for (int k = 0; k < g->n; k++)
        trace += A[k][k];
    const double pull = 1e-3 * trace / g->n + 1e-12;
    for (int sweep = 0; sweep < SWEEPS; sweep++)
        for (int k = 0; k < g->n; k++) {
            double slope = b[k] + pull * usual;
            for (int m = 0; m < g->n; m++)
                slope -= m == k ? 0 : A[k][m] * (double)g->share[m];
            g->share[k] = (float)fmax(0, slope / (A[k][k] + pull));
        }
}

// Shares, from the points that are not left out. evidence: [n] of each, may be NULL.
static void fit_shares(sheen_gloss *g, double *evidence, const points *p, int fold)
{
    for (int k = 0; k < g->n; k++)
        g->share[k] = 1;
    for (int round = 0; round < ROUNDS; round++) {
        double A[MAX][MAX] = {{0}}, b[MAX] = {0}, above = 0, below = 0;
        const double scale = fmax(p->scale, widest_scale / (1 << round));
        for (size_t i = 0; i < p->n; i++) {
            const point *q = &p->at[i];
            const float *weight = p->weight[i];
            if (is_left_out(q, fold))
                continue;
            const double r = residual(q, share_at(g, weight));
            if (q->sample->clipped && r == 0) // a bound that holds says no more
                continue;
            const double w = sheen_loss_weight(SHEEN_LOSS_LORENTZIAN, r, scale);
            above += w * q->light * (double)q->sample->Y;
            below += w * q->light * q->light;
            for (int k = 0; k < g->n; k++) {
                const double x = w * (double)weight[k] * q->light;
                b[k] += x * (double)q->sample->Y;
                for (int m = 0; m <= k; m++)
                    A[k][m] += x * (double)weight[m] * q->light;
            }
        }
        for (int k = 0; k < g->n; k++)
            for (int m = 0; m < k; m++)
                A[m][k] = A[k][m];
        solve(g, (const double(*)[MAX])A, b, below > 0 ? above / below : 1);
        for (int k = 0; evidence && k < g->n; k++)
            evidence[k] = A[k][k];
    }
}

// What the photographs left out are wrong by, each half predicted by the other.
static double held_out_cost(const sheen_gloss *clusters, points *p)
{
    double sum = 0;
    weigh(p, clusters);
    for (int fold = 0; fold < FOLDS; fold++) {
        sheen_gloss g = *clusters;
        fit_shares(&g, NULL, p, fold);
        for (size_t i = 0; i < p->n; i++) {
            if (is_left_out(&p->at[i], fold))
                sum += sheen_loss_rho(SHEEN_LOSS_LORENTZIAN, residual(&p->at[i], share_at(&g, p->weight[i])),
                                      p->scale);
        }
    }
    return sum;
}

// An object that turned shows its texels under every lamp, half of the photographs the same as the other half, each with its own
// error of albedo, which colours foretell: where all shines alike they predict up to 9 % better by it (paints of several
// glosses: 30 % with the first number, then to a sixth).
static void choose(sheen_gloss *best, bool turned, points *p)
{
    sheen_gloss g = {.n = 1, .width = 1};
    *best = g;
    double least = (turned ? worth_having : worth_keeping) * held_out_cost(&g, p);
    while (add_cluster(&g, p)) {
        if (g.n > 4 && g.n % 4) // few numbers are enough to try
            continue;
        const double cost = held_out_cost(&g, p);
        if (cost < least) {
            *best = g;
            least = worth_keeping * cost;
        }
    }
}

sheen_status sheen_gloss_fit(sheen_gloss *out, double *strength, const sheen_lamp_samples *samples,
                             const float *predicted, double scale, bool turned, sheen_err *err)
{
    points p = {.at = malloc((samples->count + 1) * sizeof *p.at),
                .weight = malloc((samples->count + 1) * sizeof *p.weight),
                .scale = scale};
    *out = (sheen_gloss){0};
    *strength = 1;
    if (!p.at || !p.weight) {
        free(p.at);
        free(p.weight);
        return sheen_fail_memory(err, (double)(samples->count * sizeof *p.at), "samples of gloss");
    }
    for (size_t i = 0; i < samples->count; i++)
        if ((double)predicted[i] > scale)
            p.at[p.n++] = (point){.sample = &samples->at[i], .light = (double)predicted[i]};
    p.step = 1 + p.n / CLUSTERED;
    choose(out, turned, &p);
    if (out->n > 1) {
        double evidence[MAX], total = 0, most = 0;
        weigh(&p, out);
        fit_shares(out, evidence, &p, -1);
        for (int k = 0; k < out->n; k++)
            total += evidence[k];
        for (int k = 0; k < out->n; k++)
            if (evidence[k] > 0.2 * total / out->n)
                most = fmax(most, (double)out->share[k]);
        *strength = most > 0 ? most : 1;
        for (int k = 0; k < out->n; k++)
            out->share[k] /= (float)*strength;
    } else {
        *out = (sheen_gloss){0};
    }
    free(p.at);
    free(p.weight);
    return SHEEN_OK;
}

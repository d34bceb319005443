// SPDX-License-Identifier: Apache-2.0
// irradiance_fit.c - Gauss-Newton steps with the albedos eliminated, and the Lorentzian's weights; lamps are never
// negative, nor is the harmonics' sum.
//
// What an axis hides: turning about z keeps n_z, so any g(n_z) can move between albedo and light. A weak pull of all but
// the constant towards 0 settles it in favour of even light.
#include "fit/irradiance_fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "calib/cholesky.h"

enum { TERMS = SHEEN_AMBIENT_TERMS, MAX_UNKNOWNS = TERMS + SHEEN_IRRADIANCE_MAX_LAMPS, MAX_SAMPLES = 64 };

static const double outlier_lin = 0.015,
                    outlier_share = 0.05; // scale of the robust weights: so much, and of the light
static const double pull = 1e-5;          // of the harmonics, in parts of the mean diagonal
static const double damping = 1e-3;
static const double constant = 0.28209479177387814; // Y_0

void sheen_lit_texels_release(sheen_lit_texels *t)
{
    free(t->samples);
    free(t->first);
    *t = (sheen_lit_texels){0};
}

// The row of the linear system: harmonics, then lamps' cosines where they are lit.
static int design(double x[MAX_UNKNOWNS], const sheen_irradiance *e, const sheen_lit_sample *s)
{
    double basis[TERMS];
    const int n_terms = sheen_irradiance_terms(e->degree);
    sheen_ambient_basis(basis, s->n_world);
    memcpy(x, basis, (size_t)n_terms * sizeof *x);
    for (int j = 0; j < e->n_lamps; j++) {
        float to_lamp[3];
        x[n_terms + j] = s->lit >> j & 1
                             ? (double)sheen_irradiance_lamp_cosine(to_lamp, &e->lamps[j], s->x_m, s->n_world)
                             : 0;
    }
    return n_terms + e->n_lamps;
}

static void apply(double rgb[3], const sheen_irradiance *e, const double *x)
{
    const int n_terms = sheen_irradiance_terms(e->degree);
    for (int c = 0; c < 3; c++) {
        double sum = 0;
        for (int k = 0; k < n_terms; k++)
            sum += x[k] * e->rgb[k][c];
        sum = sum > 0 ? sum : 0;
        for (int j = 0; j < e->n_lamps; j++)
            sum += x[n_terms + j] * e->lamps[j].rgb[c];
        rgb[c] = e->present ? sum : 1;
    }
}

void sheen_lit_irradiance(double rgb[3], const sheen_irradiance *e, const sheen_lit_sample *s)
{
    double x[MAX_UNKNOWNS];
    design(x, e, s);
    apply(rgb, e, x);
}

static double luminance(const double rgb[3])
{
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Median over the samples of the luminance that the albedo would have.
static double middle(const sheen_lit_sample *s, double E[][3], const double *w, size_t n)
{
    double ratio[MAX_SAMPLES] = {0};
    size_t k = 0;
    for (size_t i = 0; i < n; i++)
        if (w[i] > 0 && luminance(E[i]) > 0.02)
            ratio[k++] = (double)sheen_luminance(s[i].rgb) / luminance(E[i]);
    qsort(ratio, k, sizeof *ratio, compare);
    return k ? ratio[k / 2] : 0;
}

// Albedo of a texel and the weights of its samples. w comes as 0 for samples that have no part, else 1.
static void solve_texel(double a[3], double *w, const sheen_lit_sample *s, double E[][3], size_t n)
{
    double below[3], above[3];
    const double start = middle(s, E, w, n);
    for (int round = 0; round < 4; round++) {
        memset(below, 0, sizeof below);
        memset(above, 0, sizeof above);
        for (size_t i = 0; i < n; i++) {
            if (!(w[i] > 0))
                continue;
            const double predicted = round ? 0.2126 * a[0] * E[i][0] + 0.7152 * a[1] * E[i][1] +
                                                 0.0722 * a[2] * E[i][2]
                                           : start * luminance(E[i]);
            const double z = ((double)sheen_luminance(s[i].rgb) - predicted) /
                             (outlier_lin + outlier_share * predicted);
            w[i] = (double)s[i].weight / (1 + 0.5 * z * z) + 1e-12;
            for (int c = 0; c < 3; c++) {
                above[c] += w[i] * E[i][c] * (double)s[i].rgb[c];
                below[c] += w[i] * E[i][c] * E[i][c];
            }
        }
        for (int c = 0; c < 3; c++)
            a[c] = below[c] > 1e-9 && above[c] > 0 ? above[c] / below[c] : 0;
    }
}

void sheen_lit_albedo(double rgb[3], const sheen_irradiance *e, const sheen_lit_sample *samples, size_t n)
{
    double E[MAX_SAMPLES][3], w[MAX_SAMPLES];
    n = n < MAX_SAMPLES ? n : MAX_SAMPLES;
    for (size_t i = 0; i < n; i++) {
        sheen_lit_irradiance(E[i], e, &samples[i]);
        w[i] = 1;
    }
    solve_texel(rgb, w, samples, E, n);
}

typedef struct equations {
    double A[3][MAX_UNKNOWNS * MAX_UNKNOWNS], b[3][MAX_UNKNOWNS];
} equations;

// A texel's part. Its albedo follows the light: what a change of the light does to the prediction a E is a (x - E m), with m
// the weighted mean of x along E. Only that is left of the rows x, and the residual is what it has to explain.
static void add_texel(equations *q, double x[][MAX_UNKNOWNS], double E[][3], const double *w,
                      const double a[3], const sheen_lit_sample *s, size_t n, int n_unknowns)
{
    for (int c = 0; c < 3; c++) {
        double m[MAX_UNKNOWNS] = {0}, below = 0;
        for (size_t k = 0; k < n; k++) {
            below += w[k] * E[k][c] * E[k][c];
            for (int i = 0; i < n_unknowns; i++)
                m[i] += w[k] * E[k][c] * x[k][i];
        }
        if (!(below > 1e-9))
            continue;
        for (size_t k = 0; k < n; k++) {
            double row[MAX_UNKNOWNS];
            const double residual = (double)s[k].rgb[c] - a[c] * E[k][c];
            for (int i = 0; i < n_unknowns; i++) {
                row[i] = a[c] * (x[k][i] - E[k][c] * m[i] / below);
                q->b[c][i] += w[k] * row[i] * residual;
                for (int j = 0; j <= i; j++)
                    q->A[c][i * MAX_UNKNOWNS + j] += w[k] * row[i] * row[j];
            }
        }
    }
}

static int in_fold(const sheen_lit_sample *s, int fold)
{
    return s->view % SHEEN_LIT_FOLDS == fold;
}

static void gather(equations *q, const sheen_irradiance *e, const sheen_lit_texels *t, int left_out)
{
    memset(q, 0, sizeof *q);
    for (size_t i = 0; i < t->n_texels; i++) {
        const sheen_lit_sample *s = t->samples + t->first[i];
        size_t n = t->first[i + 1] - t->first[i];
        double x[MAX_SAMPLES][MAX_UNKNOWNS], E[MAX_SAMPLES][3], w[MAX_SAMPLES], a[3] = {0, 0, 0};
        n = n < MAX_SAMPLES ? n : MAX_SAMPLES;
        int n_unknowns = 0;
        for (size_t k = 0; k < n; k++) {
            n_unknowns = design(x[k], e, &s[k]);
            apply(E[k], e, x[k]);
            w[k] = in_fold(&s[k], left_out) ? 0 : 1;
        }
        solve_texel(a, w, s, E, n);
        add_texel(q, x, E, w, a, s, n, n_unknowns);
    }
}

// Least squares about the present solution x0 in which unknowns from n_free on may not be negative: the worst offender is set to 0 until there is none.
static void solve_channel(double out[MAX_UNKNOWNS], const double *A, const double *b, const double *x0, int n,
                          int n_free)
{
    double M[MAX_UNKNOWNS * MAX_UNKNOWNS], x[MAX_UNKNOWNS], trace = 0;
    int kept[MAX_UNKNOWNS], m = n;
    for (int i = 0; i < n; i++) {
        kept[i] = i;
        trace += A[i * MAX_UNKNOWNS + i];
    }
    // A has x0 itself in its kernel (a scale of the light is one of the albedos): rows times x0 are zero, and a little
    // damping towards x0 settles it.
    const double damped = damping * trace / n + 1e-15;
    for (;;) {
        for (int i = 0; i < m; i++) {
            x[i] = b[kept[i]] + damped * x0[kept[i]];
            for (int k = 0; k <= i; k++)
                M[i * m + k] = A[kept[i] * MAX_UNKNOWNS + kept[k]];
            M[i * m + i] += damped + (kept[i] ? pull * trace / n : 0);
        }
        int worst = -1;
        if (!sheen_cholesky(M, m))
            return;
        sheen_cholesky_solve(x, M, m);
        for (int i = 0; i < m; i++)
            if (kept[i] >= n_free && x[i] < 0 && (worst < 0 || x[i] < x[worst]))
                worst = i;
        if (worst < 0)
            break;
        memmove(kept + worst, kept + worst + 1, (size_t)(m - 1 - worst) * sizeof *kept);
        m--;
    }
    memset(out, 0, MAX_UNKNOWNS * sizeof *out);
    for (int i = 0; i < m; i++)
        out[kept[i]] = x[i];
}

// The largest share of the terms beyond the constant with which their sum is nowhere negative.
static double share_not_negative(const double *x, int n_terms)
{
    enum { RINGS = 24, AROUND = 48 };
    double share = 1;
    for (int i = 0; i <= RINGS; i++)
        for (int k = 0; k < AROUND; k++) {
            const double polar = 3.14159265358979323846 * i / RINGS,
                         around = 6.28318530717958647692 * k / AROUND;
            const float n[3] = {(float)(sin(polar) * cos(around)), (float)(sin(polar) * sin(around)),
                                (float)cos(polar)};
            double basis[TERMS], rest = 0;
            sheen_ambient_basis(basis, n);
            for (int t = 1; t < n_terms; t++)
                rest += basis[t] * x[t];
            if (rest < 0)
                share = fmin(share, fmax(x[0], 0) * basis[0] / -rest);
        }
    return share;
}

// Takes a channel's solution over, scaled to a mean of 1.
static void use_channel(sheen_irradiance *e, int c, const double *x)
{
    const int n_terms = sheen_irradiance_terms(e->degree);
    const double share = share_not_negative(x, n_terms);
    double mean = fmax(x[0], 0) * constant;
    for (int j = 0; j < e->n_lamps; j++)
        mean += x[n_terms + j] / 4;
    if (!(mean > 1e-12))
        return;
    for (int k = 0; k < TERMS; k++)
        e->rgb[k][c] = k >= n_terms ? 0 : k ? share * x[k] / mean : fmax(x[0], 0) / mean;
    for (int j = 0; j < e->n_lamps; j++)
        e->lamps[j].rgb[c] = x[n_terms + j] / mean;
}

static void start_even(sheen_irradiance *e)
{
    memset(e->rgb, 0, sizeof e->rgb);
    for (int c = 0; c < 3; c++) {
        e->rgb[0][c] = 1 / constant;
        for (int j = 0; j < e->n_lamps; j++)
            e->lamps[j].rgb[c] = 0;
    }
    e->present = 1;
}

sheen_status sheen_irradiance_fit(sheen_irradiance *e, const sheen_lit_texels *texels, int left_out,
                                  int n_rounds, sheen_err *err)
{
    equations *q = malloc(sizeof *q);
    if (!q)
        return sheen_fail_memory(err, sizeof *q, "the light's equations");
    if (!e->present)
        start_even(e);
    for (int round = 0; round < n_rounds; round++) {
        const int n_terms = sheen_irradiance_terms(e->degree);
        gather(q, e, texels, left_out);
        for (int c = 0; c < 3; c++) {
            double x[MAX_UNKNOWNS] = {0}, x0[MAX_UNKNOWNS];
            for (int k = 0; k < n_terms + e->n_lamps; k++)
                x0[k] = k < n_terms ? e->rgb[k][c] : e->lamps[k - n_terms].rgb[c];
            solve_channel(x, q->A[c], q->b[c], x0, n_terms + e->n_lamps, n_terms);
            use_channel(e, c, x);
        }
    }
    free(q);
    return SHEEN_OK;
}

// How well the views of one fold are predicted from the others: mean of the Lorentzian's loss.
static void score_fold(double *sum, size_t *count, const sheen_irradiance *e, const sheen_lit_texels *t,
                       int left_out)
{
    for (size_t i = 0; i < t->n_texels; i++) {
        const sheen_lit_sample *s = t->samples + t->first[i];
        size_t n = t->first[i + 1] - t->first[i], n_kept = 0;
        double E[MAX_SAMPLES][3], w[MAX_SAMPLES], a[3] = {0, 0, 0};
        n = n < MAX_SAMPLES ? n : MAX_SAMPLES;
        for (size_t k = 0; k < n; k++) {
            sheen_lit_irradiance(E[k], e, &s[k]);
            w[k] = in_fold(&s[k], left_out) ? 0 : 1;
            n_kept += w[k] > 0;
        }
        if (n_kept < 2)
            continue;
        solve_texel(a, w, s, E, n);
        for (size_t k = 0; k < n; k++) {
            if (!in_fold(&s[k], left_out))
                continue;
            const double lit[3] = {a[0] * E[k][0], a[1] * E[k][1], a[2] * E[k][2]};
            const double z = ((double)sheen_luminance(s[k].rgb) - luminance(lit)) / outlier_lin;
            *sum += log1p(0.5 * z * z);
            ++*count;
        }
    }
}

sheen_status sheen_irradiance_choose_degree(int *degree, const sheen_irradiance *e,
                                            const sheen_lit_texels *texels, sheen_err *err)
{
    double best = HUGE_VAL;
    *degree = 0;
    for (int d = 0; d <= 2; d++) {
        double sum = 0;
        size_t count = 0;
        for (int fold = 0; fold < SHEEN_LIT_FOLDS; fold++) {
            sheen_irradiance trial = *e;
            trial.degree = d;
            trial.present = 0;
            const sheen_status s = sheen_irradiance_fit(&trial, texels, fold, 8, err);
            if (s)
                return s;
            score_fold(&sum, &count, &trial, texels, fold);
        }
        const double mean = count ? sum / (double)count : 0;
        if (mean < 0.99 * best) {
            best = mean;
            *degree = d;
        }
    }
    return SHEEN_OK;
}

// SPDX-License-Identifier: Apache-2.0
// response_fit.c - the curve under which a point's light is the same at every exposure.
//
// f(z) = s(z) exp(mu(z)), with s the sRGB curve and mu straight between N_KNOTS knots, mu(1) = 0. Of each point that two
// neighbouring exposures e_i < e_j both show without clipping, ln f(z_i) - ln e_i = ln f(z_j) - ln e_j: linear in mu. Each
// equation has the weight that a code's noise leaves it; second differences of mu are held small where few points speak.
// After Debevec, Malik, "Recovering High Dynamic Range Radiance Maps from Photographs" (SIGGRAPH 1997), with knots about
// a known curve in the place of 256 unknowns, and all points in the place of a few. OpenCV's CalibrateDebevec takes 8-bit
// pictures only, leaves both ends of the curve open, and says nothing about the error.
#include "capture/response_fit.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

enum { N_KNOTS = 33, N_FREE = N_KNOTS - 1, N_BINS = 20, MIN_IN_BIN = 20, MIN_BINS = 12 };
static const double dark = 0.02, white = 0.97; // codes beyond which a value is not trusted
static const double bright_enough = 0.12;      // code of the longer of two exposures
static const double least_mean = 0.1;  // mean of codes below which their noise bends the mean of their light
static const double smoothness = 3e-3; // weight of second differences, a share of the equations' number

typedef struct normal_equations {
    double A[N_FREE][N_FREE], b[N_FREE], n;
} normal_equations;

static double base_of(double z)
{
    return (double)sheen_transfer_decode(SHEEN_TRANSFER_SRGB, (float)z);
}

// Knot to the left of z, and how far z is from it to the next.
static int knot_of(double z, double *part)
{
    const double at = z * (N_KNOTS - 1);
    const int k = at < N_KNOTS - 2 ? (int)at : N_KNOTS - 2;
    *part = at - k;
    return k;
}

static double light_of(const double mu[N_KNOTS], double z)
{
    double part;
    const int k = knot_of(z, &part);
    return base_of(z) * exp(mu[k] + part * (mu[k + 1] - mu[k]));
}

// Adds weight (sum row_k mu_k - want)^2, with the last knot known to be 0.
static void add_equation(normal_equations *e, const int at[], const double row[], int n, double want,
                         double weight)
{
    for (int i = 0; i < n; i++) {
        if (at[i] == N_FREE)
            continue;
        e->b[at[i]] += weight * row[i] * want;
        for (int j = 0; j < n; j++)
            if (at[j] != N_FREE)
                e->A[at[i]][at[j]] += weight * row[i] * row[j];
    }
}

// Chosen by the longer exposure's code: the shorter one's noise must not decide, or it would bend the curve.
static bool is_usable(double z_short, double z_long)
{
    return z_long > bright_enough && z_long < white && z_short > dark && z_short < z_long;
}

static void add_pair(normal_equations *e, double z_i, double z_j, double exposure_ratio)
{
    double part_i, part_j;
    const int k = knot_of(z_i, &part_i), l = knot_of(z_j, &part_j);
    const int at[4] = {k, k + 1, l, l + 1};
    const double row[4] = {1 - part_i, part_i, -(1 - part_j), -part_j};
    add_equation(e, at, row, 4, log(base_of(z_j) / base_of(z_i) / exposure_ratio), z_i * z_i);
    e->n++;
}

static void add_smoothness(normal_equations *e)
{
    const double row[3] = {1, -2, 1};
    for (int k = 1; k < N_KNOTS - 1; k++) {
        const int at[3] = {k - 1, k, k + 1};
        add_equation(e, at, row, 3, 0, smoothness * (e->n + 1));
    }
}

// Cholesky's decomposition. False: singular.
static bool solve(double x[N_FREE], normal_equations *e)
{
    for (int i = 0; i < N_FREE; i++)
        for (int j = 0; j <= i; j++) {
            double sum = e->A[i][j];
            for (int k = 0; k < j; k++)
                sum -= e->A[i][k] * e->A[j][k];
            if (i == j && !(sum > 0))
                return false;
            e->A[i][j] = i == j ? sqrt(sum) : sum / e->A[j][j];
        }
    for (int i = 0; i < N_FREE; i++) {
        x[i] = e->b[i];
        for (int k = 0; k < i; k++)
            x[i] -= e->A[i][k] * x[k];
        x[i] /= e->A[i][i];
    }
    for (int i = N_FREE - 1; i >= 0; i--) {
        for (int k = i + 1; k < N_FREE; k++)
            x[i] -= e->A[k][i] * x[k];
        x[i] /= e->A[i][i];
    }
    return true;
}

static bool fit(double mu[N_KNOTS], const sheen_response_data *d)
{
    normal_equations e = {0};
    for (int i = 0; i + 1 < d->n_exposures; i++)
        for (size_t p = 0; p < d->n_points; p++) {
            const double z_i = (double)d->codes[(size_t)i * d->n_points + p];
            const double z_j = (double)d->codes[(size_t)(i + 1) * d->n_points + p];
            if (is_usable(z_i, z_j))
                add_pair(&e, z_i, z_j, d->exposure_s[i + 1] / d->exposure_s[i]);
        }
    add_smoothness(&e);
    mu[N_FREE] = 0;
    return solve(mu, &e);
}

// Mean relative disagreement of neighbouring exposures where the longer one has a code of this bin; its noise averages
// out. *n_bins: those with enough points.
static double disagreement(const sheen_response_data *d, const float light[SHEEN_RESPONSE_CODES], int *n_bins)
{
    double total = 0;
    *n_bins = 0;
    for (int i = 0; i + 1 < d->n_exposures; i++) {
        double sum[N_BINS] = {0}, n[N_BINS] = {0}, least[N_BINS] = {0};
        for (size_t p = 0; p < d->n_points; p++) {
            const double z_i = (double)d->codes[(size_t)i * d->n_points + p];
            const double z_j = (double)d->codes[(size_t)(i + 1) * d->n_points + p];
            if (!(z_j > dark && z_j < white && z_i < z_j))
                continue;
            const double x = (double)light[(int)(z_i * (SHEEN_RESPONSE_CODES - 1) + 0.5)] / d->exposure_s[i];
            const double y = (double)light[(int)(z_j * (SHEEN_RESPONSE_CODES - 1) + 0.5)] /
                             d->exposure_s[i + 1];
            sum[(int)(z_j * N_BINS)] += (x - y) / fmax(0.5 * (x + y), 1e-12);
            least[(int)(z_j * N_BINS)] += z_i;
            n[(int)(z_j * N_BINS)]++;
        }
        for (int k = 0; k < N_BINS; k++)
            if (n[k] >= MIN_IN_BIN && least[k] / n[k] > least_mean) {
                total += sum[k] / n[k] * (sum[k] / n[k]);
                ++*n_bins;
            }
    }
    return *n_bins ? sqrt(total / *n_bins) : (double)NAN;
}

// How many parts of the range of codes the points fill.
static int parts_seen(const sheen_response_data *d)
{
    size_t n[N_BINS] = {0};
    int seen = 0;
    for (size_t i = 0; i < d->n_points * (size_t)d->n_exposures; i++)
        if ((double)d->codes[i] < white)
            n[(int)fmax(0, (double)d->codes[i] * N_BINS)]++;
    for (int k = 0; k < N_BINS; k++)
        seen += n[k] >= MIN_IN_BIN;
    return seen;
}

sheen_status sheen_response_solve(sheen_response_fit *out, const sheen_response_data *data,
                                  sheen_transfer claimed, sheen_err *err)
{
    double mu[N_KNOTS];
    int n_bins;
    if (data->n_exposures < 3)
        return sheen_fail(err, SHEEN_EARG, "a response wants three exposures and more");
    if (parts_seen(data) < MIN_BINS)
        return sheen_fail(err, SHEEN_EDATA,
                          "the picture shows too few degrees of brightness to measure a response from: point "
                          "the camera at something with dark, grey and white parts, such as the board in a "
                          "room, out of focus");
    if (!fit(mu, data))
        return sheen_fail(err, SHEEN_EDATA, "too few points are seen at two exposures without clipping");
    float claim[SHEEN_RESPONSE_CODES];
    float before = 0;
    for (int i = 0; i < SHEEN_RESPONSE_CODES; i++) {
        const double z = i / (SHEEN_RESPONSE_CODES - 1.0);
        claim[i] = sheen_transfer_decode(claimed, (float)z);
        before = fmaxf(before, fminf(1, (float)light_of(mu, z)));
        out->light[i] = before;
    }
    out->light[SHEEN_RESPONSE_CODES - 1] = 1;
    out->residual = disagreement(data, out->light, &n_bins);
    out->residual_claimed = disagreement(data, claim, &n_bins);
    return n_bins ? SHEEN_OK
                  : sheen_fail(err, SHEEN_EDATA, "too few points are seen at two exposures without clipping");
}

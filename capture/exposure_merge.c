// SPDX-License-Identifier: Apache-2.0
// exposure_merge.c - the maximum-likelihood sum of exposures under measured noise.
//
// Noise: half the squared difference of a pair is an estimate of the variance at that value, whatever the scene; over
// all pixels a line in x is fitted by least squares. Sum: L = sum w_i x_i r_i / sum w_i, r_i = reference / exposure_i,
// w_i = 1 / (r_i^2 var(x_i)): each value counts with the inverse of its variance (Hasinoff, Durand, Freeman,
// "Noise-Optimal Capture for High Dynamic Range Photography", CVPR 2010).
#include "capture/exposure_merge.h"

#include <math.h>
#include <stdbool.h>

static const double saturated_from = 0.98, least_variance = 1e-7;

typedef struct line_fit {
    double n, x, y, xx, xy;
} line_fit;

static void add_pair(line_fit *f, const sheen_exposure *e)
{
    const size_t n = (size_t)e->pair[0].width_px * (size_t)e->pair[0].height_px * 3;
    for (size_t i = 0; i < n; i++) {
        const double a = (double)e->pair[0].data[i], b = (double)e->pair[1].data[i];
        const double x = 0.5 * (a + b), y = 0.5 * (a - b) * (a - b);
        if (x < 0.005 || x > 0.9) // clipped values do not vary
            continue;
        f->n++;
        f->x += x;
        f->y += y;
        f->xx += x * x;
        f->xy += x * y;
    }
}

static void solve_noise(double noise[2], const line_fit *f)
{
    const double det = f->n * f->xx - f->x * f->x;
    noise[0] = f->n > 0 ? f->y / f->n : least_variance;
    noise[1] = 0;
    if (det > 1e-9 * f->n * f->n) {
        noise[1] = fmax(0, (f->n * f->xy - f->x * f->y) / det);
        noise[0] = fmax(0, (f->y - noise[1] * f->x) / f->n);
    }
}

static bool is_saturated(const sheen_exposure *e, size_t pixel)
{
    for (int k = 0; k < 2; k++)
        for (size_t c = 0; c < 3; c++)
            if ((double)e->pair[k].data[3 * pixel + c] >= saturated_from)
                return true;
    return false;
}

static int shortest(const sheen_exposure *e, int n)
{
    int best = 0;
    for (int i = 1; i < n; i++)
        if (e[i].exposure_s < e[best].exposure_s)
            best = i;
    return best;
}

typedef struct scatter {
    double sum, n;
} scatter;

// One pixel; false where every exposure is saturated.
static bool merge_pixel(float rgb[3], scatter *s, const sheen_exposure *e, int n, size_t pixel,
                        double reference_s, const double noise[2])
{
    double light[3] = {0}, weight[3] = {0}, x[SHEEN_MERGE_MAX][3] = {{0}};
    bool used[SHEEN_MERGE_MAX], any = false;
    for (int i = 0; i < n; i++) {
        const double r = reference_s / e[i].exposure_s;
        used[i] = !is_saturated(&e[i], pixel);
        any = any || used[i];
        for (size_t c = 0; c < 3; c++) {
            x[i][c] = 0.5 *
                      ((double)e[i].pair[0].data[3 * pixel + c] + (double)e[i].pair[1].data[3 * pixel + c]);
            const double w = 1 / (r * r * fmax(least_variance, noise[0] + noise[1] * x[i][c]));
            light[c] += used[i] ? w * x[i][c] * r : 0;
            weight[c] += used[i] ? w : 0;
        }
    }
    const int last = shortest(e, n);
    for (size_t c = 0; c < 3; c++)
        rgb[c] = (float)(any ? light[c] / weight[c] : x[last][c] * reference_s / e[last].exposure_s);
    for (int i = 0; any && i < n; i++)
        for (size_t c = 0; c < 3; c++)
            if (used[i] && x[i][c] > 0.05 && x[i][c] < 0.9) {
                const double off = x[i][c] * reference_s / e[i].exposure_s / (double)rgb[c] - 1;
                s->sum += off * off;
                s->n++;
            }
    return any;
}

static sheen_status check(const sheen_exposure *e, int n, sheen_err *err)
{
    if (n < 2 || n > SHEEN_MERGE_MAX)
        return sheen_fail(err, SHEEN_EARG, "a bracket has 2 to %d exposures", SHEEN_MERGE_MAX);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < 2; k++)
            if (e[i].pair[k].n_channels != 3 || e[i].pair[k].width_px != e[0].pair[0].width_px ||
                e[i].pair[k].height_px != e[0].pair[0].height_px || !(e[i].exposure_s > 0))
                return sheen_fail(err, SHEEN_EARG, "the exposures of a bracket differ in size");
    return SHEEN_OK;
}

sheen_status sheen_exposures_merge(sheen_image *out, sheen_merge_report *report,
                                   const sheen_exposure *exposures, int n_exposures, double reference_s,
                                   sheen_err *err)
{
    line_fit fit = {0};
    scatter s = {0};
    *out = (sheen_image){0};
    *report = (sheen_merge_report){0};
    sheen_status st = check(exposures, n_exposures, err);
    if (!st)
        st = sheen_image_init(out, exposures[0].pair[0].width_px, exposures[0].pair[0].height_px, 4, err);
    if (st)
        return st;
    for (int i = 0; i < n_exposures; i++)
        add_pair(&fit, &exposures[i]);
    solve_noise(report->noise, &fit);
    const size_t n = (size_t)out->width_px * (size_t)out->height_px;
    size_t n_saturated = 0;
    for (size_t i = 0; i < n; i++) {
        const bool known = merge_pixel(out->data + 4 * i, &s, exposures, n_exposures, i, reference_s,
                                       report->noise);
        out->data[4 * i + 3] = known ? 1 : 0;
        n_saturated += !known;
    }
    report->residual = s.n > 0 ? sqrt(s.sum / s.n) : (double)NAN;
    report->saturated = (double)n_saturated / (double)n;
    return SHEEN_OK;
}

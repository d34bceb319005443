// SPDX-License-Identifier: Apache-2.0
// saddle_polish.c - a refined corner's last step, and its covariance, from the window in which it was refined (see the
// header).
#include "calib/saddle_polish.h"

#include <math.h>
#include <string.h>

#include "calib/saddle_refine.h"

// The window, and a sample beyond it on each side for differences; the pixels that interpolation needs.
enum {
    MAX_SAMPLES = 2 * SHEEN_SADDLE_MAX_HALF_PX + 3,
    TAPS = 6,
    BEFORE = TAPS / 2 - 1,
    MAX_PIXELS = MAX_SAMPLES + TAPS - 1,
    STEPS = 2
};

static const double STEP_PX = 0.2; // for df/dq
static const double MAX_MOVE_PX = 0.5;
static const double LEAST_STIFFNESS = 1; // squared grey values a pixel: one step of grey in all the window

typedef struct window {
    int half_px, n_samples, n_pixels;        // along one axis
    double weight[MAX_SAMPLES];              // along one axis
    double tap_x[TAPS], tap_y[TAPS];         // of the pixels from BEFORE a sample's on
    double sample[MAX_SAMPLES][MAX_SAMPLES]; // grey values at q + (i, j)
    double K[2][MAX_SAMPLES][MAX_SAMPLES];   // df / d sample
} window;

static void window_init(window *w, int half_px)
{
    w->half_px = half_px;
    w->n_samples = 2 * half_px + 3;
    w->n_pixels = w->n_samples + TAPS - 1;
    for (int a = 0; a < w->n_samples; a++) {
        const double u = (double)(a - half_px - 1) / half_px;
        w->weight[a] = exp(-u * u);
    }
}

// Lagrange's polynomial through TAPS pixels, at a of the way from the middle one to the next.
static void lagrange_taps(double tap[TAPS], double a)
{
    for (int k = 0; k < TAPS; k++) {
        tap[k] = 1;
        for (int m = 0; m < TAPS; m++)
            if (m != k)
                tap[k] *= (a - (m - BEFORE)) / (k - m);
    }
}

static bool window_read(window *w, const uint8_t *grey, int width_px, int height_px, const double q_px[2])
{
    const int x0 = (int)floor(q_px[0]) - w->half_px - 1 - BEFORE;
    const int y0 = (int)floor(q_px[1]) - w->half_px - 1 - BEFORE;
    if (x0 < 0 || y0 < 0 || x0 + w->n_pixels > width_px || y0 + w->n_pixels > height_px)
        return false;
    lagrange_taps(w->tap_x, q_px[0] - floor(q_px[0]));
    lagrange_taps(w->tap_y, q_px[1] - floor(q_px[1]));
    double row[MAX_PIXELS][MAX_SAMPLES] = {{0}}; // between the pixels of a row
    for (int j = 0; j < w->n_pixels; j++) {
        const uint8_t *p = grey + (size_t)(y0 + j) * (size_t)width_px + (size_t)x0;
        for (int i = 0; i < w->n_samples; i++) {
            row[j][i] = 0;
            for (int k = 0; k < TAPS; k++)
                row[j][i] += w->tap_x[k] * p[i + k];
        }
    }
    for (int j = 0; j < w->n_samples; j++)
        for (int i = 0; i < w->n_samples; i++) {
            w->sample[j][i] = 0;
            for (int k = 0; k < TAPS; k++)
                w->sample[j][i] += w->tap_y[k] * row[j + k][i];
        }
    return true;
}

static void add(window *w, int i, int j, double sign, const double df[2])
{
    w->K[0][j][i] += sign * df[0];
    w->K[1][j][i] += sign * df[1];
}

static double gradient_x(const window *w, int a, int b)
{
    return w->sample[b][a + 1] - w->sample[b][a - 1];
}

static double gradient_y(const window *w, int a, int b)
{
    return w->sample[b + 1][a] - w->sample[b - 1][a];
}

// f = sum w g (g . p) of the window as it was read.
static void force(double f[2], const window *w)
{
    const int half_px = w->half_px;
    f[0] = f[1] = 0;
    for (int j = -half_px; j <= half_px; j++)
        for (int i = -half_px; i <= half_px; i++) {
            const int a = i + half_px + 1, b = j + half_px + 1;
            const double gx = gradient_x(w, a, b), gy = gradient_y(w, a, b);
            const double along = w->weight[a] * w->weight[b] * (gx * i + gy * j);
            f[0] += along * gx;
            f[1] += along * gy;
        }
}

// K by the gradient's derivatives at the place (i, j) from q.
static void add_place(window *w, int i, int j)
{
    const int a = i + w->half_px + 1, b = j + w->half_px + 1;
    const double gx = gradient_x(w, a, b), gy = gradient_y(w, a, b), along = gx * i + gy * j;
    const double weight = w->weight[a] * w->weight[b];
    const double by_gx[2] = {weight * (along + gx * i), weight * gy * i};
    const double by_gy[2] = {weight * gx * j, weight * (along + gy * j)};
    add(w, a + 1, b, 1, by_gx);
    add(w, a - 1, b, -1, by_gx);
    add(w, a, b + 1, 1, by_gy);
    add(w, a, b - 1, -1, by_gy);
}

// A sample's variance for pixels' of 1.
static double sample_variance(const window *w)
{
    double x = 0, y = 0;
    for (int k = 0; k < TAPS; k++) {
        x += w->tap_x[k] * w->tap_x[k];
        y += w->tap_y[k] * w->tap_y[k];
    }
    return x * y;
}

// Over all that the refinement looks at, the samples beyond the window for its differences included, as it weighs them.
static void find_asymmetry(sheen_saddle_polished *out, const window *w)
{
    const int last = w->n_samples - 1;
    double sum = 0, weights = 0, squares = 0;
    for (int b = 0; b <= last; b++)
        for (int a = 0; a <= last; a++) {
            const double weight = w->weight[a] * w->weight[b];
            const double d = w->sample[b][a] - w->sample[last - b][last - a];
            sum += weight * d * d;
            weights += weight;
            squares += weight * weight;
        }
    out->asymmetry = sqrt(sum / (2 * weights * sample_variance(w)));
    out->n_pairs = weights * weights / squares / 2;
}

// D = df/dq by differences. False where it is singular.
static bool stiffness(double D[2][2], window *w, const uint8_t *grey, int width_px, int height_px,
                      const double q_px[2])
{
    for (int k = 0; k < 2; k++) {
        double f[2][2];
        for (int side = 0; side < 2; side++) {
            double moved[2] = {q_px[0], q_px[1]};
            moved[k] += side ? STEP_PX : -STEP_PX;
            if (!window_read(w, grey, width_px, height_px, moved))
                return false;
            force(f[side], w);
        }
        D[0][k] = (f[1][0] - f[0][0]) / (2 * STEP_PX);
        D[1][k] = (f[1][1] - f[0][1]) / (2 * STEP_PX);
    }
    const double det = D[0][0] * D[1][1] - D[0][1] * D[1][0], trace = D[0][0] + D[1][1];
    return det > 1e-6 * trace * trace && trace < -LEAST_STIFFNESS;
}

// M = K K' in pixels: K over samples, spread over the pixels that make them.
static void over_pixels(double M[3], const window *w)
{
    double row[2][MAX_SAMPLES][MAX_PIXELS];
    M[0] = M[1] = M[2] = 0;
    for (int c = 0; c < 2; c++)
        for (int j = 0; j < w->n_samples; j++)
            for (int i = 0; i < w->n_pixels; i++) {
                row[c][j][i] = 0;
                for (int k = 0; k < TAPS; k++)
                    if (i - k >= 0 && i - k < w->n_samples)
                        row[c][j][i] += w->tap_x[k] * w->K[c][j][i - k];
            }
    for (int j = 0; j < w->n_pixels; j++)
        for (int i = 0; i < w->n_pixels; i++) {
            double by_pixel[2] = {0};
            for (int k = 0; k < TAPS; k++)
                for (int c = 0; c < 2 && j - k >= 0 && j - k < w->n_samples; c++)
                    by_pixel[c] += w->tap_y[k] * row[c][j - k][i];
            M[0] += by_pixel[0] * by_pixel[0];
            M[1] += by_pixel[0] * by_pixel[1];
            M[2] += by_pixel[1] * by_pixel[1];
        }
}

static void invert(double inverse[2][2], const double D[2][2])
{
    const double det = D[0][0] * D[1][1] - D[0][1] * D[1][0];
    inverse[0][0] = D[1][1] / det;
    inverse[0][1] = -D[0][1] / det;
    inverse[1][0] = -D[1][0] / det;
    inverse[1][1] = D[0][0] / det;
}

// C = D^-1 K K' D^-T
static void moved_by_noise(double C[3], const double inverse[2][2], window *w)
{
    double M[3];
    memset(w->K, 0, sizeof w->K);
    for (int j = -w->half_px; j <= w->half_px; j++)
        for (int i = -w->half_px; i <= w->half_px; i++)
            add_place(w, i, j);
    over_pixels(M, w);
    const double *a = inverse[0], *b = inverse[1];
    C[0] = a[0] * a[0] * M[0] + 2 * a[0] * a[1] * M[1] + a[1] * a[1] * M[2];
    C[1] = a[0] * b[0] * M[0] + (a[0] * b[1] + a[1] * b[0]) * M[1] + a[1] * b[1] * M[2];
    C[2] = b[0] * b[0] * M[0] + 2 * b[0] * b[1] * M[1] + b[1] * b[1] * M[2];
}

bool sheen_saddle_polish(sheen_saddle_polished *out, const uint8_t *grey, int width_px, int height_px,
                         const double q_px[2], int half_px)
{
    window w;
    double D[2][2], inverse[2][2], f[2];
    *out = (sheen_saddle_polished){.q_px = {q_px[0], q_px[1]}};
    if (half_px < 1 || half_px > SHEEN_SADDLE_MAX_HALF_PX)
        return false;
    window_init(&w, half_px);
    if (!stiffness(D, &w, grey, width_px, height_px, q_px))
        return false;
    invert(inverse, (const double(*)[2])D);
    for (int step = 0; step <= STEPS; step++) {
        if (!window_read(&w, grey, width_px, height_px, out->q_px))
            return false;
        if (step == STEPS)
            break;
        force(f, &w);
        for (int k = 0; k < 2; k++)
            out->q_px[k] -= inverse[k][0] * f[0] + inverse[k][1] * f[1];
        if (!(hypot(out->q_px[0] - q_px[0], out->q_px[1] - q_px[1]) < MAX_MOVE_PX))
            return false;
    }
    moved_by_noise(out->covariance, (const double(*)[2])inverse, &w);
    find_asymmetry(out, &w);
    return true;
}

// SPDX-License-Identifier: Apache-2.0
// saddle_noise.c - a refined corner's covariance, from the window in which it was refined (see the header).
#include "calib/saddle_noise.h"

#include <math.h>
#include <string.h>

#include "calib/saddle_refine.h"

// The window, the sample beyond it for differences, and the pixel beyond that for bilinear ones.
enum { MAX_SIDE = 2 * SHEEN_SADDLE_MAX_HALF_PX + 4 };

static const double STEP_PX = 0.2; // for df/dq

typedef struct window {
    int half_px, side;                 // side: of the block of pixels that take part
    double weight[MAX_SIDE];           // along one axis
    double x, y;                       // of q in its pixel, 0..1
    double sample[MAX_SIDE][MAX_SIDE]; // grey values at q + (i, j)
    double K[2][MAX_SIDE][MAX_SIDE];   // df / d pixel
} window;

static void window_init(window *w, int half_px)
{
    w->half_px = half_px;
    w->side = 2 * half_px + 4;
    for (int a = 0; a < w->side; a++) {
        const double u = (double)(a - half_px - 1) / half_px;
        w->weight[a] = exp(-u * u);
    }
}

static bool window_read(window *w, const uint8_t *grey, int width_px, int height_px, const double q_px[2])
{
    const int x0 = (int)floor(q_px[0]) - w->half_px - 1, y0 = (int)floor(q_px[1]) - w->half_px - 1;
    if (x0 < 0 || y0 < 0 || x0 + w->side > width_px || y0 + w->side > height_px)
        return false;
    w->x = q_px[0] - floor(q_px[0]);
    w->y = q_px[1] - floor(q_px[1]);
    for (int j = 0; j + 1 < w->side; j++)
        for (int i = 0; i + 1 < w->side; i++) {
            const uint8_t *p = grey + (size_t)(y0 + j) * (size_t)width_px + (size_t)(x0 + i);
            w->sample[j][i] = (1 - w->y) * ((1 - w->x) * p[0] + w->x * p[1]) +
                              w->y * ((1 - w->x) * p[width_px] + w->x * p[width_px + 1]);
        }
    return true;
}

// Spreads df / d sample (i, j) over the four pixels that make the sample.
static void spread(window *w, int i, int j, const double df[2])
{
    for (int c = 0; c < 2; c++) {
        w->K[c][j][i] += df[c] * (1 - w->x) * (1 - w->y);
        w->K[c][j][i + 1] += df[c] * w->x * (1 - w->y);
        w->K[c][j + 1][i] += df[c] * (1 - w->x) * w->y;
        w->K[c][j + 1][i + 1] += df[c] * w->x * w->y;
    }
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
    spread(w, a + 1, b, by_gx);
    spread(w, a - 1, b, (const double[2]){-by_gx[0], -by_gx[1]});
    spread(w, a, b + 1, by_gy);
    spread(w, a, b - 1, (const double[2]){-by_gy[0], -by_gy[1]});
}

// Over all that the refinement looks at, the samples beyond the window for its differences included.
static double asymmetry_of(const window *w)
{
    const int last = w->side - 2;
    double sum = 0;
    for (int b = 0; b <= last; b++)
        for (int a = 0; a <= last; a++) {
            const double d = w->sample[b][a] - w->sample[last - b][last - a];
            sum += d * d;
        }
    return sqrt(sum / (2.0 * (last + 1) * (last + 1)));
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
    return det > 1e-6 * trace * trace && trace < 0;
}

// C = D^-1 K K' D^-T
static void moved_by_noise(double C[3], const double D[2][2], const window *w)
{
    double M[3] = {0};
    for (int j = 0; j < w->side; j++)
        for (int i = 0; i < w->side; i++) {
            M[0] += w->K[0][j][i] * w->K[0][j][i];
            M[1] += w->K[0][j][i] * w->K[1][j][i];
            M[2] += w->K[1][j][i] * w->K[1][j][i];
        }
    const double det = D[0][0] * D[1][1] - D[0][1] * D[1][0];
    const double a[2] = {D[1][1] / det, -D[0][1] / det}, b[2] = {-D[1][0] / det, D[0][0] / det}; // rows
    C[0] = a[0] * a[0] * M[0] + 2 * a[0] * a[1] * M[1] + a[1] * a[1] * M[2];
    C[1] = a[0] * b[0] * M[0] + (a[0] * b[1] + a[1] * b[0]) * M[1] + a[1] * b[1] * M[2];
    C[2] = b[0] * b[0] * M[0] + 2 * b[0] * b[1] * M[1] + b[1] * b[1] * M[2];
}

bool sheen_saddle_noise(double covariance[3], double *asymmetry, const uint8_t *grey, int width_px,
                        int height_px, const double q_px[2], int half_px)
{
    window w;
    double D[2][2];
    memset(covariance, 0, 3 * sizeof *covariance);
    *asymmetry = 0;
    if (half_px < 1 || half_px > SHEEN_SADDLE_MAX_HALF_PX)
        return false;
    window_init(&w, half_px);
    if (!stiffness(D, &w, grey, width_px, height_px, q_px) ||
        !window_read(&w, grey, width_px, height_px, q_px))
        return false;
    memset(w.K, 0, sizeof w.K);
    for (int j = -half_px; j <= half_px; j++)
        for (int i = -half_px; i <= half_px; i++)
            add_place(&w, i, j);
    moved_by_noise(covariance, (const double(*)[2])D, &w);
    *asymmetry = asymmetry_of(&w);
    return true;
}

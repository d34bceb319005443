// SPDX-License-Identifier: Apache-2.0
// vignetting.c - the light towards the edges, from the board's white (see the header).
#include "calib/vignetting.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "calib/cholesky.h"

enum { LOCAL = 3, MIN_FRAMES = 5, MIN_WHITES = 12 };

static const double MOST_DN = 250;       // above: clipped
static const double LEAST_DN = 20;       // below: noise and the black level
static const double LEAST_REACH = 0.6;   // of half of the diagonal
static const double MOST_SIGMA = 0.02;   // of the light at the reach
static const double BOARD_UNIT_M = 0.05; // scale of the slopes, for the numbers' sake

// What a frame says of k, its own unknowns eliminated: S k = r.
typedef struct share {
    double S[3], r[2]; // xx, xy, yy
    bool counts;
} share;

// The equation of one white place: its coefficients (1, x, y | rho^2, rho^4) and its logarithm. False where its code says
// nothing.
static bool equation(double row[LOCAL + 2], double *value, double *rho, const sheen_saddle *corner,
                     const sheen_board_view *view, const sheen_camera *camera)
{
    if (!(corner->white_dn >= LEAST_DN && corner->white_dn <= MOST_DN))
        return false;
    const double half_px = hypot(camera->width_px, camera->height_px) / 2;
    *rho = hypot(corner->q_px[0] - camera->intrinsics[2], corner->q_px[1] - camera->intrinsics[3]) / half_px;
    row[0] = 1;
    row[1] = corner->p_board[0] / BOARD_UNIT_M;
    row[2] = corner->p_board[1] / BOARD_UNIT_M;
    row[3] = *rho * *rho;
    row[4] = row[3] * row[3];
    *value = log((double)sheen_transfer_decode(view->transfer, (float)(corner->white_dn / 255)));
    return true;
}

static share share_of(const sheen_board_view *view, const sheen_camera *camera, double *reach)
{
    enum { N = LOCAL + 2 };
    double A[N][N] = {{0}}, b[N] = {0}, L[LOCAL * LOCAL], rho, value, row[N], farthest = 0;
    int n = 0;
    share s = {0};
    for (size_t i = 0; i < view->n_saddles; i++) {
        if (!equation(row, &value, &rho, &view->saddles[i], view, camera))
            continue;
        n++;
        farthest = fmax(farthest, rho);
        for (int u = 0; u < N; u++) {
            b[u] += row[u] * value;
            for (int v = 0; v < N; v++)
                A[u][v] += row[u] * row[v];
        }
    }
    for (int u = 0; u < LOCAL; u++)
        for (int v = 0; v < LOCAL; v++)
            L[LOCAL * u + v] = A[u][v];
    if (n < MIN_WHITES || !sheen_cholesky(L, LOCAL))
        return s;
    double solved[2][LOCAL];
    for (int k = 0; k < 2; k++) {
        for (int u = 0; u < LOCAL; u++)
            solved[k][u] = A[u][LOCAL + k];
        sheen_cholesky_solve(solved[k], L, LOCAL);
    }
    s = (share){{A[3][3], A[3][4], A[4][4]}, {b[3], b[4]}, true};
    for (int u = 0; u < LOCAL; u++) {
        s.S[0] -= A[u][3] * solved[0][u];
        s.S[1] -= A[u][3] * solved[1][u];
        s.S[2] -= A[u][4] * solved[1][u];
        s.r[0] -= b[u] * solved[0][u];
        s.r[1] -= b[u] * solved[1][u];
    }
    *reach = fmax(*reach, farthest);
    return s;
}

// k of all shares but one; false where they do not determine it.
static bool solve(double k[2], const share *shares, size_t n, size_t without)
{
    double S[3] = {0}, r[2] = {0};
    for (size_t i = 0; i < n; i++) {
        for (int u = 0; u < 3 && i != without; u++)
            S[u] += shares[i].S[u];
        for (int u = 0; u < 2 && i != without; u++)
            r[u] += shares[i].r[u];
    }
    const double det = S[0] * S[2] - S[1] * S[1];
    if (!(det > 1e-9 * S[0] * S[2] && S[0] > 0))
        return false;
    k[0] = (S[2] * r[0] - S[1] * r[1]) / det;
    k[1] = (S[0] * r[1] - S[1] * r[0]) / det;
    return true;
}

static double log_light(const double k[2], double rho)
{
    return k[0] * rho * rho + k[1] * rho * rho * rho * rho;
}

// Fills all but n_frames and reach, from these. False where k is not determined.
static bool fit(sheen_vignetting *out, const share *shares, size_t n)
{
    double sum = 0, squares = 0;
    if (!solve(out->k, shares, n, n))
        return false;
    for (size_t i = 0; i < n; i++) {
        double k[2];
        if (!shares[i].counts)
            continue;
        if (!solve(k, shares, n, i))
            return false;
        sum += log_light(k, out->reach) / out->n_frames;
        squares += log_light(k, out->reach) * log_light(k, out->reach) / out->n_frames;
    }
    out->light = exp(log_light(out->k, out->reach));
    out->sigma = out->light * sqrt((out->n_frames - 1) * fmax(0, squares - sum * sum));
    return isfinite(out->light + out->sigma);
}

sheen_status sheen_vignetting_measure(sheen_vignetting *out, const sheen_camera *camera,
                                      const sheen_board_view *const *views, size_t n_views, sheen_err *err)
{
    *out = (sheen_vignetting){0};
    share *shares = calloc(n_views + 1, sizeof *shares);
    if (!shares)
        return sheen_fail_memory(err, (double)n_views * sizeof *shares, "vignetting");
    for (size_t i = 0; i < n_views; i++) {
        shares[i] = share_of(views[i], camera, &out->reach);
        out->n_frames += shares[i].counts;
    }
    if (out->n_frames < MIN_FRAMES)
        snprintf(out->reason, sizeof out->reason,
                 "the board's white is neither clipped nor dark in %d frames only, %d are needed",
                 out->n_frames, (int)MIN_FRAMES);
    else if (out->reach < LEAST_REACH)
        snprintf(out->reason, sizeof out->reason,
                 "the board never comes near the image's corners: it reaches %.0f %% of the way",
                 100 * out->reach);
    else if (!fit(out, shares, n_views))
        snprintf(out->reason, sizeof out->reason, "the frames do not tell it from the light on the board");
    else if (out->sigma > MOST_SIGMA)
        snprintf(out->reason, sizeof out->reason,
                 "the light on the board is too uneven: the edge would be known to %.0f %% only",
                 100 * out->sigma);
    else
        out->measured = true;
    free(shares);
    return SHEEN_OK;
}

// SPDX-License-Identifier: Apache-2.0
// lens_grid.c - derivatives by the lens over a grid of points, and their projection.
#include "calib/lens_grid.h"

#include <math.h>
#include <stdlib.h>

#include "calib/calibrate_problem.h"
#include "calib/cholesky.h"

enum { LEAST_POINTS = 12 };

void sheen_motion_gradient(double J[2][6], const double dq_dp[6], const double p[3])
{
    // d(exp(w) p + t)/d(w, t) = [-[p]x  I]
    const double dp[3][6] = {{0, p[2], -p[1], 1, 0, 0}, {-p[2], 0, p[0], 0, 1, 0}, {p[1], -p[0], 0, 0, 0, 1}};
    for (int k = 0; k < 2; k++)
        for (int j = 0; j < 6; j++)
            J[k][j] = dq_dp[3 * k] * dp[0][j] + dq_dp[3 * k + 1] * dp[1][j] + dq_dp[3 * k + 2] * dp[2][j];
}

void sheen_lens_grid_release(sheen_lens_grid *g)
{
    free(g->M);
    g->M = NULL;
}

static sheen_status fill(sheen_lens_grid *g, const sheen_camera *camera, double distance_m, sheen_err *err)
{
    double q_px[2 * SHEEN_LENS_GRID_MAX], dq_dp[6 * SHEEN_LENS_GRID_MAX];
    sheen_status s = sheen_camera_unproject(camera, g->p_cam, g->q_px, g->n, err);
    for (size_t i = 0; i < 3 * g->n; i++)
        g->p_cam[i] *= distance_m;
    if (!s)
        s = sheen_camera_project(camera, q_px, dq_dp, g->p_cam, g->n, err);
    for (size_t i = 0; i < g->n && !s; i++) {
        if (!isfinite(q_px[2 * i]))
            return sheen_fail(err, SHEEN_EDATA, "the lens has no inverse over the whole image");
        sheen_motion_gradient(&g->J[2 * i], dq_dp + 6 * i, g->p_cam + 3 * i);
        s = sheen_lens_gradient(g->M + 2 * i * g->n_lens, camera, g->p_cam + 3 * i, err);
    }
    if (!s && !sheen_lens_grid_project_out(g, g->M, g->n_lens))
        s = sheen_fail(err, SHEEN_EDATA, "the image's points do not determine a motion");
    return s;
}

sheen_status sheen_lens_grid_init(sheen_lens_grid *g, const sheen_camera *camera, double distance_m,
                                  bool (*wanted)(const void *self, const double q_px[2]), const void *self,
                                  sheen_err *err)
{
    g->n = 0;
    g->n_lens = (size_t)camera->n_intrinsics;
    for (int i = 0; i < SHEEN_LENS_GRID_MAX; i++) {
        const int col = i % SHEEN_LENS_GRID_COLS, row = i / SHEEN_LENS_GRID_COLS;
        double *q = g->q_px + 2 * g->n;
        q[0] = (col + 0.5) / SHEEN_LENS_GRID_COLS * camera->width_px - 0.5;
        q[1] = (row + 0.5) / SHEEN_LENS_GRID_ROWS * camera->height_px - 0.5;
        g->n += !wanted || wanted(self, q);
    }
    g->M = calloc(2 * g->n * g->n_lens + 1, sizeof *g->M);
    if (!g->M)
        return sheen_fail_memory(err, 2 * (double)(g->n * g->n_lens) * sizeof *g->M, "a cross-validation");
    if (g->n < LEAST_POINTS)
        return sheen_fail(err, SHEEN_EDATA, "corners cover too little of the image");
    return fill(g, camera, distance_m, err);
}

bool sheen_lens_grid_project_out(const sheen_lens_grid *g, double *values, size_t n_columns)
{
    double A[36] = {0};
    for (size_t i = 0; i < 2 * g->n; i++)
        for (int u = 0; u < 6; u++)
            for (int v = 0; v <= u; v++)
                A[6 * u + v] += g->J[i][u] * g->J[i][v];
    if (!sheen_cholesky(A, 6))
        return false;
    for (size_t k = 0; k < n_columns; k++) {
        double b[6] = {0};
        for (size_t i = 0; i < 2 * g->n; i++)
            for (int u = 0; u < 6; u++)
                b[u] += g->J[i][u] * values[i * n_columns + k];
        sheen_cholesky_solve(b, A, 6);
        for (size_t i = 0; i < 2 * g->n; i++)
            for (int u = 0; u < 6; u++)
                values[i * n_columns + k] -= g->J[i][u] * b[u];
    }
    return true;
}

double sheen_lens_grid_variance(const sheen_lens_grid *g, size_t i, const double *C)
{
    const size_t n = g->n_lens;
    const double *M = g->M + 2 * i * n;
    double sum = 0;
    for (size_t k = 0; k < 2; k++)
        for (size_t a = 0; a < n; a++) {
            double row = 0;
            for (size_t b = 0; b < n; b++)
                row += C[a * n + b] * M[k * n + b];
            sum += M[k * n + a] * row;
        }
    return sum;
}

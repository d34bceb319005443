// SPDX-License-Identifier: Apache-2.0
// compare.c - unprojects a grid with one camera, projects it with the other, and takes out the rigid motion that
// explains most of the difference (Gauss-Newton over 3 or 6 numbers).
#include "calib/compare.h"

#include <math.h>
#include <string.h>

#include "base/pose3.h"
#include "calib/cholesky.h"

enum { GRID_COLS = 32, GRID_ROWS = 24, N = GRID_COLS * GRID_ROWS, ROUNDS = 10 };

typedef struct grid {
    const sheen_camera *to;
    double centre_px[2], inner_px, outer_px;       // which points are measured
    double q_px[2 * N];                            // in the first camera
    double p_cam[3 * N];                           // there, at the distance
    double p_to[3 * N], q_to[2 * N], dq_dp[6 * N]; // in the second
} grid;

static sheen_status project(grid *g, const sheen_Rt *Rt, sheen_err *err)
{
    for (size_t i = 0; i < N; i++)
        sheen_Rt_point(g->p_to + 3 * i, Rt, g->p_cam + 3 * i);
    const sheen_status s = sheen_camera_project(g->to, g->q_to, g->dq_dp, g->p_to, N, err);
    for (size_t i = 0; i < (size_t)2 * N && !s; i++)
        if (!isfinite(g->q_to[i]))
            return sheen_fail(err, SHEEN_EDATA,
                              "the cameras cannot be compared: one looks where the other cannot");
    return s;
}

static void measure(double *rms_px, double *max_px, const grid *g)
{
    double sum = 0, max = 0;
    size_t n = 0;
    for (size_t i = 0; i < N; i++) {
        const double r = hypot(g->q_px[2 * i] - g->centre_px[0], g->q_px[2 * i + 1] - g->centre_px[1]);
        if (r < g->inner_px || r >= g->outer_px)
            continue;
        n++;
        const double e = hypot(g->q_to[2 * i] - g->q_px[2 * i], g->q_to[2 * i + 1] - g->q_px[2 * i + 1]);
        sum += e * e;
        max = fmax(max, e);
    }
    *rms_px = n ? sqrt(sum / (double)n) : (double)NAN;
    *max_px = max;
}

// One Gauss-Newton step of the first n (3: rotation, 6: and translation) numbers. False where it is singular.
static bool step(sheen_Rt *Rt, const grid *g, int n)
{
    double A[36] = {0}, b[6] = {0};
    for (size_t i = 0; i < N; i++) {
        const double *x = g->p_to + 3 * i;
        const double r[3] = {x[0] - Rt->t[0], x[1] - Rt->t[1], x[2] - Rt->t[2]};
        // d(exp(w) r + t)/d(w, t) = [-[r]x  I]
        const double dp[3][6] = {
            {0, r[2], -r[1], 1, 0, 0}, {-r[2], 0, r[0], 0, 1, 0}, {r[1], -r[0], 0, 0, 0, 1}};
        for (size_t k = 0; k < 2; k++) {
            double J[6];
            for (int j = 0; j < 6; j++)
                J[j] = g->dq_dp[6 * i + 3 * k] * dp[0][j] + g->dq_dp[6 * i + 3 * k + 1] * dp[1][j] +
                       g->dq_dp[6 * i + 3 * k + 2] * dp[2][j];
            const double e = g->q_px[2 * i + k] - g->q_to[2 * i + k];
            for (int u = 0; u < n; u++) {
                for (int v = 0; v <= u; v++)
                    A[u * n + v] += J[u] * J[v];
                b[u] += J[u] * e;
            }
        }
    }
    if (!sheen_cholesky(A, n))
        return false;
    sheen_cholesky_solve(b, A, n);
    sheen_Rt turn;
    sheen_Rt_from_rt(&turn, (const double[6]){b[0], b[1], b[2], 0, 0, 0});
    const double t[3] = {Rt->t[0] + b[3], Rt->t[1] + b[4], Rt->t[2] + b[5]};
    memset(Rt->t, 0, sizeof Rt->t);
    sheen_Rt_compose(Rt, &turn, Rt);
    memcpy(Rt->t, t, sizeof t);
    return true;
}

static sheen_status aligned(double *rms_px, double *max_px, grid *g, int n, sheen_err *err)
{
    sheen_Rt Rt = {.R = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    sheen_status s = project(g, &Rt, err);
    for (int round = 0; round < ROUNDS && !s && step(&Rt, g, n); round++)
        s = project(g, &Rt, err);
    if (!s)
        measure(rms_px, max_px, g);
    return s;
}

sheen_status sheen_camera_compare(sheen_camera_difference *out, const sheen_camera *a, const sheen_camera *b,
                                  double distance_m, sheen_err *err)
{
    return sheen_camera_compare_ring(out, a, b, distance_m, 0, INFINITY, err);
}

sheen_status sheen_camera_compare_ring(sheen_camera_difference *out, const sheen_camera *a,
                                       const sheen_camera *b, double distance_m, double inner_px,
                                       double outer_px, sheen_err *err)
{
    if (a->width_px != b->width_px || a->height_px != b->height_px)
        return sheen_fail(err, SHEEN_EARG, "cameras of %d x %d and %d x %d px cannot be compared",
                          a->width_px, a->height_px, b->width_px, b->height_px);
    if (!(distance_m > 0) || !isfinite(distance_m))
        return sheen_fail(err, SHEEN_EARG, "cameras cannot be compared at a distance of %g m", distance_m);
    grid g = {.to = b,
              .centre_px = {(a->width_px - 1) / 2.0, (a->height_px - 1) / 2.0},
              .inner_px = inner_px,
              .outer_px = outer_px};
    for (size_t i = 0; i < N; i++) {
        g.q_px[2 * i] = (double)(i % GRID_COLS) / (GRID_COLS - 1) * (a->width_px - 1);
        const size_t row = i / GRID_COLS;
        g.q_px[2 * i + 1] = (double)row / (GRID_ROWS - 1) * (a->height_px - 1);
    }
    sheen_status s = sheen_camera_unproject(a, g.p_cam, g.q_px, N, err);
    for (size_t i = 0; i < (size_t)3 * N && !s; i++) {
        if (!isfinite(g.p_cam[i]))
            s = sheen_fail(err, SHEEN_EDATA, "the lens has no inverse over the whole image");
        g.p_cam[i] *= distance_m;
    }
    const sheen_Rt same = {.R = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    if (!s)
        s = project(&g, &same, err);
    if (s)
        return s;
    measure(&out->raw_rms_px, &out->raw_max_px, &g);
    s = aligned(&out->turned_rms_px, &out->turned_max_px, &g, 3, err);
    if (!s)
        s = aligned(&out->moved_rms_px, &out->moved_max_px, &g, 6, err);
    return s;
}

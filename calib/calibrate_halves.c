// SPDX-License-Identifier: Apache-2.0
// calibrate_halves.c - what one half of the frames says about the other: are two cameras from the halves as alike
// as their uncertainties promise, and which lens model predicts frames that it has not seen.
//
// First question. With lens parameters b, covariance C of each half, and a point p through a pixel, the halves'
// projections differ by G (b1 - b0), G = dq/db. A calibration cannot tell a moved or turned camera from moved
// boards, so the rigid motion that explains most is taken out of both sides: M = (I - J (J'J)^-1 J') G with J the
// derivatives by that motion. The normalised error is the root of the mean over the grid's points of
// |r|^2 / trace(M (C0 + C1) M'): 1 in the mean where noise and model are as assumed.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "calib/calibrate_job.h"
#include "calib/calibrate_outliers.h"
#include "calib/calibrate_seed.h"
#include "calib/cholesky.h"

enum { GRID_COLS = 18, GRID_ROWS = 14, MAX_POINTS = GRID_COLS * GRID_ROWS };

static const double HELD_OUT_LIMIT = 10; // sigmas; what no lens model explains says nothing about lens models

// The grid's points in cells of the image that hold corners, at the board's distance; with derivatives.
typedef struct grid {
    size_t n, n_lens;
    double p_cam[3 * MAX_POINTS], difference_px[2 * MAX_POINTS];
    double J[MAX_POINTS * 2][6]; // by rotation and translation
    double *G;                   // [2n][n_lens]
} grid;

static bool seen(const sheen_calibration *c, const double q_px[2])
{
    const int col = (int)((q_px[0] + 0.5) / c->camera.width_px * SHEEN_COVERAGE_COLS);
    const int row = (int)((q_px[1] + 0.5) / c->camera.height_px * SHEEN_COVERAGE_ROWS);
    return col >= 0 && row >= 0 && col < SHEEN_COVERAGE_COLS && row < SHEEN_COVERAGE_ROWS &&
           c->cells[row][col] > 0;
}

static void motion_gradient(double J[2][6], const double dq_dp[6], const double p[3])
{
    // d(exp(w) p + t)/d(w, t) = [-[p]x  I]
    const double dp[3][6] = {{0, p[2], -p[1], 1, 0, 0}, {-p[2], 0, p[0], 0, 1, 0}, {p[1], -p[0], 0, 0, 0, 1}};
    for (int k = 0; k < 2; k++)
        for (int j = 0; j < 6; j++)
            J[k][j] = dq_dp[3 * k] * dp[0][j] + dq_dp[3 * k + 1] * dp[1][j] + dq_dp[3 * k + 2] * dp[2][j];
}

static sheen_status grid_fill(grid *g, const sheen_calibration *c, const sheen_camera half[2], sheen_err *err)
{
    double q_px[2 * MAX_POINTS], q_other[2 * MAX_POINTS], dq_dp[6 * MAX_POINTS];
    g->n = 0;
    g->n_lens = (size_t)half[0].n_intrinsics;
    for (int i = 0; i < MAX_POINTS; i++) {
        const int col = i % GRID_COLS, row = i / GRID_COLS;
        double *q = q_px + 2 * g->n;
        q[0] = (col + 0.5) / GRID_COLS * half[0].width_px - 0.5;
        q[1] = (row + 0.5) / GRID_ROWS * half[0].height_px - 0.5;
        g->n += seen(c, q);
    }
    g->G = calloc(2 * g->n * g->n_lens + 1, sizeof *g->G);
    if (!g->G)
        return sheen_fail_memory(err, 2 * (double)(g->n * g->n_lens) * sizeof *g->G, "a cross-validation");
    sheen_status s = sheen_camera_unproject(&half[0], g->p_cam, q_px, g->n, err);
    for (size_t i = 0; i < 3 * g->n; i++)
        g->p_cam[i] *= c->distance_m;
    if (!s)
        s = sheen_camera_project(&half[1], q_other, dq_dp, g->p_cam, g->n, err);
    for (size_t i = 0; i < g->n && !s; i++) {
        motion_gradient(&g->J[2 * i], dq_dp + 6 * i, g->p_cam + 3 * i);
        s = sheen_lens_gradient(g->G + 2 * i * g->n_lens, &half[0], g->p_cam + 3 * i, err);
    }
    for (size_t i = 0; i < 2 * g->n && !s; i++) {
        g->difference_px[i] = q_other[i] - q_px[i];
        if (!isfinite(g->difference_px[i]))
            s = sheen_fail(err, SHEEN_EDATA, "one half's camera looks where the other's cannot");
    }
    return s;
}

// Takes out of n columns of `rows` (2n rows, one every `stride` numbers) what the six columns of J explain.
static bool project_out(const grid *g, double *values, size_t n_columns)
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

// trace of the 2 x 2 covariance of point i: M C M' for its two rows of M.
static double variance_at(const double *M, const double *C, size_t n)
{
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

static double noise_of(const sheen_problem *p)
{
    double sum = 0, n = 0;
    for (size_t i = 0; i < sheen_problem_corners(p); i++)
        if (p->observations[3 * i + 2] > 0) {
            sum += p->residuals_px[2 * i] * p->residuals_px[2 * i] +
                   p->residuals_px[2 * i + 1] * p->residuals_px[2 * i + 1];
            n += 2;
        }
    const double free_n = n - (p->camera.n_intrinsics + 6.0 * p->n_frames + 2);
    return sqrt(sum / fmax(0.1 * n, free_n));
}

static sheen_status normalise(double *error, const sheen_calibration *c, const sheen_problem p[2],
                              sheen_err *err)
{
    const size_t n = (size_t)p[0].camera.n_intrinsics;
    const sheen_camera half[2] = {p[0].camera, p[1].camera};
    double *C[2] = {calloc(n * n, sizeof(double)), calloc(n * n, sizeof(double))};
    grid *g = calloc(1, sizeof *g);
    sheen_status s = SHEEN_OK;
    *error = (double)NAN;
    if (strcmp(half[0].lensmodel, half[1].lensmodel) != 0)
        goto done; // two splines of different fields share no parameters
    if (!C[0] || !C[1] || !g) {
        s = sheen_fail_memory(err, 2 * (double)(n * n) * sizeof(double), "a cross-validation");
        goto done;
    }
    for (int k = 0; k < 2 && !s; k++)
        s = sheen_problem_lens_covariance(C[k], &p[k], noise_of(&p[k]), err);
    if (!s)
        s = grid_fill(g, c, half, err);
    if (s || g->n < 12 || !project_out(g, g->G, n) || !project_out(g, g->difference_px, 1))
        goto done;
    for (size_t i = 0; i < n * n; i++)
        C[0][i] += C[1][i];
    double sum = 0;
    for (size_t i = 0; i < g->n; i++) {
        const double *r = g->difference_px + 2 * i;
        sum += (r[0] * r[0] + r[1] * r[1]) / variance_at(g->G + 2 * i * n, C[0], n);
    }
    *error = sqrt(sum / (double)g->n);

done:
    if (g)
        free(g->G);
    free(g);
    free(C[0]);
    free(C[1]);
    return s == SHEEN_ENOMEM ? s : SHEEN_OK; // anything else says: not to be had
}

sheen_status sheen_job_cross_validate(sheen_calibration *c, const sheen_calibrate_job *j, sheen_err *err)
{
    const double none = (double)NAN;
    sheen_problem p[2] = {0};
    c->has_halves = false;
    c->normalised_error = none;
    if (j->n_used < 2 * SHEEN_CALIBRATE_MIN_FRAMES)
        return SHEEN_OK;
    sheen_status s = SHEEN_OK;
    for (int k = 0; k < 2 && !s; k++)
        s = sheen_job_solve(&p[k], j, k, 2, err);
    if (!s) {
        c->has_halves = true;
        if (sheen_camera_compare(&c->halves, &p[0].camera, &p[1].camera, c->distance_m, NULL))
            c->halves = (sheen_camera_difference){none, none, none, none, none, none};
        s = normalise(&c->normalised_error, c, p, err);
    }
    sheen_problem_release(&p[0]);
    sheen_problem_release(&p[1]);
    return s == SHEEN_EDATA ? SHEEN_OK
                            : s; // half of the frames can be too few, which is no fault of the whole
}

// Squared error of each used view, predicted by the camera of the other half; n_out: its inliers.
static sheen_status predict_half(double *sum, int *n_out, const sheen_calibrate_job *j, int k, sheen_err *err)
{
    sheen_problem made = {0}, other = {0};
    int n_rejected;
    sheen_status s = sheen_job_solve(&made, j, k, 2, err);
    if (!s)
        s = sheen_job_problem(&other, j, 1 - k, 2, err);
    if (!s)
        s = sheen_problem_seed(&other, j->board, j->chosen, err);
    if (!s) {
        other.camera = made.camera;
        memcpy(other.warp_m, made.warp_m, sizeof made.warp_m);
        s = sheen_problem_solve(&other, SHEEN_PROBLEM_POSES, err);
    }
    if (!s)
        s = sheen_problem_reject(&n_rejected, &other, HELD_OUT_LIMIT, err);
    if (!s)
        s = sheen_problem_solve(&other, SHEEN_PROBLEM_POSES, err);
    const size_t n = (size_t)other.n_cols * (size_t)other.n_rows;
    for (int i = 0; i < other.n_frames && !s; i++) {
        const int at = 2 * i + 1 - k;
        for (size_t q = n * (size_t)i; q < n * (size_t)(i + 1); q++)
            if (other.observations[3 * q + 2] > 0) {
                sum[at] += other.residuals_px[2 * q] * other.residuals_px[2 * q] +
                           other.residuals_px[2 * q + 1] * other.residuals_px[2 * q + 1];
                n_out[at]++;
            }
    }
    sheen_problem_release(&made);
    sheen_problem_release(&other);
    return s;
}

// Mean squared error of each view, held out; the rms of all. NaN where the model could not be solved.
static sheen_status predict(double *mean, double *rms_px, sheen_calibrate_job *j, int *n, sheen_err *err)
{
    memset(mean, 0, (size_t)j->n_used * sizeof *mean);
    memset(n, 0, (size_t)j->n_used * sizeof *n);
    sheen_status s = predict_half(mean, n, j, 0, err);
    if (!s)
        s = predict_half(mean, n, j, 1, err);
    double sum = 0, count = 0;
    for (int i = 0; i < j->n_used; i++) {
        sum += mean[i];
        count += 2 * n[i];
        mean[i] /= 2 * fmax(1, n[i]);
    }
    *rms_px = s || !(count > 0) ? (double)NAN : sqrt(sum / count);
    return s == SHEEN_EDATA ? SHEEN_OK : s;
}

// True where b's errors are below a's by more than the mean difference over the views is uncertain.
static bool clearly_better(const double *b, const double *a, int n)
{
    double mean = 0, square = 0;
    for (int i = 0; i < n; i++) {
        mean += (a[i] - b[i]) / n;
        square += (a[i] - b[i]) * (a[i] - b[i]) / n;
    }
    return mean > sqrt(fmax(0, square - mean * mean) / n);
}

// A spline has hundreds of parameters: each half of the corners must be several times as many.
static bool enough_for(const sheen_lens_model *lens, const sheen_calibrate_job *j)
{
    size_t n = 0;
    for (int i = 0; i < j->n_used; i++)
        n += j->views[j->used[i]].n_saddles;
    return !lens->splined || n >= 1600;
}

sheen_status sheen_job_choose_lens(sheen_calibration *c, sheen_calibrate_job *j,
                                   const sheen_progress *progress, sheen_err *err)
{
    const sheen_lens_model *chosen = &sheen_lens_models[0];
    const size_t n = (size_t)j->n_used;
    c->n_candidates = 0;
    j->lens = chosen;
    if (j->n_used < 2 * SHEEN_CALIBRATE_MIN_FRAMES)
        return SHEEN_OK;
    double *best = calloc(n, sizeof *best), *mean = calloc(n, sizeof *mean);
    int *count = calloc(n, sizeof *count);
    bool have = false;
    sheen_status s = best && mean && count ? SHEEN_OK
                                           : sheen_fail_memory(err, 3 * (double)n, "a choice of lens");
    for (int i = 0; i < SHEEN_LENS_MODELS && !s; i++) {
        double rms_px;
        j->lens = &sheen_lens_models[i];
        if (!enough_for(j->lens, j))
            continue;
        s = sheen_progress_step(progress, "lens models", i, SHEEN_LENS_MODELS, err);
        if (!s)
            s = predict(mean, &rms_px, j, count, err);
        if (s)
            break;
        c->candidates[c->n_candidates++] = (sheen_calibration_candidate){j->lens->name, rms_px};
        if (!isfinite(rms_px) || (have && !clearly_better(mean, best, j->n_used)))
            continue;
        memcpy(best, mean, n * sizeof *best);
        chosen = j->lens;
        have = true;
    }
    j->lens = chosen;
    free(best);
    free(mean);
    free(count);
    return s;
}

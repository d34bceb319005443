// SPDX-License-Identifier: Apache-2.0
// calibrate_halves.c - what one half of the frames says about the other: are two cameras from the halves as alike
// as their uncertainties promise, and which lens model predicts frames that it has not seen.
//
// First question. With lens parameters b, covariance C of each half, the halves' projections differ by G (b1 - b0),
// G = dq/db; the rigid motion that explains most is taken out of the difference and of G (lens_grid.h). The
// normalised error is the root of the mean over the grid's points of |r|^2 / trace(M (C0 + C1) M'): 1 in the mean
// where noise and model are as assumed.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "calib/calibrate_job.h"
#include "calib/calibrate_outliers.h"
#include "calib/calibrate_seed.h"
#include "calib/lens_grid.h"

static const double HELD_OUT_LIMIT = 10; // sigmas; what no lens model explains says nothing about lens models

static bool seen(const void *self, const double q_px[2])
{
    const sheen_calibration *c = self;
    const int col = (int)((q_px[0] + 0.5) / c->camera.width_px * SHEEN_COVERAGE_COLS);
    const int row = (int)((q_px[1] + 0.5) / c->camera.height_px * SHEEN_COVERAGE_ROWS);
    return col >= 0 && row >= 0 && col < SHEEN_COVERAGE_COLS && row < SHEEN_COVERAGE_ROWS &&
           c->cells[row][col] > 0;
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
    double *r = calloc(2 * SHEEN_LENS_GRID_MAX, sizeof *r);
    sheen_lens_grid *g = calloc(1, sizeof *g);
    sheen_status s = SHEEN_OK;
    *error = (double)NAN;
    if (strcmp(half[0].lensmodel, half[1].lensmodel) != 0)
        goto done; // two splines of different fields share no parameters
    if (!C[0] || !C[1] || !g || !r) {
        s = sheen_fail_memory(err, 2 * (double)(n * n) * sizeof(double), "a cross-validation");
        goto done;
    }
    for (int k = 0; k < 2 && !s; k++)
        s = sheen_problem_uncertainty(&(sheen_uncertainty){.lens_covariance = C[k]}, &p[k], noise_of(&p[k]),
                                      err);
    if (!s)
        s = sheen_lens_grid_init(g, &half[0], c->distance_m, seen, c, err);
    if (!s)
        s = sheen_camera_project(&half[1], r, NULL, g->p_cam, g->n, err);
    for (size_t i = 0; i < 2 * g->n; i++)
        r[i] -= g->q_px[i];
    if (s || !sheen_lens_grid_project_out(g, r, 1))
        goto done;
    for (size_t i = 0; i < n * n; i++)
        C[0][i] += C[1][i];
    double sum = 0;
    for (size_t i = 0; i < g->n; i++)
        sum += (r[2 * i] * r[2 * i] + r[2 * i + 1] * r[2 * i + 1]) / sheen_lens_grid_variance(g, i, C[0]);
    *error = sqrt(sum / (double)g->n);

done:
    if (g)
        sheen_lens_grid_release(g);
    free(g);
    free(r);
    free(C[0]);
    free(C[1]);
    return s == SHEEN_ENOMEM ? s : SHEEN_OK; // anything else says: not to be had
}

sheen_status sheen_job_cross_validate(sheen_calibration *c, const sheen_calibrate_job *j,
                                      const sheen_problem *whole, sheen_err *err)
{
    const double none = (double)NAN;
    sheen_problem p[2] = {0};
    c->has_halves = false;
    c->normalised_error = none;
    if (j->n_used < 2 * SHEEN_CALIBRATE_MIN_FRAMES)
        return SHEEN_OK;
    sheen_status s = SHEEN_OK;
    for (int k = 0; k < 2 && !s; k++)
        s = sheen_job_solve_from(&p[k], j, k, 2, whole, err);
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
    double longest;
    sheen_status s = sheen_job_solve(&made, j, k, 2, err);
    if (!s)
        s = sheen_job_problem(&other, j, 1 - k, 2, err);
    if (!s) {
        other.camera = made.camera;
        memcpy(other.warp_m, made.warp_m, sizeof made.warp_m);
        s = sheen_problem_seed_poses(&other, j->board, j->chosen, err);
    }
    if (!s)
        s = sheen_problem_solve(&other, SHEEN_PROBLEM_POSES, err);
    if (!s)
        s = sheen_problem_reject(&n_rejected, &longest, &other, HELD_OUT_LIMIT, err);
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

// SPDX-License-Identifier: Apache-2.0
// calibrate_job.c - solves a calibration in stages: poses, then focal length and centre, then everything, then
// again without what does not fit. The stages take many steps, so that where frames are many the lens is found from a
// few of them first; a half of the frames starts from the solution of all.
#include "calib/calibrate_job.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "calib/calibrate_outliers.h"
#include "calib/calibrate_seed.h"

enum { FEW_FRAMES = 12 };

void sheen_problem_release(sheen_problem *p)
{
    free(p->rt_cam_grid);
    free(p->observations);
    free(p->residuals_px);
    *p = (sheen_problem){0};
}

sheen_status sheen_job_problem(sheen_problem *p, const sheen_calibrate_job *j, int first, int step,
                               sheen_err *err)
{
    int n_frames = 0;
    for (int i = first; i < j->n_used; i += step)
        j->chosen[n_frames++] = &j->views[j->used[i]];
    *p = (sheen_problem){.n_frames = n_frames,
                         .n_cols = j->board->n_cols - 1,
                         .n_rows = j->board->n_rows - 1,
                         .spacing_m = j->board->square_m};
    p->camera.width_px = j->width_px;
    p->camera.height_px = j->height_px;
    p->camera.n_intrinsics = j->lens->n_begun;
    snprintf(p->camera.lensmodel, sizeof p->camera.lensmodel, "%s", j->lens->begun_as);
    const size_t n = sheen_problem_corners(p);
    p->rt_cam_grid = calloc(6 * (size_t)n_frames + 1, sizeof *p->rt_cam_grid);
    p->observations = malloc((3 * n + 1) * sizeof *p->observations);
    p->residuals_px = calloc(2 * n + 1, sizeof *p->residuals_px);
    if (!p->rt_cam_grid || !p->observations || !p->residuals_px)
        return sheen_fail_memory(err, 5 * (double)n * sizeof(double), "a calibration");
    for (size_t i = 0; i < 3 * n; i++)
        p->observations[i] = -1;
    for (int i = 0; i < n_frames; i++)
        for (size_t k = 0; k < j->chosen[i]->n_saddles; k++) {
            const sheen_saddle *c = &j->chosen[i]->saddles[k];
            const size_t at = ((size_t)i * (size_t)p->n_rows + (size_t)(c->row - 1)) * (size_t)p->n_cols +
                              (size_t)(c->col - 1);
            memcpy(p->observations + 3 * at, c->q_px, sizeof c->q_px);
            p->observations[3 * at + 2] = 1;
        }
    return SHEEN_OK;
}

// Leaves out what does not fit, the worst first, since one bad corner bends its whole frame.
static sheen_status reject_outliers(sheen_problem *p, sheen_err *err)
{
    static const double limits[] = {20, 10, 7, 5, 5, 5};
    sheen_status s = SHEEN_OK;
    double longest = INFINITY; // residual, in sigmas
    for (size_t i = 0; i < sizeof limits / sizeof *limits && !s; i++) {
        int n_rejected;
        if (longest <= limits[i])
            continue;
        s = sheen_problem_reject(&n_rejected, &longest, p, limits[i], err);
        if (s || !n_rejected)
            continue;
        s = sheen_problem_solve(p, SHEEN_PROBLEM_EVERYTHING, err);
        longest = INFINITY;
    }
    return s;
}

static sheen_status in_stages(sheen_problem *p, const sheen_calibrate_job *j, int first, int step,
                              sheen_err *err)
{
    sheen_status s = sheen_job_problem(p, j, first, step, err);
    if (!s)
        s = sheen_problem_seed(p, j->board, j->chosen, err);
    if (!s)
        s = sheen_problem_solve(p, SHEEN_PROBLEM_POSES, err);
    if (!s)
        s = sheen_problem_solve(p, SHEEN_PROBLEM_CORE, err);
    if (!s && j->lens->splined)
        sheen_lens_spline(&p->camera);
    if (!s)
        s = sheen_problem_solve(p, SHEEN_PROBLEM_EVERYTHING, err);
    return s;
}

// The lens of a few frames, and all frames' poses through it. EDATA where these few do not get that far.
static sheen_status from_few(sheen_problem *p, const sheen_calibrate_job *j, int first, int step,
                             sheen_err *err)
{
    const int n_frames = (j->n_used - first + step - 1) / step;
    sheen_problem few = {0};
    sheen_status s = in_stages(&few, j, first, step * ((n_frames + FEW_FRAMES - 1) / FEW_FRAMES), err);
    if (!s)
        s = sheen_job_problem(p, j, first, step, err);
    if (!s) {
        p->camera = few.camera;
        memcpy(p->warp_m, few.warp_m, sizeof p->warp_m);
        s = sheen_problem_seed_poses(p, j->board, j->chosen, err);
    }
    if (!s)
        s = sheen_problem_solve(p, SHEEN_PROBLEM_EVERYTHING, err);
    sheen_problem_release(&few);
    return s;
}

// Rids a solved problem of outliers; EDATA where what is left makes no sense.
static sheen_status finish(sheen_problem *p, const sheen_calibrate_job *j, sheen_err *err)
{
    sheen_status s = reject_outliers(p, err);
    for (int i = 0; i < p->n_frames && !s; i++)
        if (!(p->rt_cam_grid[6 * i + 5] > 0))
            s = sheen_fail(err, SHEEN_EDATA, "the calibration put the board of frame '%s' behind the camera",
                           j->chosen[i]->name);
    if (!s && (s = sheen_camera_check(&p->camera, err)))
        s = sheen_wrap(err, s, "the calibration found no lens");
    return s;
}

sheen_status sheen_job_solve(sheen_problem *p, const sheen_calibrate_job *j, int first, int step,
                             sheen_err *err)
{
    sheen_status s = SHEEN_EDATA;
    if (j->n_used > 2 * step * FEW_FRAMES) {
        s = from_few(p, j, first, step, err);
        if (s == SHEEN_EDATA) // an unlucky choice
            sheen_problem_release(p);
    }
    if (s == SHEEN_EDATA)
        s = in_stages(p, j, first, step, err);
    return s ? s : finish(p, j, err);
}

sheen_status sheen_job_solve_from(sheen_problem *p, const sheen_calibrate_job *j, int first, int step,
                                  const sheen_problem *whole, sheen_err *err)
{
    sheen_status s = sheen_job_problem(p, j, first, step, err);
    if (s)
        return s;
    const size_t n = (size_t)p->n_cols * (size_t)p->n_rows;
    p->camera = whole->camera;
    memcpy(p->warp_m, whole->warp_m, sizeof p->warp_m);
    for (int i = 0; i < p->n_frames; i++) {
        const size_t from = (size_t)first + (size_t)i * (size_t)step;
        memcpy(p->rt_cam_grid + 6 * (size_t)i, whole->rt_cam_grid + 6 * from, 6 * sizeof *p->rt_cam_grid);
        memcpy(p->observations + 3 * n * (size_t)i, whole->observations + 3 * n * from,
               3 * n * sizeof *p->observations);
    }
    s = sheen_problem_solve(p, SHEEN_PROBLEM_EVERYTHING, err);
    return s ? s : finish(p, j, err);
}

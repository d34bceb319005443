// SPDX-License-Identifier: Apache-2.0
// calibrate.c - a camera's lens from views of the board: chooses the frames, solves, drops frames that do not fit
// and solves again, and says how certain the result is.
#include "calib/calibrate.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "calib/calibrate_job.h"
#include "calib/calibrate_summary.h"

enum { MAX_FRAMES = 2000, MAX_SQUARES = 200, STEPS = 4 };

static const double BAD_FRAME_OUTLIERS = 0.5; // share of corners
static const double BAD_FRAME_RMS = 5;        // times the rms of all

void sheen_calibration_release(sheen_calibration *c)
{
    free(c->frames);
    free(c->corners);
    free(c->lens_covariance);
    *c = (sheen_calibration){0};
}

static sheen_status check_views(const sheen_board *board, const sheen_board_view *views, size_t n_views,
                                sheen_err *err)
{
    if (n_views > MAX_FRAMES)
        return sheen_fail(err, SHEEN_EDATA, "%zu frames are more than the %d that can be calibrated from",
                          n_views, (int)MAX_FRAMES);
    if (board->n_rows < 4 || board->n_cols < 4 || board->n_rows > MAX_SQUARES || board->n_cols > MAX_SQUARES)
        return sheen_fail(err, SHEEN_EDATA, "a board of %d x %d squares cannot be calibrated from",
                          board->n_cols, board->n_rows);
    for (size_t i = 0; i < n_views; i++) {
        if (views[i].width_px != views[0].width_px || views[i].height_px != views[0].height_px)
            return sheen_fail(
                err, SHEEN_EDATA,
                "frame '%s' is %d x %d px but '%s' is %d x %d: calibrate from frames of one size",
                views[i].name, views[i].width_px, views[i].height_px, views[0].name, views[0].width_px,
                views[0].height_px);
        for (size_t k = 0; k < views[i].n_saddles; k++) {
            const sheen_saddle *c = &views[i].saddles[k];
            if (!isfinite(c->q_px[0]) || !isfinite(c->q_px[1]))
                return sheen_fail(err, SHEEN_EDATA, "a corner in frame '%s' is not a finite number",
                                  views[i].name);
            if (c->row < 1 || c->row >= board->n_rows || c->col < 1 || c->col >= board->n_cols)
                return sheen_fail(err, SHEEN_EARG, "frame '%s' has a corner that is not on the board",
                                  views[i].name);
        }
    }
    return SHEEN_OK;
}

// Notes in `frame` why a view is of no use, or that it is.
static void sort_out(sheen_calibration_frame *frame, const sheen_board_view *view)
{
    bool rows[MAX_SQUARES] = {false}, cols[MAX_SQUARES] = {false};
    int n_rows = 0, n_cols = 0;
    for (size_t k = 0; k < view->n_saddles; k++) {
        n_rows += !rows[view->saddles[k].row];
        n_cols += !cols[view->saddles[k].col];
        rows[view->saddles[k].row] = cols[view->saddles[k].col] = true;
    }
    *frame = (sheen_calibration_frame){.n_corners = (int)view->n_saddles, .rms_px = NAN};
    snprintf(frame->name, sizeof frame->name, "%s", view->name);
    if (!view->n_tags && !view->n_saddles)
        snprintf(frame->reason, sizeof frame->reason, "no tag of the board in view");
    else if (frame->n_corners < SHEEN_CALIBRATE_MIN_CORNERS)
        snprintf(frame->reason, sizeof frame->reason, "only %d corners in view, at least %d are needed",
                 frame->n_corners, SHEEN_CALIBRATE_MIN_CORNERS);
    else if (n_rows < 3 || n_cols < 3)
        snprintf(frame->reason, sizeof frame->reason, "its corners lie in a strip");
    else
        frame->used = true;
}

static sheen_status enough(const sheen_calibration *c, int n_used, sheen_err *err)
{
    if (n_used >= SHEEN_CALIBRATE_MIN_FRAMES)
        return SHEEN_OK;
    for (size_t i = 0; i < c->n_frames; i++)
        if (!c->frames[i].used)
            return sheen_fail(
                err, SHEEN_EDATA,
                "%d of %zu frames can be used, at least %d are needed ('%s': %s): take frames that show "
                "the board large, sharp and tilted",
                n_used, c->n_frames, (int)SHEEN_CALIBRATE_MIN_FRAMES, c->frames[i].name, c->frames[i].reason);
    return sheen_fail(err, SHEEN_EDATA,
                      "%d frames are too few to calibrate from: take at least %d, better 15", n_used,
                      (int)SHEEN_CALIBRATE_MIN_FRAMES);
}

// Takes frames out that do not fit; returns how many.
static int drop_bad(sheen_calibration *c, sheen_calibrate_job *j)
{
    int kept = 0, dropped = 0;
    for (int i = 0; i < j->n_used; i++) {
        sheen_calibration_frame *frame = &c->frames[j->used[i]];
        const bool bad = frame->n_outliers > BAD_FRAME_OUTLIERS * frame->n_corners ||
                         !(frame->rms_px <= BAD_FRAME_RMS * fmax(c->rms_px, 0.02));
        if (!bad) {
            j->used[kept++] = j->used[i];
            continue;
        }
        dropped++;
        snprintf(frame->reason, sizeof frame->reason,
                 "does not fit the others (%d of %d corners are outliers, rms %.2f px)", frame->n_outliers,
                 frame->n_corners, frame->rms_px);
        frame->used = false;
        frame->n_outliers = 0;
        frame->rms_px = NAN;
    }
    j->n_used = kept;
    return dropped;
}

// The middles of cells over the image.
static void cell_middles(double *q_px, int n_cols, int n_rows, const sheen_camera *camera)
{
    for (int row = 0; row < n_rows; row++)
        for (int col = 0; col < n_cols; col++) {
            double *q = q_px + 2 * ((size_t)row * (size_t)n_cols + (size_t)col);
            q[0] = (col + 0.5) / n_cols * camera->width_px - 0.5;
            q[1] = (row + 0.5) / n_rows * camera->height_px - 0.5;
        }
}

// The uncertainty of the lens and over the image; NaN where it could not be had.
static sheen_status find_uncertainty(sheen_calibration *c, const sheen_problem *p, sheen_err *err)
{
    enum {
        COVERAGE = SHEEN_COVERAGE_ROWS * SHEEN_COVERAGE_COLS,
        MAP = SHEEN_SIGMA_ROWS * SHEEN_SIGMA_COLS,
        ALL = COVERAGE + MAP + 1
    };
    const size_t n_lens = (size_t)p->camera.n_intrinsics;
    double q_px[2 * ALL], sigma_px[ALL];
    c->lens_covariance = calloc(n_lens * n_lens, sizeof *c->lens_covariance);
    if (!c->lens_covariance)
        return sheen_fail_memory(err, (double)(n_lens * n_lens) * sizeof(double),
                                 "the uncertainty of a lens");
    cell_middles(q_px, SHEEN_COVERAGE_COLS, SHEEN_COVERAGE_ROWS, &p->camera);
    cell_middles(q_px + (size_t)2 * COVERAGE, SHEEN_SIGMA_COLS, SHEEN_SIGMA_ROWS, &p->camera);
    double *centre_px = q_px + (size_t)2 * (COVERAGE + MAP);
    centre_px[0] = (p->camera.width_px - 1) / 2.0;
    centre_px[1] = (p->camera.height_px - 1) / 2.0;
    const sheen_uncertainty out = {.sigma_px = sigma_px,
                                   .q_px = q_px,
                                   .n = ALL,
                                   .distance_m = c->distance_m,
                                   .lens_covariance = c->lens_covariance};
    const sheen_status s = sheen_problem_uncertainty(&out, p, c->noise_px, err);
    for (size_t i = 0; i < n_lens * n_lens && s; i++)
        c->lens_covariance[i] = (double)NAN;
    for (int i = 0; i < ALL && s; i++)
        sigma_px[i] = (double)NAN;
    c->sigma_centre_px = sigma_px[COVERAGE + MAP];
    memcpy(c->sigma_px, sigma_px + COVERAGE, sizeof c->sigma_px);
    c->sigma_worst_px = 0;
    for (int i = 0; i < COVERAGE && isfinite(c->sigma_worst_px); i++)
        c->sigma_worst_px = sigma_px[i] <= c->sigma_worst_px ? c->sigma_worst_px : sigma_px[i];
    return s == SHEEN_EDATA ? SHEEN_OK : s;
}

static sheen_status find_vignetting(sheen_calibration *c, const sheen_calibrate_job *j, sheen_err *err)
{
    for (int i = 0; i < j->n_used; i++)
        j->chosen[i] = &j->views[j->used[i]];
    return sheen_vignetting_measure(&c->vignetting, &c->camera, j->chosen, (size_t)j->n_used, err);
}

static sheen_status run(sheen_calibration *c, sheen_calibrate_job *j, const sheen_progress *progress,
                        sheen_err *err)
{
    sheen_problem p = {0};
    sheen_status s = enough(c, j->n_used, err);
    if (!s && !j->lens)
        s = sheen_job_choose_lens(c, j, progress, err);
    for (int round = 0; round < 3 && !s; round++) {
        s = sheen_progress_step(progress, "calibration", round, STEPS, err);
        sheen_problem_release(&p);
        p = (sheen_problem){0};
        if (!s)
            s = sheen_job_solve(&p, j, 0, 1, err);
        if (s)
            break;
        s = sheen_calibration_summarise(c, &p, j, err);
        if (s || round == 2 || !drop_bad(c, j))
            break;
        s = enough(c, j->n_used, err);
    }
    if (!s)
        s = find_uncertainty(c, &p, err);
    if (!s) {
        sheen_calibration_bound(c);
        s = sheen_job_cross_validate(c, j, &p, err);
    }
    if (!s)
        s = find_vignetting(c, j, err);
    if (!s) {
        sheen_calibration_judge(c);
        s = sheen_progress_step(progress, "calibration", STEPS, STEPS, err);
    }
    sheen_problem_release(&p);
    return s;
}

sheen_status sheen_calibrate(sheen_calibration *out, const sheen_board *board, const sheen_board_view *views,
                             size_t n_views, const sheen_calibrate_options *options, sheen_err *err)
{
    *out = (sheen_calibration){0};
    sheen_calibrate_job j = {.board = board, .views = views};
    if (!n_views)
        return sheen_fail(err, SHEEN_EDATA, "there are no frames to calibrate from");
    const bool automatic = options->lensmodel && !strcmp(options->lensmodel, "auto");
    sheen_status s = automatic ? SHEEN_OK : sheen_lens_model_find(&j.lens, options->lensmodel, err);
    if (!s)
        s = check_views(board, views, n_views, err);
    if (s)
        return s;
    j.width_px = views[0].width_px;
    j.height_px = views[0].height_px;
    out->n_frames = n_views;
    out->frames = calloc(n_views, sizeof *out->frames);
    j.used = calloc(n_views, sizeof *j.used);
    j.chosen = calloc(n_views, sizeof *j.chosen);
    if (!out->frames || !j.used || !j.chosen) {
        s = sheen_fail_memory(err, (double)n_views * sizeof *out->frames, "a calibration");
        goto done;
    }
    for (size_t i = 0; i < n_views; i++) {
        sort_out(&out->frames[i], &views[i]);
        if (out->frames[i].used)
            j.used[j.n_used++] = (int)i;
    }
    s = run(out, &j, &options->progress, err);

done:
    free(j.chosen);
    free(j.used);
    if (s)
        sheen_calibration_release(out);
    return s;
}

// SPDX-License-Identifier: Apache-2.0
// calibrate.c - a camera's lens from views of the board: chooses the frames, solves in three stages (poses, then
// focal length and centre, then everything), drops frames that do not fit and solves again, and checks the result
// on halves of the frames.
#include "calib/calibrate.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "calib/calibrate_outliers.h"
#include "calib/calibrate_problem.h"
#include "calib/calibrate_seed.h"
#include "calib/calibrate_summary.h"

enum { MAX_FRAMES = 2000, MAX_SQUARES = 200, STEPS = 4 };

static const double BAD_FRAME_OUTLIERS = 0.5; // share of corners
static const double BAD_FRAME_RMS = 5;        // times the rms of all

void sheen_calibration_release(sheen_calibration *c)
{
    free(c->frames);
    *c = (sheen_calibration){0};
}

static const char *const lens_models[] = {"LENSMODEL_OPENCV8", "LENSMODEL_OPENCV5", "LENSMODEL_OPENCV4"};
static const int lens_parameters[] = {12, 9, 8};

static sheen_status choose_lens(sheen_camera *camera, const char *name, sheen_err *err)
{
    if (!name)
        name = lens_models[0];
    for (size_t i = 0; i < sizeof lens_models / sizeof *lens_models; i++)
        if (!strcmp(name, lens_models[i])) {
            snprintf(camera->lensmodel, sizeof camera->lensmodel, "%s", name);
            camera->n_intrinsics = lens_parameters[i];
            return SHEEN_OK;
        }
    return sheen_fail(err, SHEEN_EARG,
                      "cannot calibrate the lens model '%.80s': use LENSMODEL_OPENCV4, LENSMODEL_OPENCV5 or "
                      "LENSMODEL_OPENCV8",
                      name);
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

static void problem_release(sheen_problem *p)
{
    free(p->rt_cam_grid);
    free(p->observations);
    free(p->residuals_px);
}

static sheen_status problem_init(sheen_problem *p, const sheen_camera *camera, const sheen_board *board,
                                 const sheen_board_view *const *views, int n_frames, sheen_err *err)
{
    *p = (sheen_problem){.camera = *camera,
                         .n_frames = n_frames,
                         .n_cols = board->n_cols - 1,
                         .n_rows = board->n_rows - 1,
                         .spacing_m = board->square_m};
    const size_t n = sheen_problem_corners(p);
    p->rt_cam_grid = calloc(6 * (size_t)n_frames + 1, sizeof *p->rt_cam_grid);
    p->observations = malloc((3 * n + 1) * sizeof *p->observations);
    p->residuals_px = calloc(2 * n + 1, sizeof *p->residuals_px);
    if (!p->rt_cam_grid || !p->observations || !p->residuals_px)
        return sheen_fail_memory(err, 5 * (double)n * sizeof(double), "a calibration");
    for (size_t i = 0; i < 3 * n; i++)
        p->observations[i] = -1;
    for (int i = 0; i < n_frames; i++)
        for (size_t k = 0; k < views[i]->n_saddles; k++) {
            const sheen_saddle *c = &views[i]->saddles[k];
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
    for (size_t i = 0; i < sizeof limits / sizeof *limits && !s; i++) {
        int n_rejected;
        s = sheen_problem_reject(&n_rejected, p, limits[i], err);
        if (!s && n_rejected)
            s = sheen_problem_solve(p, SHEEN_PROBLEM_EVERYTHING, err);
    }
    return s;
}

static sheen_status solve(sheen_problem *p, const sheen_board *board, const sheen_board_view *const *views,
                          sheen_err *err)
{
    sheen_status s = sheen_problem_seed(p, board, views, err);
    for (int stage = SHEEN_PROBLEM_POSES; stage <= SHEEN_PROBLEM_EVERYTHING && !s; stage++)
        s = sheen_problem_solve(p, (sheen_problem_stage)stage, err);
    if (!s)
        s = reject_outliers(p, err);
    for (int i = 0; i < p->n_frames && !s; i++)
        if (!(p->rt_cam_grid[6 * i + 5] > 0))
            s = sheen_fail(err, SHEEN_EDATA, "the calibration put the board of frame '%s' behind the camera",
                           views[i]->name);
    if (!s && (s = sheen_camera_check(&p->camera, err)))
        s = sheen_wrap(err, s, "the calibration found no lens");
    return s;
}

// A calibration in the making. used[n]: indices of the views that take part.
typedef struct job {
    const sheen_board *board;
    const sheen_board_view *views;
    sheen_camera camera; // size and lens model
    int *used;
    const sheen_board_view **chosen; // scratch, as long as used
    int n_used;
} job;

// Solves with each step-th of the used views from the first-th on; release *p after success and failure.
static sheen_status solve_some(sheen_problem *p, const job *j, int first, int step, sheen_err *err)
{
    int n = 0;
    for (int i = first; i < j->n_used; i += step)
        j->chosen[n++] = &j->views[j->used[i]];
    const sheen_status s = problem_init(p, &j->camera, j->board, j->chosen, n, err);
    return s ? s : solve(p, j->board, j->chosen, err);
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
static int drop_bad(sheen_calibration *c, job *j)
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

static sheen_status cross_validate(sheen_calibration *c, const job *j, sheen_err *err)
{
    c->has_halves = false;
    if (j->n_used < 2 * SHEEN_CALIBRATE_MIN_FRAMES)
        return SHEEN_OK;
    sheen_camera half[2];
    for (int k = 0; k < 2; k++) {
        sheen_problem p;
        const sheen_status s = solve_some(&p, j, k, 2, err);
        half[k] = p.camera;
        problem_release(&p);
        if (s == SHEEN_EDATA)
            return SHEEN_OK; // half of the frames are too few, which is no fault of the whole
        if (s)
            return s;
    }
    c->has_halves = true;
    if (sheen_camera_compare(&c->halves, &half[0], &half[1], c->distance_m, NULL)) {
        const double none = (double)NAN;
        c->halves = (sheen_camera_difference){none, none, none, none, none, none};
    }
    return SHEEN_OK;
}

static void find_sigma(sheen_calibration *c, const sheen_problem *p)
{
    enum { N = SHEEN_COVERAGE_ROWS * SHEEN_COVERAGE_COLS };
    double q_px[2 * (N + 1)], sigma_px[N + 1];
    for (size_t i = 0; i < N; i++) {
        const size_t col = i % SHEEN_COVERAGE_COLS, row = i / SHEEN_COVERAGE_COLS;
        q_px[2 * i] = ((double)col + 0.5) / SHEEN_COVERAGE_COLS * p->camera.width_px - 0.5;
        q_px[2 * i + 1] = ((double)row + 0.5) / SHEEN_COVERAGE_ROWS * p->camera.height_px - 0.5;
    }
    double *centre_px = q_px + (size_t)2 * N;
    centre_px[0] = (p->camera.width_px - 1) / 2.0;
    centre_px[1] = (p->camera.height_px - 1) / 2.0;
    c->sigma_centre_px = c->sigma_worst_px = (double)NAN;
    if (sheen_problem_sigma(sigma_px, p, q_px, N + 1, c->distance_m, c->rms_px, NULL))
        return;
    c->sigma_centre_px = sigma_px[N];
    c->sigma_worst_px = 0;
    for (int i = 0; i < N && isfinite(c->sigma_worst_px); i++)
        c->sigma_worst_px = sigma_px[i] <= c->sigma_worst_px ? c->sigma_worst_px : sigma_px[i];
}

static sheen_status run(sheen_calibration *c, job *j, const sheen_progress *progress, sheen_err *err)
{
    sheen_problem p = {0};
    sheen_status s = enough(c, j->n_used, err);
    for (int round = 0; round < 3 && !s; round++) {
        s = sheen_progress_step(progress, "calibration", round, STEPS, err);
        problem_release(&p);
        p = (sheen_problem){0};
        if (!s)
            s = solve_some(&p, j, 0, 1, err);
        if (s)
            break;
        sheen_calibration_summarise(c, &p, j->board, j->used);
        if (round == 2 || !drop_bad(c, j))
            break;
        s = enough(c, j->n_used, err);
    }
    if (!s) {
        find_sigma(c, &p);
        s = cross_validate(c, j, err);
    }
    if (!s) {
        sheen_calibration_judge(c);
        s = sheen_progress_step(progress, "calibration", STEPS, STEPS, err);
    }
    problem_release(&p);
    return s;
}

sheen_status sheen_calibrate(sheen_calibration *out, const sheen_board *board, const sheen_board_view *views,
                             size_t n_views, const sheen_calibrate_options *options, sheen_err *err)
{
    *out = (sheen_calibration){0};
    job j = {.board = board, .views = views};
    if (!n_views)
        return sheen_fail(err, SHEEN_EDATA, "there are no frames to calibrate from");
    sheen_status s = choose_lens(&j.camera, options->lensmodel, err);
    if (!s)
        s = check_views(board, views, n_views, err);
    if (s)
        return s;
    j.camera.width_px = views[0].width_px;
    j.camera.height_px = views[0].height_px;
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

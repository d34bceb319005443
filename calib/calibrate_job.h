// SPDX-License-Identifier: Apache-2.0
// calibrate_job.h - a calibration in the making: which views take part, and solving with some of them.
#ifndef SHEEN_CALIB_CALIBRATE_JOB_H
#define SHEEN_CALIB_CALIBRATE_JOB_H

#include "base/board.h"
#include "calib/calibrate.h"
#include "calib/calibrate_problem.h"
#include "calib/lens_model.h"

typedef struct sheen_calibrate_job {
    const sheen_board *board;
    const sheen_board_view *views;
    int width_px, height_px;
    const sheen_lens_model *lens;
    int *used; // [n_used]: indices of the views that take part
    int n_used;
    const sheen_board_view **chosen; // scratch, as long as used
} sheen_calibrate_job;

// The problem of every step-th of the used views from the first-th on, not yet solved. Release after failure too.
sheen_status sheen_job_problem(sheen_problem *p, const sheen_calibrate_job *j, int first, int step,
                               sheen_err *err);
// The same, seeded, solved in stages and rid of outliers. EDATA where it does not converge.
sheen_status sheen_job_solve(sheen_problem *p, const sheen_calibrate_job *j, int first, int step,
                             sheen_err *err);
// The same, from the solution of all used views, without its outliers: much quicker.
sheen_status sheen_job_solve_from(sheen_problem *p, const sheen_calibrate_job *j, int first, int step,
                                  const sheen_problem *whole, sheen_err *err);
void sheen_problem_release(sheen_problem *p);

// Solves with the even and with the odd views, from `whole`, and compares the two cameras (c->halves,
// c->normalised_error).
sheen_status sheen_job_cross_validate(sheen_calibration *c, const sheen_calibrate_job *j,
                                      const sheen_problem *whole, sheen_err *err);
// Chooses j->lens by how well each model, solved with half of the views, predicts the other half; fills
// c->candidates. Without enough views for that: opencv4.
sheen_status sheen_job_choose_lens(sheen_calibration *c, sheen_calibrate_job *j,
                                   const sheen_progress *progress, sheen_err *err);

#endif

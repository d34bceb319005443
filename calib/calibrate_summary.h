// SPDX-License-Identifier: Apache-2.0
// calibrate_summary.h - what a solved calibration is worth: figures and the verdict.
#ifndef SHEEN_CALIB_CALIBRATE_SUMMARY_H
#define SHEEN_CALIB_CALIBRATE_SUMMARY_H

#include "calib/calibrate.h"
#include "calib/calibrate_problem.h"

// Fills everything of *c but the halves, sigmas and the verdict from a solved problem. i_view[p->n_frames]: which
// of c->frames each of its frames is.
void sheen_calibration_summarise(sheen_calibration *c, const sheen_problem *p, const sheen_board *board,
                                 const int *i_view);
// good and verdict, from the other figures.
void sheen_calibration_judge(sheen_calibration *c);

#endif

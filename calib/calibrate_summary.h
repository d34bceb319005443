// SPDX-License-Identifier: Apache-2.0
// calibrate_summary.h - what a solved calibration is worth: figures and the verdict.
#ifndef SHEEN_CALIB_CALIBRATE_SUMMARY_H
#define SHEEN_CALIB_CALIBRATE_SUMMARY_H

#include "calib/calibrate.h"
#include "calib/calibrate_job.h"

// Fills everything of *c but the halves, sigmas, region and verdict from a solved problem of all used views. ENOMEM.
sheen_status sheen_calibration_summarise(sheen_calibration *c, const sheen_problem *p,
                                         const sheen_calibrate_job *j, sheen_err *err);
// The valid region, from the map of sigmas.
void sheen_calibration_bound(sheen_calibration *c);
// good and verdict, from the other figures.
void sheen_calibration_judge(sheen_calibration *c);

#endif

// SPDX-License-Identifier: Apache-2.0
// calibrate_outliers.h - corners that a calibration should not believe.
#ifndef SHEEN_CALIB_CALIBRATE_OUTLIERS_H
#define SHEEN_CALIB_CALIBRATE_OUTLIERS_H

#include "calib/calibrate_problem.h"

// Gives a negative weight to every corner of a solved problem whose residual is longer than `limit` times sigma,
// sigma being that of a normal distribution with the residuals' median length. *n_out: how many; *longest: the longest
// residual before, in sigmas. ENOMEM.
sheen_status sheen_problem_reject(int *n_out, double *longest, sheen_problem *p, double limit,
                                  sheen_err *err);

#endif

// SPDX-License-Identifier: Apache-2.0
// fit_report.h - a fit for a person to judge: one HTML file with what was found, how sure it is, and the pictures.
#ifndef SHEEN_FIT_FIT_REPORT_H
#define SHEEN_FIT_FIT_REPORT_H

#include "fit/evaluate.h"
#include "fit/fit_session.h"

typedef struct sheen_fit_timing {
    const char *what;
    double wall_s, cpu_s;
} sheen_fit_timing;

typedef struct sheen_fit_report {
    const sheen_session *session; // whose model/ was just fitted: its pictures go into the report
    const sheen_fit_summary *summary;
    const sheen_evaluation *evaluation; // NULL: no test frames to score on
    const sheen_fit_timing *timings;
    size_t n_timings;
} sheen_fit_report;

// Writes the report in one step. EIO, EFORMAT (a picture of model/ cannot be read), ENOMEM.
sheen_status sheen_fit_report_write(const char *path, const sheen_fit_report *report, sheen_err *err);

#endif

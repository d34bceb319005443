// SPDX-License-Identifier: Apache-2.0
// progress.h - how a long stage says how far it is, is asked to stop, and is timed.
//
// A stage's options struct holds one of these by value; all-zero means silent.
#ifndef SHEEN_BASE_PROGRESS_H
#define SHEEN_BASE_PROGRESS_H

#include <stdbool.h>

#include "base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_progress {
    // Called from the thread that runs the stage, at most a few hundred times. `what` is a
    // few words ("visibility"); `done` of `total` steps of it are behind us. False: stop.
    bool (*step)(void *self, const char *what, int done, int total);
    // Called when a named part of the stage has ended, with the time it took.
    void (*timed)(void *self, const char *what, double wall_s, double cpu_s);
    void *self;
} sheen_progress;

// Reports a step. ECANCEL when the caller asked to stop.
sheen_status sheen_progress_step(const sheen_progress *p, const char *what, int done, int total,
                                 sheen_err *err);

typedef struct sheen_stopwatch {
    double wall_s, cpu_s;
} sheen_stopwatch;

// Monotonic wall time and this process's CPU time, both since some fixed moment.
sheen_stopwatch sheen_stopwatch_now(void);

// Reports the time since *since under the name `what`, and restarts *since.
void sheen_progress_timed(const sheen_progress *p, const char *what, sheen_stopwatch *since);

#ifdef __cplusplus
}
#endif
#endif

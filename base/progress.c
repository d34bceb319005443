// SPDX-License-Identifier: Apache-2.0
// progress.c - progress, cancelling and timing through the caller's callbacks.
#include "base/progress.h"

#include <time.h>

sheen_status sheen_progress_step(const sheen_progress *p, const char *what, int done, int total,
                                 sheen_err *err)
{
    if (!p || !p->step || p->step(p->self, what, done, total))
        return SHEEN_OK;
    return sheen_fail(err, SHEEN_ECANCEL, "cancelled during '%s'", what);
}

static double clock_s(clockid_t id)
{
    struct timespec t;
    clock_gettime(id, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

sheen_stopwatch sheen_stopwatch_now(void)
{
    return (sheen_stopwatch){clock_s(CLOCK_MONOTONIC), clock_s(CLOCK_PROCESS_CPUTIME_ID)};
}

void sheen_progress_timed(const sheen_progress *p, const char *what, sheen_stopwatch *since)
{
    const sheen_stopwatch now = sheen_stopwatch_now();
    if (p && p->timed)
        p->timed(p->self, what, now.wall_s - since->wall_s, now.cpu_s - since->cpu_s);
    *since = now;
}

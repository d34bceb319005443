// SPDX-License-Identifier: Apache-2.0
// ladder.c - waits for frames; climbs from the mildest remedy to the person when they stay away.
//
// Time is counted in slices of waiting rather than by a clock: a computer that was asleep has not waited.
#include "capture/ladder.h"

#include <stdio.h>

enum { DEFAULT_TIMEOUT_MS = 10000, SLICE_MS = 200, RETRY_MS = 2000 };

static sheen_status go_on(const sheen_ladder *l, sheen_err *err)
{
    return sheen_progress_step(&l->options->progress, "recording", l->done, l->total, err);
}

static void notice(const sheen_ladder *l, const char *text)
{
    if (l->options->notice)
        l->options->notice(l->options->notice_self, text);
}

// What counts as no answer is a time in which a camera delivered nothing at all, not even frames that are of no use.
static sheen_status wait_for_frame(sheen_ladder *l, sheen_frame *frame, sheen_err *err)
{
    const int timeout_ms = l->options->timeout_ms ? l->options->timeout_ms : DEFAULT_TIMEOUT_MS;
    int64_t n_before = -1;
    int waited_ms = 0;
    for (;;) {
        sheen_source_counts counts;
        sheen_status st = sheen_source_next(l->src, SLICE_MS, frame, err);
        if (st != SHEEN_ETIMEOUT)
            return st;
        sheen_source_counters(&counts, l->src);
        waited_ms = counts.n_frames == n_before ? waited_ms + SLICE_MS : SLICE_MS;
        n_before = counts.n_frames;
        if (waited_ms >= timeout_ms)
            return st;
        st = go_on(l, err);
        if (st)
            return st;
    }
}

static bool is_climbed(const sheen_ladder *l, sheen_status st)
{
    return (st == SHEEN_ETIMEOUT || st == SHEEN_EIO || st == SHEEN_ENODEV) &&
           sheen_source_can_recover(l->src);
}

// The next remedy that the source has. ENODEV: only the person is left.
static sheen_status climb(sheen_ladder *l, sheen_status why)
{
    static const char *const said[SHEEN_RUNG_COUNT] = {
        [SHEEN_RUNG_RESTART] = "no frame comes: the camera's stream is started again",
        [SHEEN_RUNG_REOPEN] = "still no frame: the camera is closed and opened again",
        [SHEEN_RUNG_RESET] = "still no frame: the camera's USB device is reset",
    };
    if (why == SHEEN_ENODEV)
        l->rung = SHEEN_RUNG_COUNT;
    while (l->rung < SHEEN_RUNG_COUNT) {
        const sheen_rung rung = (sheen_rung)l->rung++;
        sheen_err e;
        if (rung == SHEEN_RUNG_RESET && !l->had_frame)
            continue;
        notice(l, said[rung]);
        const sheen_status st = sheen_source_recover(l->src, rung, &e);
        if (st == SHEEN_OK)
            return SHEEN_OK;
        if (st == SHEEN_ENODEV)
            l->rung = SHEEN_RUNG_COUNT;
        else if (st != SHEEN_EUNSUP)
            notice(l, e.msg);
    }
    return SHEEN_ENODEV;
}

// Asks the person, and opens the camera as soon as it is there again. *err holds why it has come to this.
static sheen_status wait_for_person(sheen_ladder *l, sheen_status why, sheen_err *err)
{
    char text[sizeof err->msg + 120];
    const int patience_ms = (int)(1000 * l->options->patience_s);
    int since_try_ms = RETRY_MS;
    if (patience_ms <= 0)
        return why;
    snprintf(text, sizeof text,
             "%s; unplug the camera and plug it in again, the session goes on by itself "
             "(waiting %.0f s, Ctrl-C ends)",
             err->msg, l->options->patience_s);
    notice(l, text);
    for (int waited_ms = 0; waited_ms < patience_ms; waited_ms += SLICE_MS) {
        const sheen_status st = go_on(l, err);
        if (st)
            return st;
        const bool here = sheen_source_await(l->src, SLICE_MS);
        since_try_ms += SLICE_MS;
        if (!here || since_try_ms < RETRY_MS)
            continue;
        sheen_err e;
        since_try_ms = 0;
        if (!sheen_source_recover(l->src, SHEEN_RUNG_REOPEN, &e)) {
            notice(l, "the camera is there again");
            return SHEEN_OK;
        }
        notice(l, e.msg);
    }
    return why;
}

sheen_status sheen_ladder_next(sheen_ladder *l, sheen_frame *frame, sheen_err *err)
{
    sheen_err e = {0};
    bool climbed = false;
    sheen_status st;
    while (is_climbed(l, st = wait_for_frame(l, frame, &e))) {
        climbed = true;
        if (climb(l, st)) {
            st = wait_for_person(l, st, &e);
            if (st)
                break;
            l->rung = SHEEN_RUNG_RESTART + 1; // it was opened just now
        }
    }
    if (st) {
        if (err)
            *err = e;
        return st;
    }
    l->n_recovered += climbed;
    l->rung = SHEEN_RUNG_RESTART;
    l->had_frame = true;
    return SHEEN_OK;
}

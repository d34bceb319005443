// SPDX-License-Identifier: Apache-2.0
// turn_steps.c - one step after the other; at rest is what the picture shows, not what a clock says.
//
// The picture's means over 32 x 24 blocks are compared from frame to frame: noise averages out in a block, while an edge
// that moves by a third of a pixel changes some block by more than the limit.
#include "capture/turn_steps.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"

enum { COLUMNS = 32, ROWS = 24, BLOCKS = COLUMNS * ROWS, STILL = 2, GIVE_UP = 200, UNSTAMPED = 12 };

static const float still_share = 0.004f; // of full scale, by which a block's mean may differ
static const double default_tolerance_deg = 0.5;

static void step_name(char name[64], int i_round, int i_step)
{
    if (i_step < 0)
        snprintf(name, 64, "r%d-empty", i_round);
    else
        snprintf(name, 64, "r%d-%03d", i_round, i_step);
}

static bool has_step(const sheen_session *s, int i_round, int i_step)
{
    char name[64];
    step_name(name, i_round, i_step);
    return sheen_session_find(s, name) != NULL;
}

// The empty table stands as in the first step.
static double step_deg(const sheen_turn_options *o, int i_step)
{
    return i_step < 0 ? 0 : 360.0 * i_step / o->n_steps;
}

static int first_step(const sheen_turn_options *o, int i_round)
{
    return o->place_object && i_round == 1 ? -1 : 0;
}

static bool *taken(const sheen_turn_steps *t, int i_round, int i_step)
{
    return &t->taken[(i_round - 1) * (1 + t->o.n_steps) + 1 + i_step];
}

size_t sheen_turn_steps_missing(const sheen_session *s, const sheen_turn_options *o)
{
    size_t n = 0;
    for (int r = 1; r <= o->n_rounds; r++)
        for (int k = first_step(o, r); k < o->n_steps; k++)
            n += !has_step(s, r, k);
    return n;
}

sheen_status sheen_turn_steps_init(sheen_turn_steps *t, sheen_session *session, sheen_table *table,
                                   const sheen_turn_options *options, sheen_err *err)
{
    if (options->place_object && !has_step(session, 1, -1))
        for (int k = 0; k < options->n_steps; k++)
            if (has_step(session, 1, k))
                return sheen_fail(err, SHEEN_EARG,
                                  "the picture of the empty table is taken first, and '%s' has frames of the "
                                  "object already, which must not be moved: leave --background out",
                                  session->path);
    *t = (sheen_turn_steps){.session = session, .table = table, .o = *options};
    if (!(t->o.tolerance_deg > 0))
        t->o.tolerance_deg = default_tolerance_deg;
    t->blocks = malloc(2 * BLOCKS * sizeof *t->blocks);
    t->taken = calloc((size_t)(t->o.n_rounds * (1 + t->o.n_steps)) + 1, sizeof *t->taken);
    if (!t->blocks || !t->taken) {
        sheen_turn_steps_release(t);
        return sheen_fail_memory(err, 2.0 * BLOCKS * sizeof *t->blocks, "the picture's means");
    }
    for (int r = 1; r <= t->o.n_rounds; r++)
        for (int k = -1; k < t->o.n_steps; k++)
            *taken(t, r, k) = has_step(session, r, k);
    return SHEEN_OK;
}

void sheen_turn_steps_release(sheen_turn_steps *t)
{
    free(t->blocks);
    free(t->taken);
    t->blocks = NULL;
    t->taken = NULL;
}

// The next frame that the session has not; false: it has all.
static bool find_next(int *i_round, int *i_step, const sheen_turn_steps *t)
{
    for (*i_round = 1; *i_round <= t->o.n_rounds; ++*i_round)
        for (*i_step = first_step(&t->o, *i_round); *i_step < t->o.n_steps; ++*i_step)
            if (!*taken(t, *i_round, *i_step))
                return true;
    return false;
}

// A frame of this round from which the angle is counted; NULL: there is none yet.
static const sheen_frame_info *reference_of(const sheen_turn_steps *t, int i_round)
{
    char name[64];
    for (int k = 0; k < t->o.n_steps; k++) {
        step_name(name, i_round, k);
        const sheen_frame_info *f = sheen_session_find(t->session, name);
        if (f)
            return f;
    }
    return NULL;
}

static sheen_status ask(void *self, int64_t *since_ns, sheen_err *err)
{
    sheen_turn_steps *t = self;
    int i_round, i_step;
    if (!find_next(&i_round, &i_step, t))
        return sheen_fail(err, SHEEN_EEND, "all steps are recorded");
    if (i_round != t->i_round) {
        t->placed = false;
        t->camera_waits = i_round > 1 && !reference_of(t, i_round) && t->o.next_round;
        t->n_taken = 0;
    }
    if (t->o.place_object && i_round == 1 && i_step >= 0 && (i_round != t->i_round || t->i_step < 0))
        t->object_waits = !reference_of(t, i_round) || t->i_step < 0;
    t->i_round = i_round;
    t->i_step = i_step;
    t->turned = false;
    t->stood_ns = *since_ns = sheen_clock_ns();
    return SHEEN_OK;
}

// Where the table stands: known still, seen in this frame, or (the very beginning) where angle 0 shall be. Angles count on
// from round to round, so that they tie the rounds together: a new one begins while the camera stands as in the one before.
static sheen_status place(sheen_turn_steps *t, const sheen_frame *frame, sheen_err *err)
{
    const sheen_frame_info *reference = reference_of(t, t->i_round);
    if (!reference && t->i_round > 1)
        reference = reference_of(t, t->i_round - 1);
    sheen_table_state now;
    double seen_deg = 0;
    sheen_status s = sheen_table_get(&now, t->table, err);
    if (s)
        return s;
    if (reference && (!now.angle_known || t->o.see)) {
        if (!t->o.see)
            return sheen_fail(
                err, SHEEN_EDATA,
                "the turntable's angle is not known, and nothing can see it: give the session its "
                "camera and board ('sheen import --camera FILE --board FILE'), or begin a new session");
        if ((s = t->o.see(t->o.self, frame, reference, &seen_deg, err)))
            return s;
        const double at = isfinite(reference->table_measured_deg) ? reference->table_measured_deg
                                                                  : reference->table_asked_deg;
        seen_deg += isfinite(at) ? at : 0;
    }
    if (!reference || !now.angle_known || t->o.see)
        s = sheen_table_set_angle(t->table, seen_deg - 360 * floor((seen_deg + 180) / 360), err);
    t->placed = !s;
    return s;
}

static sheen_status turn(sheen_turn_steps *t, sheen_err *err)
{
    const sheen_status s = sheen_table_turn_to(t->table, step_deg(&t->o, t->i_step), err);
    t->stood_ns = sheen_clock_ns();
    t->turned = !s;
    t->n_still = t->n_looked = t->n_old = 0;
    return s;
}

static float sample(const sheen_raster *r, size_t at)
{
    if (r->bits == 8)
        return (float)((const uint8_t *)r->data)[at] / 255;
    return r->bits == 16 ? (float)((const uint16_t *)r->data)[at] / 65535 : ((const float *)r->data)[at];
}

static void block_means(float mean[BLOCKS], const sheen_raster *r)
{
    const size_t n = (size_t)r->n_channels, middle = n >= 3 ? 1 : 0; // green
    for (int b = 0; b < BLOCKS; b++) {
        const int x0 = b % COLUMNS * r->width_px / COLUMNS, x1 = (b % COLUMNS + 1) * r->width_px / COLUMNS;
        const int y0 = b / COLUMNS * r->height_px / ROWS, y1 = (b / COLUMNS + 1) * r->height_px / ROWS;
        float sum = 0;
        for (int y = y0; y < y1; y++)
            for (int x = x0; x < x1; x++)
                sum += sample(r, ((size_t)y * (size_t)r->width_px + (size_t)x) * n + middle);
        mean[b] = sum / fmaxf(1, (float)((x1 - x0) * (y1 - y0)));
    }
}

// True when this frame and the ones before it show the same.
static sheen_status at_rest(bool *still, sheen_turn_steps *t, const sheen_frame *frame, sheen_err *err)
{
    sheen_raster r;
    float *before = t->blocks + BLOCKS * (t->n_looked % 2),
          *now = t->blocks + BLOCKS * ((t->n_looked + 1) % 2);
    const sheen_status s = sheen_frame_develop(&r, frame, err);
    if (s)
        return s;
    block_means(now, &r);
    sheen_raster_release(&r);
    float most = 0;
    for (int b = 0; b < BLOCKS && t->n_looked; b++)
        most = fmaxf(most, fabsf(now[b] - before[b]));
    t->n_still = t->n_looked && most < still_share ? t->n_still + 1 : 0;
    t->n_looked++;
    *still = t->n_still >= STILL;
    if (!*still && t->n_looked > GIVE_UP)
        return sheen_fail(
            err, SHEEN_EDATA,
            "the picture does not come to rest although the turntable stands: does the object shake, "
            "the camera move, or a lamp flicker?");
    return SHEEN_OK;
}

// The angle in the frame that is taken, beside the one that was commanded.
static sheen_status measure(sheen_turn_steps *t, sheen_frame *frame, sheen_err *err)
{
    const sheen_frame_info *reference = reference_of(t, t->i_round);
    const double asked_deg = step_deg(&t->o, t->i_step);
    double seen_deg;
    frame->info.table_asked_deg = asked_deg;
    if (!t->o.see || (!reference && t->n_taken)) // or the reference is still on its way to the disk
        return SHEEN_OK;
    const sheen_status s = t->o.see(t->o.self, frame, reference, &seen_deg, err);
    if (s == SHEEN_EDATA) // the board is hidden at this angle: the command has to do
        return SHEEN_OK;
    if (s)
        return s;
    if (reference)
        seen_deg += isfinite(reference->table_measured_deg) ? reference->table_measured_deg
                                                            : reference->table_asked_deg;
    const double off_deg = seen_deg - asked_deg - 360 * round((seen_deg - asked_deg) / 360);
    if (reference && fabs(off_deg) > t->o.tolerance_deg) {
        t->placed = false;
        return sheen_fail(err, SHEEN_EDATA,
                          "the turntable was told %.2f degrees and the tags show %.2f: it slips, is blocked, "
                          "or its file is "
                          "wrong ('sheen turntable --setup' measures it)",
                          asked_deg, asked_deg + off_deg);
    }
    frame->info.table_measured_deg = asked_deg + off_deg;
    return SHEEN_OK;
}

static sheen_status look(void *self, sheen_frame *frame, sheen_verdict *verdict, sheen_err *err)
{
    sheen_turn_steps *t = self;
    bool still = false;
    sheen_status s = SHEEN_OK;
    *verdict = SHEEN_VERDICT_PASS;
    if (!t->turned) {
        if (!t->placed && (s = place(t, frame, err)))
            return s;
        if (t->camera_waits && (s = t->o.next_round(t->o.self, t->i_round, err)))
            return s;
        t->camera_waits = false;
        if (t->i_step < 0 || t->object_waits) {
            if ((s = t->o.place_object(t->o.self, t->i_step >= 0, err)))
                return s;
            t->object_waits = false;
        }
        return turn(t, err);
    }
    // A camera's buffers hold frames from before.
    if (frame->info.t_ns >= 0 ? frame->info.t_ns < t->stood_ns : t->n_old++ < UNSTAMPED)
        return SHEEN_OK;
    if ((s = at_rest(&still, t, frame, err)) || !still)
        return s;
    if ((s = measure(t, frame, err)))
        return s;
    step_name(frame->info.name, t->i_round, t->i_step);
    *taken(t, t->i_round, t->i_step) = true;
    if (t->i_step < 0)
        frame->info.role = SHEEN_ROLE_BACKGROUND;
    else
        t->n_taken++;
    *verdict = SHEEN_VERDICT_TAKE;
    return SHEEN_OK;
}

sheen_record_policy sheen_turn_steps_policy(sheen_turn_steps *t)
{
    return (sheen_record_policy){.self = t, .ask = ask, .look = look};
}

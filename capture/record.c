// SPDX-License-Identifier: Apache-2.0
// record.c - the recorder: asks a source for frames and adds them to a session one by one.
#include "capture/record.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "capture/bracket.h"
#include "capture/ladder.h"
#include "capture/record_queue.h"

// MAX_WAITING: frames that a camera may have had waiting.
enum { SLICE_MS = 200, MAX_WAITING = 12 };

typedef struct recording {
    sheen_session *session;
    sheen_source *src;
    const sheen_record_options *options;
    sheen_record_report *report;
    sheen_record_queue *queue;
    sheen_ladder ladder;
    int done, total;
    unsigned long last_number; // last name given to a frame that is still in the queue
    bool slow_said, compared;
} recording;

// The session's copy of a frame, if it has one.
static const sheen_frame_info *find_copy(const sheen_session *s, const sheen_frame *frame, const char *digest)
{
    const sheen_frame_info *f = &frame->info;
    for (size_t i = 0; i < s->n_frames; i++) {
        const sheen_frame_info *g = &s->frames[i];
        const bool same_name = !f->name[0] || !strcmp(f->name, g->name);
        if (same_name && f->sequence == g->sequence && !strcmp(digest, g->payload_digest) &&
            !strcmp(f->source, g->source))
            return g;
    }
    return NULL;
}

static sheen_status tell(const recording *r, const sheen_frame_info *info, sheen_err *err)
{
    const sheen_record_policy *p = &r->options->policy;
    return p->stored ? p->stored(p->self, info, err) : SHEEN_OK;
}

// Takes in what became of frames in the queue; with `wait`, of one at least.
static sheen_status collect(recording *r, bool wait, sheen_err *err)
{
    sheen_frame_info info;
    for (int timeout_ms = wait ? SLICE_MS : 0;; timeout_ms = 0) {
        sheen_status st = sheen_record_queue_collect(r->queue, &info, timeout_ms, err);
        if (st == SHEEN_ETIMEOUT)
            return SHEEN_OK;
        if (st)
            r->report->n_lost++;
        else {
            r->report->n_recorded++;
            st = sheen_session_enter_frame(r->session, &info, err);
        }
        if (!st)
            st = tell(r, &info, err);
        if (st)
            return st;
    }
}

static sheen_status drain(recording *r, sheen_err *err)
{
    sheen_status st = SHEEN_OK;
    while (!st && sheen_record_queue_count(r->queue))
        st = collect(r, true, err);
    return st;
}

static sheen_status go_on(recording *r, sheen_err *err)
{
    const sheen_status st = collect(r, false, err);
    r->done = (int)(r->report->n_recorded + r->report->n_present);
    r->ladder.done = r->done;
    return st ? st : sheen_progress_step(&r->options->progress, "recording", r->done, r->total, err);
}

// The next number, counting those that are on their way to the disk.
static void give_name(recording *r, char name[64])
{
    sheen_session_next_name(r->session, name);
    unsigned long number = strtoul(name, NULL, 10);
    if (sheen_record_queue_count(r->queue) && number <= r->last_number)
        number = r->last_number + 1;
    snprintf(name, 64, "%06lu", number);
    r->last_number = number;
}

static void say_slow(recording *r, const char *what)
{
    char text[200];
    snprintf(text, sizeof text, "the disk is slower than the camera: %s", what);
    if (!r->slow_said && r->options->notice)
        r->options->notice(r->options->notice_self, text);
    r->slow_said = true;
}

// Room for one more in the queue. *room false: not for a frame that is only offered.
static sheen_status make_room(bool *room, recording *r, const sheen_frame *frame, sheen_verdict verdict,
                              sheen_err *err)
{
    const size_t n = frame->size_bytes + frame->mask_bytes;
    *room = sheen_record_queue_wait_room(r->queue, n, 0);
    if (!*room && verdict == SHEEN_VERDICT_OFFER) {
        say_slow(r, "frames are passed over");
        r->report->n_skipped++;
        return SHEEN_OK;
    }
    while (!*room) {
        say_slow(r, "it is waited for, none of the frames that were taken is lost");
        *room = sheen_record_queue_wait_room(r->queue, n, SLICE_MS);
        const sheen_status st = go_on(r, err);
        if (st && st != SHEEN_ECANCEL) // what was taken before the person ended it is still written
            return st;
    }
    return SHEEN_OK;
}

// A recording never runs ahead of the disk: each of its frames may be one that the session has by then.
static sheen_status add(recording *r, sheen_frame *frame, sheen_verdict verdict, sheen_err *err)
{
    bool room;
    sheen_status st = make_room(&room, r, frame, verdict, err);
    if (st || !room)
        return st;
    if (!frame->info.name[0] || sheen_session_find(r->session, frame->info.name))
        give_name(r, frame->info.name);
    st = sheen_record_queue_push(r->queue, frame, err);
    if (!st && !sheen_source_is_live(r->src))
        st = drain(r, err);
    return st;
}

// Since when a frame is wanted: asks between frames until the policy says so. Frames of a recording have no such time.
static sheen_status ask(int64_t *since_ns, recording *r, sheen_err *err)
{
    const sheen_record_policy *p = &r->options->policy;
    const sheen_status st = p->ask && *since_ns < 0 ? p->ask(p->self, since_ns, err) : SHEEN_OK;
    if (!p->ask || !sheen_source_is_live(r->src))
        *since_ns = 0;
    return st;
}

// Where a camera does not say when a frame was exposed, those that may have waited in its buffers pass first.
static bool is_after(const sheen_frame *frame, int64_t since_ns, int *n_passed)
{
    if (since_ns <= 0)
        return since_ns == 0;
    return frame->info.t_ns < 0 ? (*n_passed)++ >= MAX_WAITING : frame->info.t_ns >= since_ns;
}

static sheen_status look(sheen_frame *frame, sheen_verdict *verdict, const recording *r, sheen_err *err)
{
    const sheen_record_policy *p = &r->options->policy;
    *verdict = p->look || p->ask ? SHEEN_VERDICT_TAKE : SHEEN_VERDICT_OFFER;
    return p->look ? p->look(p->self, frame, verdict, err) : SHEEN_OK;
}

// Frames go by until one is wanted; then until one that was exposed after that moment and that the policy likes.
static sheen_status wanted_frame(sheen_frame *frame, sheen_verdict *verdict, recording *r, sheen_err *err)
{
    int64_t since_ns = -1;
    int n_passed = 0;
    for (;;) {
        sheen_status st = ask(&since_ns, r, err);
        if (!st)
            st = sheen_ladder_next(&r->ladder, frame, err);
        if (st)
            return st;
        if (is_after(frame, since_ns, &n_passed)) {
            st = look(frame, verdict, r, err);
            if (st || *verdict != SHEEN_VERDICT_PASS)
                return st;
        }
        st = go_on(r, err);
        if (st)
            return st;
    }
}

// Another camera may sit where that of the session's earlier frames did.
static void compare_camera(recording *r, const sheen_frame *frame)
{
    const sheen_session *s = r->session;
    char text[700];
    if (r->compared || !r->options->notice || !frame->info.device[0])
        return;
    r->compared = true;
    for (size_t i = s->n_frames; i-- > 0;) {
        const sheen_frame_info *g = &s->frames[i];
        if (!g->device[0] || strcmp(g->source, frame->info.source) != 0)
            continue;
        if (!sheen_device_is_alike(g->device, frame->info.device)) {
            snprintf(text, sizeof text,
                     "another camera is at '%.120s' now: %.100s; frame '%s' was taken by %.100s; 'sheen "
                     "devices' lists the "
                     "names that stay with a camera",
                     frame->info.source, frame->info.device, g->name, g->device);
            r->options->notice(r->options->notice_self, text);
        }
        return;
    }
}

// Puts a frame that was taken into the session, where it is not there already.
static sheen_status keep(recording *r, sheen_frame *frame, sheen_verdict verdict, sheen_err *err)
{
    char digest[33];
    if (r->options->set_role && frame->info.role != SHEEN_ROLE_BACKGROUND)
        frame->info.role = r->options->role;
    sheen_digest(digest, frame->data, frame->size_bytes);
    const sheen_frame_info *copy = sheen_source_is_live(r->src) ? NULL : find_copy(r->session, frame, digest);
    if (!copy)
        return add(r, frame, verdict, err);
    r->report->n_present++;
    return tell(r, copy, err);
}

static sheen_status record_one(recording *r, sheen_err *err)
{
    const sheen_record_options *o = r->options;
    sheen_frame frame;
    sheen_verdict verdict;
    sheen_status st = wanted_frame(&frame, &verdict, r, err);
    if (!st && o->check)
        st = o->check(o->check_self, &frame, err);
    if (st)
        return st;
    compare_camera(r, &frame);
    uint8_t *merged = NULL;
    if (o->bracket)
        st = sheen_bracket_take(&frame, &merged, r->session, &r->ladder, o->bracket, err);
    if (!st)
        st = keep(r, &frame, verdict, err);
    free(merged);
    return st;
}

// Frames that are asked for, 0 where nobody can tell.
static int total_frames(const sheen_source *src, size_t count)
{
    const int64_t has = sheen_source_count(src);
    if (has >= 0 && (!count || (uint64_t)has < count))
        return (int)has;
    return (int)count;
}

static bool is_enough(const recording *r)
{
    const sheen_record_report *n = r->report;
    return r->options->count &&
           n->n_recorded + n->n_present + sheen_record_queue_count(r->queue) >= r->options->count;
}

// Whatever has ended the recording: what was taken goes to the disk. The first failure's sentence is kept.
static sheen_status finish(recording *r, sheen_err *err)
{
    sheen_status st = drain(r, err);
    while (sheen_record_queue_count(r->queue))
        drain(r, NULL);
    sheen_record_queue_close(&r->queue);
    r->report->n_recovered = r->ladder.n_recovered;
    r->done = (int)(r->report->n_recorded + r->report->n_present);
    if (!st)
        st = sheen_progress_step(&r->options->progress, "recording", r->done, r->total, err);
    return st;
}

sheen_status sheen_record(sheen_session *session, sheen_source *src, const sheen_record_options *options,
                          sheen_record_report *report, sheen_err *err)
{
    *report = (sheen_record_report){0};
    recording r = {.session = session, .src = src, .options = options, .report = report};
    r.total = total_frames(src, options->count);
    r.ladder = (sheen_ladder){.src = src, .options = options, .total = r.total};
    sheen_err e = {0}, late = {0}; // the end of the recording is no error of ours
    sheen_status st = sheen_record_queue_open(&r.queue, session, options, err);
    if (st)
        return st;
    while (!st && !is_enough(&r)) {
        st = go_on(&r, &e);
        if (!st)
            st = record_one(&r, &e);
    }
    const sheen_status written = finish(&r, &late);
    if (written && (!st || st == SHEEN_EEND || st == SHEEN_ECANCEL)) {
        st = written; // worse than what ended the recording
        e = late;
    } else if (st == SHEEN_EEND)
        st = r.done ? SHEEN_OK : sheen_wrap(&e, SHEEN_EDATA, "no frame was recorded");
    if (st && err)
        *err = e;
    return st;
}

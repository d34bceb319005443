// SPDX-License-Identifier: Apache-2.0
// record.c - the recorder: asks a source for frames and adds them to a session one by one.
#include "capture/record.h"

#include <stdio.h>
#include <string.h>

// MAX_WAITING: frames that a camera may have had waiting.
enum { DEFAULT_TIMEOUT_MS = 10000, SLICE_MS = 200, MAX_WAITING = 12 };

typedef struct recording {
    sheen_session *session;
    sheen_source *src;
    const sheen_record_options *options;
    int done, total;
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

// The mask goes first: once the frame counts, its mask is there.
static sheen_status add(sheen_session *s, sheen_frame *frame, sheen_err *err)
{
    sheen_frame_info *info = &frame->info;
    if (!info->name[0] || sheen_session_find(s, info->name))
        sheen_session_next_name(s, info->name);
    if (frame->mask) {
        const sheen_status st = sheen_session_add_mask(s, SHEEN_SESSION_MASKS, info->name, frame->mask,
                                                       frame->mask_bytes, err);
        if (st)
            return st;
    }
    return sheen_session_add_frame(s, info, frame->extension, frame->data, frame->size_bytes, err);
}

// The next frame. It waits a little at a time, so that the caller can stop; what counts as no answer is a time in which
// a camera delivered nothing at all, not even frames that are of no use.
static sheen_status next_frame(sheen_frame *frame, recording *r, sheen_err *err)
{
    const sheen_record_options *o = r->options;
    const int timeout_ms = o->timeout_ms ? o->timeout_ms : DEFAULT_TIMEOUT_MS;
    int64_t n_before = -1;
    int waited_ms = 0;
    for (;;) {
        sheen_source_counts counts;
        sheen_status st = sheen_source_next(r->src, SLICE_MS, frame, err);
        if (st != SHEEN_ETIMEOUT)
            return st;
        sheen_source_counters(&counts, r->src);
        waited_ms = counts.n_frames == n_before ? waited_ms + SLICE_MS : SLICE_MS;
        n_before = counts.n_frames;
        if (waited_ms >= timeout_ms)
            return st;
        st = sheen_progress_step(&o->progress, "recording", r->done, r->total, err);
        if (st)
            return st;
    }
}

// Since when a frame is wanted: asks between frames until the policy says so.
static sheen_status ask(int64_t *since_ns, recording *r, sheen_err *err)
{
    const sheen_record_policy *p = &r->options->policy;
    const bool asks = p->ask && sheen_source_is_live(r->src);
    if (!asks)
        *since_ns = 0;
    return asks && *since_ns < 0 ? p->ask(p->self, since_ns, err) : SHEEN_OK;
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
            st = next_frame(frame, r, err);
        if (st)
            return st;
        if (is_after(frame, since_ns, &n_passed)) {
            st = look(frame, verdict, r, err);
            if (st || *verdict != SHEEN_VERDICT_PASS)
                return st;
        }
        st = sheen_progress_step(&r->options->progress, "recording", r->done, r->total, err);
        if (st)
            return st;
    }
}

static sheen_status tell(const recording *r, const sheen_frame_info *info, sheen_err *err)
{
    const sheen_record_policy *p = &r->options->policy;
    return p->stored ? p->stored(p->self, info, err) : SHEEN_OK;
}

static sheen_status record_one(recording *r, sheen_record_report *report, sheen_err *err)
{
    const sheen_record_options *o = r->options;
    sheen_frame frame;
    sheen_verdict verdict;
    char digest[33];
    sheen_status st = wanted_frame(&frame, &verdict, r, err);
    if (!st && o->check)
        st = o->check(o->check_self, &frame, err);
    if (st)
        return st;
    if (o->set_role)
        frame.info.role = o->role;
    sheen_digest(digest, frame.data, frame.size_bytes);
    const sheen_frame_info *copy = sheen_source_is_live(r->src) ? NULL
                                                                : find_copy(r->session, &frame, digest);
    if (copy) {
        report->n_present++;
        return tell(r, copy, err);
    }
    st = add(r->session, &frame, err);
    if (st)
        return st;
    report->n_recorded++;
    return tell(r, &frame.info, err);
}

// Frames that are asked for, 0 where nobody can tell.
static int total_frames(const sheen_source *src, size_t count)
{
    const int64_t has = sheen_source_count(src);
    if (has >= 0 && (!count || (uint64_t)has < count))
        return (int)has;
    return (int)count;
}

sheen_status sheen_record(sheen_session *session, sheen_source *src, const sheen_record_options *options,
                          sheen_record_report *report, sheen_err *err)
{
    *report = (sheen_record_report){0};
    recording r = {session, src, options, 0, total_frames(src, options->count)};
    sheen_status st = SHEEN_OK;
    sheen_err e = {0}; // the end of the recording is no error of ours
    while (!st && (!options->count || (size_t)r.done < options->count)) {
        st = sheen_progress_step(&options->progress, "recording", r.done, r.total, &e);
        if (!st)
            st = record_one(&r, report, &e);
        r.done = (int)(report->n_recorded + report->n_present);
    }
    if (st == SHEEN_EEND)
        st = r.done ? SHEEN_OK : sheen_wrap(&e, SHEEN_EDATA, "no frame was recorded");
    if (!st)
        st = sheen_progress_step(&options->progress, "recording", r.done, r.total, &e);
    if (st && err)
        *err = e;
    return st;
}

// SPDX-License-Identifier: Apache-2.0
// record.c - the recorder: asks a source for frames and adds them to a session one by one.
#include "capture/record.h"

#include <stdio.h>
#include <string.h>

enum { DEFAULT_TIMEOUT_MS = 10000 };

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
    sheen_frame_info info = frame->info;
    if (!info.name[0] || sheen_session_find(s, info.name))
        sheen_session_next_name(s, info.name);
    if (frame->mask) {
        const sheen_status st = sheen_session_add_mask(s, SHEEN_SESSION_MASKS, info.name, frame->mask,
                                                       frame->mask_bytes, err);
        if (st)
            return st;
    }
    return sheen_session_add_frame(s, &info, frame->extension, frame->data, frame->size_bytes, err);
}

static sheen_status record_one(sheen_session *s, sheen_source *src, const sheen_record_options *o,
                               sheen_record_report *report, sheen_err *err)
{
    sheen_frame frame;
    char digest[33];
    sheen_status st = sheen_source_next(src, o->timeout_ms ? o->timeout_ms : DEFAULT_TIMEOUT_MS, &frame, err);
    if (st)
        return st;
    if (o->set_role)
        frame.info.role = o->role;
    sheen_digest(digest, frame.data, frame.size_bytes);
    if (find_copy(s, &frame, digest)) {
        report->n_present++;
        return SHEEN_OK;
    }
    st = add(s, &frame, err);
    if (!st)
        report->n_recorded++;
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

sheen_status sheen_record(sheen_session *session, sheen_source *src, const sheen_record_options *options,
                          sheen_record_report *report, sheen_err *err)
{
    *report = (sheen_record_report){0};
    const int total = total_frames(src, options->count);
    sheen_status st = SHEEN_OK;
    sheen_err e = {0}; // the end of the recording is no error of ours
    size_t n = 0;
    while (!st && (!options->count || n < options->count)) {
        st = sheen_progress_step(&options->progress, "recording", (int)n, total, &e);
        if (!st)
            st = record_one(session, src, options, report, &e);
        n = report->n_recorded + report->n_present;
    }
    if (st == SHEEN_EEND)
        st = n ? SHEEN_OK : sheen_fail(&e, SHEEN_EDATA, "the source gave no frame");
    if (!st)
        st = sheen_progress_step(&options->progress, "recording", (int)n, total, &e);
    if (st && err)
        *err = e;
    return st;
}

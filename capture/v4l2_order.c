// SPDX-License-Identifier: Apache-2.0
// v4l2_order.c - the waiting room of frames that came before their turn.
//
// The driver's counter has 32 bits and may wrap: differences are taken in 32 bits, the sum is kept in 64. A number that
// is not after the last one although its timestamp is means a driver that does not count, or began anew; such a frame
// is simply the next one.
#include "capture/v4l2_order.h"

static sheen_v4l2_frame *free_slot(sheen_v4l2_stream *s)
{
    for (size_t i = 0; i < SHEEN_V4L2_HOLD + 1; i++)
        if (!s->slots[i].used)
            return &s->slots[i];
    return NULL;
}

static sheen_v4l2_frame *first_held(sheen_v4l2_stream *s, int *n_held)
{
    sheen_v4l2_frame *first = NULL;
    *n_held = 0;
    for (size_t i = 0; i < SHEEN_V4L2_HOLD + 1; i++) {
        sheen_v4l2_frame *f = &s->slots[i];
        if (!f->used || f == s->lent)
            continue;
        ++*n_held;
        if (!first || f->sequence < first->sequence)
            first = f;
    }
    return first;
}

static int64_t last_known(const sheen_v4l2_stream *s)
{
    int64_t last = s->last_sequence;
    for (size_t i = 0; i < SHEEN_V4L2_HOLD + 1; i++)
        if (s->slots[i].used && s->slots[i].sequence > last)
            last = s->slots[i].sequence;
    return last;
}

sheen_v4l2_frame *sheen_v4l2_order_enter(sheen_v4l2_stream *s, uint32_t raw, int64_t t_ns)
{
    int held;
    const bool empty = !first_held(s, &held);
    if (!s->begun) {
        s->begun = true;
        s->last_raw = raw - 1;
        s->last_sequence = (int64_t)raw - 1;
        s->last_t_ns = -1;
    }
    int64_t sequence = s->last_sequence + (int32_t)(raw - s->last_raw);
    if (sequence <= s->last_sequence) {
        if (t_ns < 0 || s->last_t_ns < 0 || t_ns <= s->last_t_ns) {
            s->counts.n_late++;
            return NULL;
        }
        sequence = last_known(s) + 1; // the counter stands still or began anew
        s->last_raw = raw - (uint32_t)(sequence - s->last_sequence);
    }
    sheen_v4l2_frame *f = free_slot(s);
    if (!f) {
        s->counts.n_dropped++; // cannot be: what is held is taken before more is waited for
        return NULL;
    }
    f->used = true;
    f->sequence = sequence;
    f->t_ns = t_ns;
    if (empty)
        s->held_since_ns = s->io->now_ns(s->io->self);
    return f;
}

int64_t sheen_v4l2_order_patience(const sheen_v4l2_stream *s, int64_t deadline_ns)
{
    for (size_t i = 0; i < SHEEN_V4L2_HOLD + 1; i++)
        if (s->slots[i].used && &s->slots[i] != s->lent) {
            const int64_t until_ns = s->held_since_ns + 2 * s->format.interval_ns;
            return until_ns < deadline_ns ? until_ns : deadline_ns;
        }
    return deadline_ns;
}

sheen_v4l2_frame *sheen_v4l2_order_take(sheen_v4l2_stream *s, bool force)
{
    for (;;) {
        int n_held;
        sheen_v4l2_frame *f = first_held(s, &n_held);
        if (!f || (f->sequence != s->last_sequence + 1 && !force && n_held < SHEEN_V4L2_HOLD))
            return NULL;
        s->counts.n_dropped += f->sequence - s->last_sequence - 1;
        s->last_raw += (uint32_t)(f->sequence - s->last_sequence);
        s->last_sequence = f->sequence;
        s->last_t_ns = f->t_ns;
        s->held_since_ns = s->io->now_ns(s->io->self);
        if (!f->rejected)
            return f;
        f->used = false; // its place in the order is all that was kept
    }
}

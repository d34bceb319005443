// SPDX-License-Identifier: Apache-2.0
// fake_events.c - the fake camera's events: who wants to hear of which control, and what there is to tell.
#include <errno.h>
#include <string.h>

#include "tests/fake/fake_parts.h"

static int find(const fake_file *file, uint32_t id)
{
    for (int i = 0; i < file->n_events; i++)
        if (file->events[i].id == id)
            return i;
    return -1;
}

static void forget(fake_file *file, int i)
{
    file->events[i] = file->events[--file->n_events];
}

int fake_subscribe(fake_v4l2 *f, fake_file *file, const struct v4l2_event_subscription *e, bool on)
{
    const int i = find(file, e->id);
    if (!on && e->type == V4L2_EVENT_ALL) {
        file->n_events = 0;
        return 0;
    }
    if (e->type != V4L2_EVENT_CTRL)
        return EINVAL;
    if (!on) {
        if (i >= 0)
            forget(file, i);
        return 0;
    }
    const fake_control *c = fake_v4l2_control(f, e->id);
    if (!c || file->n_events == FAKE_MAX_EVENTS)
        return c ? ENOMEM : EINVAL;
    const int at = i >= 0 ? i : file->n_events++;
    file->events[at].id = e->id;
    file->events[at].flags = e->flags;
    file->events[at].changes = 0;
    if (e->flags & V4L2_EVENT_SUB_FL_SEND_INITIAL && c->type != V4L2_CTRL_TYPE_CTRL_CLASS)
        file->events[at].changes = V4L2_EVENT_CTRL_CH_FLAGS |
                                   (c->flags & V4L2_CTRL_FLAG_WRITE_ONLY ? 0 : V4L2_EVENT_CTRL_CH_VALUE);
    return 0;
}

void fake_tell(fake_v4l2 *f, uint32_t id, uint32_t changes, int i_file)
{
    for (int k = 0; changes && k < FAKE_MAX_FILES; k++) {
        fake_file *file = &f->files[k];
        const int i = file->open ? find(file, id) : -1;
        if (i >= 0 && (k != i_file || file->events[i].flags & V4L2_EVENT_SUB_FL_ALLOW_FEEDBACK))
            file->events[i].changes |= changes;
    }
}

bool fake_has_event(const fake_file *file)
{
    for (int i = 0; i < file->n_events; i++)
        if (file->events[i].changes)
            return true;
    return false;
}

int fake_take_event(fake_v4l2 *f, fake_file *file, struct v4l2_event *e)
{
    int n = 0, first = -1;
    for (int i = 0; i < file->n_events; i++)
        if (file->events[i].changes && n++ == 0)
            first = i;
    if (first < 0)
        return ENOENT;
    const fake_control *c = fake_v4l2_control(f, file->events[first].id);
    memset(e, 0, sizeof *e);
    e->type = V4L2_EVENT_CTRL;
    e->id = c->id;
    e->pending = (uint32_t)(n - 1);
    e->sequence = file->n_told++;
    e->timestamp.tv_sec = f->now_ns / 1000000000;
    e->timestamp.tv_nsec = f->now_ns % 1000000000;
    e->u.ctrl.changes = file->events[first].changes;
    e->u.ctrl.type = c->type;
    e->u.ctrl.value = c->value;
    e->u.ctrl.flags = c->flags;
    e->u.ctrl.minimum = c->min;
    e->u.ctrl.maximum = c->max;
    e->u.ctrl.step = c->step;
    e->u.ctrl.default_value = c->fallback;
    file->events[first].changes = 0;
    return 0;
}

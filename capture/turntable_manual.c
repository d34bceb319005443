// SPDX-License-Identifier: Apache-2.0
// turntable_manual.c - manual: a table that a person turns. What it reaches is what the caller saw it reach.
#include <stdio.h>
#include <stdlib.h>

#include "capture/turntable_backend.h"

typedef struct manual {
    sheen_table_options options;
    double position_deg;
} manual;

static sheen_status manual_open(void **self_out, const char *rest, const sheen_table_options *options,
                                sheen_err *err)
{
    if (*rest)
        return sheen_fail(err, SHEEN_EARG, "nothing follows 'manual:', not '%.40s'", rest);
    if (!options->turn_by_hand)
        return sheen_fail(err, SHEEN_EUNSUP, "here nobody can be asked to turn a table by hand");
    manual *m = calloc(1, sizeof *m);
    if (!m)
        return sheen_fail_memory(err, sizeof *m, "a turntable");
    m->options = *options;
    *self_out = m;
    return SHEEN_OK;
}

static sheen_status manual_turn_to(void *self, double position_deg, sheen_err *err)
{
    manual *m = self;
    return m->options.turn_by_hand(m->options.self, position_deg - m->position_deg, &m->position_deg, err);
}

static sheen_status manual_get(void *self, sheen_table_state *out, sheen_err *err)
{
    const manual *m = self;
    (void)err;
    out->position_deg = m->position_deg;
    out->ready = true;
    snprintf(out->what, sizeof out->what, "turned by hand");
    snprintf(out->controller, sizeof out->controller, "a person");
    return SHEEN_OK;
}

static bool manual_lost_count(void *self)
{
    (void)self;
    return false;
}

const sheen_table_backend sheen_table_manual = {
    .scheme = "manual",
    .open = manual_open,
    .turn_to = manual_turn_to,
    .get = manual_get,
    .lost_count = manual_lost_count,
    .close = free,
};

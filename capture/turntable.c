// SPDX-License-Identifier: Apache-2.0
// turntable.c - chooses the kind, and keeps the angle apart from the controller's count.
//
// angle = position + offset, where the offset is known since set_angle or homing and forgotten at the first doubt.
#include "capture/turntable.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "capture/serial_devices.h"
#include "capture/turntable_backend.h"

struct sheen_table {
    const sheen_table_backend *kind;
    void *self;
    bool known;
    double offset_deg;
};

static const sheen_table_backend *const kinds[] = {&sheen_table_grbl, &sheen_table_manual};

static const sheen_table_backend *kind_of(const char *device, const char **rest)
{
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        const size_t n = strlen(kinds[i]->scheme);
        if (!strncmp(device, kinds[i]->scheme, n) && device[n] == ':') {
            *rest = device + n + 1;
            return kinds[i];
        }
    }
    *rest = device;
    return &sheen_table_grbl;
}

sheen_status sheen_table_open(sheen_table **out, const char *device, const sheen_table_options *options,
                              sheen_err *err)
{
    char found[SHEEN_SERIAL_DEVICE_PATH];
    const char *rest;
    sheen_status s = SHEEN_OK;
    *out = NULL;
    if (!strcmp(device, "auto")) {
        if ((s = sheen_serial_device_find(found, err)))
            return s;
        device = found;
    }
    sheen_table *t = calloc(1, sizeof *t);
    if (!t)
        return sheen_fail_memory(err, sizeof *t, "a turntable");
    t->kind = kind_of(device, &rest);
    if ((s = t->kind->open(&t->self, rest, options, err))) {
        free(t);
        return s;
    }
    *out = t;
    return SHEEN_OK;
}

void sheen_table_close(sheen_table **table)
{
    if (!*table)
        return;
    (*table)->kind->close((*table)->self);
    free(*table);
    *table = NULL;
}

static void note_loss(sheen_table *t)
{
    if (t->kind->lost_count(t->self))
        t->known = false;
}

sheen_status sheen_table_turn_to(sheen_table *table, double angle_deg, sheen_err *err)
{
    assert(isfinite(angle_deg));
    note_loss(table);
    if (!table->known)
        return sheen_fail(err, SHEEN_EDATA,
                          "the turntable's angle is not known: the camera must see the tags first");
    const sheen_status s = table->kind->turn_to(table->self, angle_deg - table->offset_deg, err);
    note_loss(table);
    return s;
}

sheen_status sheen_table_get(sheen_table_state *out, sheen_table *table, sheen_err *err)
{
    *out = (sheen_table_state){.angle_deg = (double)NAN, .position_deg = (double)NAN};
    const sheen_status s = table->kind->get(table->self, out, err);
    note_loss(table);
    out->angle_known = !s && table->known && isfinite(out->position_deg);
    if (out->angle_known)
        out->angle_deg = out->position_deg + table->offset_deg;
    return s;
}

sheen_status sheen_table_set_angle(sheen_table *table, double angle_deg, sheen_err *err)
{
    sheen_table_state state;
    const sheen_status s = sheen_table_get(&state, table, err);
    if (s)
        return s;
    if (!isfinite(state.position_deg))
        return sheen_fail(err, SHEEN_EDATA, "the turntable does not say where it is: %s", state.what);
    table->offset_deg = angle_deg - state.position_deg;
    table->known = true;
    return SHEEN_OK;
}

sheen_status sheen_table_unlock(sheen_table *table, sheen_err *err)
{
    if (!table->kind->unlock)
        return sheen_fail(err, SHEEN_EUNSUP, "a turntable of the kind '%s' has no lock", table->kind->scheme);
    table->known = false;
    const sheen_status s = table->kind->unlock(table->self, err);
    note_loss(table);
    return s;
}

sheen_status sheen_table_home(sheen_table *table, sheen_err *err)
{
    if (!table->kind->home)
        return sheen_fail(err, SHEEN_EUNSUP, "a turntable of the kind '%s' has no home", table->kind->scheme);
    table->known = false;
    const sheen_status s = table->kind->home(table->self, err);
    note_loss(table);
    if (s)
        return s;
    table->known = true;
    table->offset_deg = 0;
    return SHEEN_OK;
}

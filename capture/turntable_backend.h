// SPDX-License-Identifier: Apache-2.0
// turntable_backend.h - what a kind of turntable provides. To add one: fill in this struct in a file of its own and list
// it in turntable.c.
#ifndef SHEEN_CAPTURE_TURNTABLE_BACKEND_H
#define SHEEN_CAPTURE_TURNTABLE_BACKEND_H

#include "capture/turntable.h"

// Positions are degrees as the kind counts them itself, from a zero of its own; turntable.c knows which angle that is.
typedef struct sheen_table_backend {
    const char *scheme; // what stands before the colon of its devices: "grbl"
    // On success *self_out is its own state; on failure nothing stays open. `rest` may be empty.
    sheen_status (*open)(void **self_out, const char *rest, const sheen_table_options *options,
                         sheen_err *err);
    // Returns when it stands at the position, or failed, or options->go_on said no (ECANCEL, standing).
    sheen_status (*turn_to)(void *self, double position_deg, sheen_err *err);
    // Fills in position_deg, ready, what, controller.
    sheen_status (*get)(void *self, sheen_table_state *out, sheen_err *err);
    // True once after anything by which its count may have gone wrong: an alarm, a reset, a stop without brakes.
    bool (*lost_count)(void *self);
    sheen_status (*unlock)(void *self, sheen_err *err); // NULL: it has none
    sheen_status (*home)(void *self, sheen_err *err);   // NULL: it has none
    void (*close)(void *self);
} sheen_table_backend;

extern const sheen_table_backend sheen_table_grbl;   // turntable_grbl.c
extern const sheen_table_backend sheen_table_manual; // turntable_manual.c

#endif

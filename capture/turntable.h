// SPDX-License-Identifier: Apache-2.0
// turntable.h - a table that turns to an angle, and knows whether it still knows where it is.
//
//     sheen_table *table;
//     if (sheen_table_open(&table, "/dev/sheen/turntable", &options, &err)) ...
//     sheen_table_set_angle(table, 0);            // where it stands now, from the tags or by decree
//     s = sheen_table_turn_to(table, 30, &err);   // returns when it stands
//     sheen_table_close(&table);
//
// A table belongs to one thread. How to add a kind: turntable_backend.h.
#ifndef SHEEN_CAPTURE_TURNTABLE_H
#define SHEEN_CAPTURE_TURNTABLE_H

#include <stdbool.h>

#include "capture/turntable_config.h"

typedef struct sheen_table sheen_table;

typedef struct sheen_table_options {
    sheen_table_config config;
    // Asked some twenty times a second while the table turns: false stops it at once. NULL: never.
    bool (*go_on)(void *self);
    // Of `manual:`. Asks a person to turn the table by delta_deg, and says where it then stands, counted in degrees from
    // where it stood when it was opened.
    sheen_status (*turn_by_hand)(void *self, double delta_deg, double *position_deg, sheen_err *err);
    void *self;      // for both
    int greeting_ms; // longest wait for the greeting of a board that the opening reset; 0: 2500
    int patience_ms; // waited beyond the time that a move should take; 0: 5000. For an answer: half of it
    int poll_ms;     // between questions where it is; 0: 200, Grbl asks for no more than five a second
} sheen_table_options;

typedef struct sheen_table_state {
    bool angle_known;
    double angle_deg;    // NaN where it is not known
    double position_deg; // as the controller counts, NaN where it does not say
    bool ready;          // it would turn if asked
    char what[160];      // for a person: "Idle", "Alarm: a limit switch was touched"
    char controller[96]; // as it calls itself
} sheen_table_state;

// device: the path of a serial line with a Grbl controller ("grbl:" may stand before it), "auto" (the link
// /dev/sheen/turntable, else the only serial line over USB there is), or "manual:". Nothing moves. The angle is not known
// yet. ENODEV, EACCESS, ETIMEOUT (it does not answer), EARG, EDATA (several to choose from).
sheen_status sheen_table_open(sheen_table **out, const char *device, const sheen_table_options *options,
                              sheen_err *err);
void sheen_table_close(sheen_table **table);

// Turns until it stands at this angle; where it stands now must be known (EDATA). Whole turns are not left out: 370 after
// 10 is a turn. ECANCEL: go_on said no; it stands, and knows where. After any other failure it may have lost count:
// sheen_table_get says so. The sentence says what to do.
sheen_status sheen_table_turn_to(sheen_table *table, double angle_deg, sheen_err *err);
sheen_status sheen_table_get(sheen_table_state *out, sheen_table *table, sheen_err *err);
// Declares where it stands: seen by the tags, or where a count begins. ENODEV, ETIMEOUT.
sheen_status sheen_table_set_angle(sheen_table *table, double angle_deg, sheen_err *err);
// Ends an alarm where it stands; the angle is not known then. EUNSUP where the kind has no alarms.
sheen_status sheen_table_unlock(sheen_table *table, sheen_err *err);
// Runs the controller's homing, after which its own zero is angle 0. EUNSUP.
sheen_status sheen_table_home(sheen_table *table, sheen_err *err);

#endif

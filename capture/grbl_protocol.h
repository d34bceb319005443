// SPDX-License-Identifier: Apache-2.0
// grbl_protocol.h - what a Grbl 1.1 controller says, one line at a time (also grblHAL, FluidNC and Horus boards).
//
// Grbl answers each line that it is sent with exactly one `ok` or `error:N`; everything else comes when it pleases.
#ifndef SHEEN_CAPTURE_GRBL_PROTOCOL_H
#define SHEEN_CAPTURE_GRBL_PROTOCOL_H

#include <stdbool.h>
#include <stddef.h>

enum { SHEEN_GRBL_MAX_AXES = 6, SHEEN_GRBL_MAX_LINE = 256 };

// Bytes that act at once wherever they stand, and are answered by no `ok`.
#define SHEEN_GRBL_ASK "?"
#define SHEEN_GRBL_JOG_CANCEL "\x85"
#define SHEEN_GRBL_RESET "\x18"

typedef enum sheen_grbl_kind {
    SHEEN_GRBL_OK,
    SHEEN_GRBL_ERROR,    // number
    SHEEN_GRBL_ALARM,    // number
    SHEEN_GRBL_STATUS,   // state, positions
    SHEEN_GRBL_GREETING, // it was reset; text
    SHEEN_GRBL_SETTING,  // number, value: "$110=500.000"
    SHEEN_GRBL_MESSAGE,  // text, without its brackets
    SHEEN_GRBL_OTHER,    // empty, or nothing that Grbl says
} sheen_grbl_kind;

typedef enum sheen_grbl_state {
    SHEEN_GRBL_UNKNOWN, // a word of another firmware
    SHEEN_GRBL_IDLE,
    SHEEN_GRBL_RUN,
    SHEEN_GRBL_HOLD,
    SHEEN_GRBL_JOG,
    SHEEN_GRBL_ALARMED,
    SHEEN_GRBL_DOOR,
    SHEEN_GRBL_CHECK,
    SHEEN_GRBL_HOMING,
    SHEEN_GRBL_SLEEP,
} sheen_grbl_state;

typedef struct sheen_grbl_line {
    sheen_grbl_kind kind;
    int number;
    double value;
    sheen_grbl_state state;
    // Of a status report: number of axes of each, 0 where it is not there. Units are those of the machine ($13: inches).
    int n_machine, n_work, n_offset;
    double machine[SHEEN_GRBL_MAX_AXES], work[SHEEN_GRBL_MAX_AXES], offset[SHEEN_GRBL_MAX_AXES];
    char text[96];
} sheen_grbl_line;

// Reads one line, without its end. Never fails: what it cannot read is SHEEN_GRBL_OTHER.
void sheen_grbl_line_parse(sheen_grbl_line *out, const char *line, size_t length);

// "Idle", "Alarm", ...
const char *sheen_grbl_state_name(sheen_grbl_state state);
// What Grbl's numbers mean, in a few words; "" for a number that is not known.
const char *sheen_grbl_error_text(int number);
const char *sheen_grbl_alarm_text(int number);
// The place of an axis in reports and settings: X 0, Y 1, Z 2, A 3, B 4, C 5; -1 for another letter.
int sheen_grbl_axis_index(char axis);

#endif

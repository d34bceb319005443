// SPDX-License-Identifier: Apache-2.0
// grbl_link.h - the conversation with a Grbl 1.1 controller: one line, one answer; everything else noted as it comes.
#ifndef SHEEN_CAPTURE_GRBL_LINK_H
#define SHEEN_CAPTURE_GRBL_LINK_H

#include "capture/grbl_protocol.h"
#include "capture/serial_port.h"
#include "capture/turntable.h"

typedef struct sheen_grbl_link {
    sheen_serial port;
    int i_axis, poll_ms, answer_ms;
    bool lost;              // something happened by which its count may have gone wrong
    bool greeted;           // a greeting came since the last command
    int alarm;              // the last alarm's number, 0: none
    sheen_grbl_line status; // the last report
    double position_units;  // of our axis, machine coordinates, from the last report
    double offset_units;    // work coordinate offset, where it reports work positions; NaN: not told yet
    bool inches;            // it reports in inches, $13
    double max_units_min, acceleration_units_s2; // its settings of our axis; 0: not told
    char controller[96];
} sheen_grbl_link;

// Opens the line, waits for the greeting of a board that the opening reset, else makes sure that it answers; reads the
// settings and the state. ENODEV, EACCESS, ETIMEOUT (nothing there speaks Grbl), EARG (it has not this axis).
sheen_status sheen_grbl_link_open(sheen_grbl_link *l, const char *path, const sheen_table_options *options,
                                  int i_axis, sheen_err *err);
void sheen_grbl_link_close(sheen_grbl_link *l);

// Sends a line and waits for its ok. EARG (refused, nothing moved), EIO (alarm, reset), ETIMEOUT, ENODEV.
// Within answer_ms.
sheen_status sheen_grbl_command(sheen_grbl_link *l, const char *line, sheen_err *err);
sheen_status sheen_grbl_command_within(sheen_grbl_link *l, const char *line, double seconds, sheen_err *err);
sheen_status sheen_grbl_send_byte(sheen_grbl_link *l, const char *byte, sheen_err *err);
// Asks where it is: l->status, l->position_units.
sheen_status sheen_grbl_ask(sheen_grbl_link *l, sheen_err *err);
// Asks again and again until it is Idle. ETIMEOUT; ECANCEL: go_on (may be NULL) said no; EIO: alarm, reset, door.
sheen_status sheen_grbl_wait_idle(sheen_grbl_link *l, double seconds, bool (*go_on)(void *self), void *self,
                                  sheen_err *err);
// The sentence for a controller in alarm.
sheen_status sheen_grbl_alarm_failed(const sheen_grbl_link *l, sheen_err *err);

#endif

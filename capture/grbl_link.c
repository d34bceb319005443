// SPDX-License-Identifier: Apache-2.0
// grbl_link.c - Grbl's send-response protocol: a line goes out when the last one has been answered.
//
// gnea/grbl, doc/markdown/interface.md: this is the slowest of its protocols and the only one that cannot overrun the
// controller's 128 bytes or its EEPROM writes; a turntable has time.
#include "capture/grbl_link.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/clock.h"

enum { GREETING_MS = 2500, POLL_MS = 200, PATIENCE_MS = 5000, SLICE_MS = 50, OFFSET_REPORTS = 35 };

sheen_status sheen_grbl_alarm_failed(const sheen_grbl_link *l, sheen_err *err)
{
    const char *why = sheen_grbl_alarm_text(l->alarm);
    return sheen_fail(
        err, SHEEN_EIO,
        "the turntable is in alarm%s%s: its angle is not known. See that it can turn freely, then "
        "'sheen turntable --unlock' (or --home, if it has a switch) makes it ready again",
        *why ? ", " : "", why);
}

static sheen_status reset_failed(sheen_err *err)
{
    return sheen_fail(
        err, SHEEN_EIO,
        "the turntable's controller was reset (its power or its button?): its angle is not known now");
}

// Position of our axis in millimetres or degrees, whichever way the controller reports it.
static void note_position(sheen_grbl_link *l, const sheen_grbl_line *line)
{
    const int i = l->i_axis;
    const double unit = l->inches ? 25.4 : 1;
    if (line->n_offset > i)
        l->offset_units = line->offset[i] * unit;
    if (line->n_machine > i)
        l->position_units = line->machine[i] * unit;
    else if (line->n_work > i)
        l->position_units = line->work[i] * unit + l->offset_units; // NaN until the offset was told
}

// What comes unasked or is asked for by the way.
static void note(sheen_grbl_link *l, const sheen_grbl_line *line)
{
    switch (line->kind) {
    case SHEEN_GRBL_STATUS:
        l->status = *line;
        note_position(l, line);
        if (line->state == SHEEN_GRBL_ALARMED)
            l->lost = true;
        break;
    case SHEEN_GRBL_ALARM:
        l->alarm = line->number;
        l->lost = true;
        break;
    case SHEEN_GRBL_GREETING:
        snprintf(l->controller, sizeof l->controller, "%s", line->text);
        l->greeted = l->lost = true;
        break;
    case SHEEN_GRBL_SETTING:
        if (line->number == 13)
            l->inches = line->value != 0;
        else if (line->number == 110 + l->i_axis)
            l->max_units_min = line->value;
        else if (line->number == 120 + l->i_axis)
            l->acceleration_units_s2 = line->value;
        break;
    default:
        break;
    }
}

// One line, noted. ETIMEOUT.
static sheen_status next_line(sheen_grbl_link *l, sheen_grbl_line *line, int timeout_ms, sheen_err *err)
{
    const char *text;
    size_t length;
    const sheen_status s = sheen_serial_read_line(&l->port, &text, &length, timeout_ms, err);
    if (s == SHEEN_ENODEV)
        l->lost = true;
    if (s)
        return s;
    sheen_grbl_line_parse(line, text, length);
    note(l, line);
    return SHEEN_OK;
}

static sheen_status refused(const char *line, int number, sheen_err *err)
{
    const char *why = sheen_grbl_error_text(number);
    return sheen_fail(err, SHEEN_EARG, "the turntable refuses '%s' with error %d%s%s", line, number,
                      *why ? ": " : "", why);
}

sheen_status sheen_grbl_send_byte(sheen_grbl_link *l, const char *byte, sheen_err *err)
{
    return sheen_serial_write(&l->port, byte, 1, err);
}

// What came since the last answer: an `ok` among it belongs to a line that was given up, not to the next one.
static sheen_status drain(sheen_grbl_link *l, sheen_err *err)
{
    sheen_grbl_line line;
    sheen_status s = SHEEN_OK;
    l->greeted = false;
    while (!s)
        s = next_line(l, &line, 0, err);
    return s != SHEEN_ETIMEOUT ? s : l->greeted ? reset_failed(err) : SHEEN_OK;
}

sheen_status sheen_grbl_command_within(sheen_grbl_link *l, const char *line, double seconds, sheen_err *err)
{
    char text[128];
    const int n = snprintf(text, sizeof text, "%s\n", line);
    const int64_t end_ms = sheen_clock_ms() + (int64_t)(1000 * seconds);
    sheen_status s = drain(l, err);
    if (!s)
        s = sheen_serial_write(&l->port, text, (size_t)n, err);
    while (!s) {
        sheen_grbl_line answer;
        s = next_line(l, &answer, SLICE_MS, err);
        if (s == SHEEN_ETIMEOUT && sheen_clock_ms() < end_ms)
            s = SHEEN_OK;
        else if (s == SHEEN_ETIMEOUT) {
            l->lost = true; // it may or may not have been carried out
            return sheen_fail(err, s,
                              "the turntable did not answer '%s' within %.0f s: its angle is not known now",
                              line, seconds);
        } else if (s || answer.kind == SHEEN_GRBL_OK)
            return s;
        else if (answer.kind == SHEEN_GRBL_ERROR)
            return answer.number == 9 && l->alarm ? sheen_grbl_alarm_failed(l, err)
                                                  : refused(line, answer.number, err);
        else if (answer.kind == SHEEN_GRBL_ALARM)
            return sheen_grbl_alarm_failed(l, err);
        else if (answer.kind == SHEEN_GRBL_GREETING)
            return reset_failed(err);
    }
    return s;
}

sheen_status sheen_grbl_command(sheen_grbl_link *l, const char *line, sheen_err *err)
{
    return sheen_grbl_command_within(l, line, l->answer_ms / 1000.0, err);
}

sheen_status sheen_grbl_ask(sheen_grbl_link *l, sheen_err *err)
{
    const int64_t end_ms = sheen_clock_ms() + l->answer_ms;
    l->greeted = false;
    sheen_status s = sheen_grbl_send_byte(l, SHEEN_GRBL_ASK, err);
    while (!s) {
        sheen_grbl_line line;
        s = next_line(l, &line, SLICE_MS, err);
        if (s == SHEEN_ETIMEOUT && sheen_clock_ms() < end_ms)
            s = SHEEN_OK;
        else if (!s && line.kind == SHEEN_GRBL_STATUS)
            return SHEEN_OK;
        else if (!s && line.kind == SHEEN_GRBL_GREETING)
            return reset_failed(err);
    }
    if (s == SHEEN_ETIMEOUT)
        l->lost = true;
    return s;
}

// Lets what comes unasked come, for so long.
static sheen_status listen(sheen_grbl_link *l, int duration_ms, bool (*go_on)(void *self), void *self,
                           sheen_err *err)
{
    const int64_t end_ms = sheen_clock_ms() + duration_ms;
    for (;;) {
        sheen_grbl_line line;
        const int64_t left_ms = end_ms - sheen_clock_ms();
        if (go_on && !go_on(self))
            return sheen_fail(err, SHEEN_ECANCEL, "stopped");
        if (left_ms <= 0)
            return SHEEN_OK;
        const sheen_status s = next_line(l, &line, left_ms < SLICE_MS ? (int)left_ms : SLICE_MS, err);
        if (s && s != SHEEN_ETIMEOUT)
            return s;
        if (!s && line.kind == SHEEN_GRBL_ALARM)
            return sheen_grbl_alarm_failed(l, err);
        if (!s && line.kind == SHEEN_GRBL_GREETING)
            return reset_failed(err);
    }
}

sheen_status sheen_grbl_wait_idle(sheen_grbl_link *l, double seconds, bool (*go_on)(void *self), void *self,
                                  sheen_err *err)
{
    const int64_t end_ms = sheen_clock_ms() + (int64_t)(1000 * seconds);
    for (;;) {
        sheen_status s = sheen_grbl_ask(l, err);
        if (s)
            return s;
        const sheen_grbl_state state = l->status.state;
        if (state == SHEEN_GRBL_IDLE)
            return SHEEN_OK;
        if (state == SHEEN_GRBL_ALARMED)
            return sheen_grbl_alarm_failed(l, err);
        if (state == SHEEN_GRBL_DOOR || state == SHEEN_GRBL_SLEEP) {
            l->lost = true;
            return sheen_fail(err, SHEEN_EIO,
                              "the turntable stopped on the way (%s): its angle is not known now",
                              sheen_grbl_state_name(state));
        }
        if (sheen_clock_ms() >= end_ms)
            return sheen_fail(err, SHEEN_ETIMEOUT, "the turntable still moves");
        if ((s = listen(l, l->poll_ms, go_on, self, err)))
            return s;
    }
}

// The greeting of a board that was reset by the opening; one that was not says nothing. True where it came.
static sheen_status await_greeting(sheen_grbl_link *l, int timeout_ms, sheen_err *err)
{
    const int64_t end_ms = sheen_clock_ms() + timeout_ms;
    while (!l->greeted && sheen_clock_ms() < end_ms) {
        sheen_grbl_line line;
        const sheen_status s = next_line(l, &line, SLICE_MS, err);
        if (s && s != SHEEN_ETIMEOUT)
            return s;
    }
    return SHEEN_OK;
}

static sheen_status first_words(sheen_grbl_link *l, sheen_err *err)
{
    if (!l->greeted) { // an empty line is answered by ok, and ends what noise may have begun
        const sheen_status s = sheen_grbl_command(l, "", err);
        if (s == SHEEN_ETIMEOUT)
            return sheen_fail(
                err, s,
                "nothing at '%s' speaks Grbl at this rate: is it the right device, is the rate in its "
                "file right, has the board its power?",
                l->port.path);
        if (s != SHEEN_EARG && !l->greeted) // an error is an answer, too; the greeting may have been late
            return s;
    }
    // What follows a greeting: the reminder that it is locked, start-up lines.
    return l->greeted ? listen(l, SLICE_MS, NULL, NULL, err) : SHEEN_OK;
}

// Position reports may be of the work frame; the offset comes with every thirtieth or so.
static sheen_status learn_position(sheen_grbl_link *l, const sheen_table_options *options, sheen_err *err)
{
    for (int i = 0; i < OFFSET_REPORTS; i++) {
        const sheen_status s = sheen_grbl_ask(l, err);
        if (s)
            return s;
        if (l->status.n_machine <= l->i_axis && l->status.n_work <= l->i_axis)
            return sheen_fail(
                err, SHEEN_EARG, "the turntable's controller has no axis %c: it reports %d axes",
                options->config.axis, l->status.n_machine ? l->status.n_machine : l->status.n_work);
        if (isfinite(l->position_units))
            return SHEEN_OK;
    }
    return sheen_fail(
        err, SHEEN_EIO,
        "the turntable's controller does not say where it is: set $10 to 1, so that it reports machine "
        "positions");
}

sheen_status sheen_grbl_link_open(sheen_grbl_link *l, const char *path, const sheen_table_options *options,
                                  int i_axis, sheen_err *err)
{
    *l = (sheen_grbl_link){.i_axis = i_axis,
                           .poll_ms = options->poll_ms ? options->poll_ms : POLL_MS,
                           .answer_ms = (options->patience_ms ? options->patience_ms : PATIENCE_MS) / 2,
                           .lost = true,
                           .position_units = (double)NAN,
                           .offset_units = (double)NAN};
    snprintf(l->controller, sizeof l->controller, "Grbl");
    sheen_status s = sheen_serial_open(&l->port, path, options->config.baud, err);
    if (s)
        return s;
    if (!(s = await_greeting(l, options->greeting_ms ? options->greeting_ms : GREETING_MS, err)) &&
        !(s = first_words(l, err)))
        s = sheen_grbl_command(l, "$$", err);
    if (s == SHEEN_EARG) // not while it moves: then as if it had told nothing
        s = SHEEN_OK;
    if (!s)
        s = learn_position(l, options, err);
    if (s)
        sheen_grbl_link_close(l);
    return s;
}

void sheen_grbl_link_close(sheen_grbl_link *l)
{
    sheen_serial_close(&l->port);
}

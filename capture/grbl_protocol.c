// SPDX-License-Identifier: Apache-2.0
// grbl_protocol.c - reads the lines of a Grbl 1.1 controller.
//
// Grammar and numbers: gnea/grbl, doc/markdown/interface.md and doc/csv; fields of a report after the state and the
// position come in any order, and a firmware may add its own.
#include "capture/grbl_protocol.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const state_names[] = {
    [SHEEN_GRBL_UNKNOWN] = "?",   [SHEEN_GRBL_IDLE] = "Idle",   [SHEEN_GRBL_RUN] = "Run",
    [SHEEN_GRBL_HOLD] = "Hold",   [SHEEN_GRBL_JOG] = "Jog",     [SHEEN_GRBL_ALARMED] = "Alarm",
    [SHEEN_GRBL_DOOR] = "Door",   [SHEEN_GRBL_CHECK] = "Check", [SHEEN_GRBL_HOMING] = "Home",
    [SHEEN_GRBL_SLEEP] = "Sleep",
};

const char *sheen_grbl_state_name(sheen_grbl_state state)
{
    return state_names[state];
}

typedef struct meaning {
    int number;
    const char *text;
} meaning;

static const char *text_of(const meaning *table, size_t n, int number)
{
    for (size_t i = 0; i < n; i++)
        if (table[i].number == number)
            return table[i].text;
    return "";
}

const char *sheen_grbl_error_text(int number)
{
    static const meaning errors[] = {
        {1, "a letter was expected"},
        {2, "a number was expected"},
        {3, "it does not know this command"},
        {4, "a value below zero"},
        {5, "homing is not switched on, $22"},
        {8, "not while it moves"},
        {9, "locked by an alarm or a jog"},
        {10, "soft limits want homing"},
        {11, "the line is too long"},
        {12, "more steps a second than it can make"},
        {13, "its safety door is open"},
        {15,
         "the target lies outside the travel of the axis: set $20=0, or $130 and its neighbours, for an axis "
         "that turns without end"},
        {16, "it does not accept this jog: has it this axis?"},
        {20, "it does not know this command: has it this axis?"},
        {22, "no feed rate"},
    };
    return text_of(errors, sizeof errors / sizeof *errors, number);
}

const char *sheen_grbl_alarm_text(int number)
{
    static const meaning alarms[] = {
        {1, "a limit switch was touched"},        {2, "the target lies outside the travel of the axis"},
        {3, "it was reset while it moved"},       {4, "the probe was not ready"},
        {5, "the probe touched nothing"},         {6, "homing was interrupted"},
        {7, "the door was opened during homing"}, {8, "homing did not leave the switch"},
        {9, "homing did not find the switch"},    {10, "homing did not find the second switch"},
    };
    return text_of(alarms, sizeof alarms / sizeof *alarms, number);
}

int sheen_grbl_axis_index(char axis)
{
    static const char axes[] = "XYZABC";
    const char *at = axis ? strchr(axes, axis) : NULL;
    return at ? (int)(at - axes) : -1;
}

// A decimal number with nothing after it.
static bool read_number(double *out, const char *text)
{
    char *end;
    if (!*text || !strchr("+-.0123456789", *text))
        return false;
    *out = strtod(text, &end);
    return *end == '\0' && isfinite(*out);
}

static bool read_count(int *out, const char *text)
{
    double x;
    if (!read_number(&x, text) || x < 0 || x > 1e6 || x != floor(x))
        return false;
    *out = (int)x;
    return true;
}

// "1.000,-2.500,0.000" into at most SHEEN_GRBL_MAX_AXES numbers; 0 where it is not such a list.
static int read_axes(double *out, char *text)
{
    int n = 0;
    char *rest = NULL;
    for (char *part = strtok_r(text, ",", &rest); part; part = strtok_r(NULL, ",", &rest))
        if (n == SHEEN_GRBL_MAX_AXES || !read_number(&out[n++], part))
            return 0;
    return n;
}

static sheen_grbl_state read_state(char *text)
{
    text[strcspn(text, ":")] = '\0'; // "Hold:0": the number says how far the stop has come
    for (size_t i = 1; i < sizeof state_names / sizeof *state_names; i++)
        if (!strcmp(text, state_names[i]))
            return (sheen_grbl_state)i;
    return SHEEN_GRBL_UNKNOWN;
}

// "Idle|MPos:0.000,0.000,0.000|FS:0,0|WCO:..."
static void read_status(sheen_grbl_line *out, char *text)
{
    char *rest = NULL;
    char *field = strtok_r(text, "|", &rest);
    if (!field)
        return;
    out->kind = SHEEN_GRBL_STATUS;
    out->state = read_state(field);
    while ((field = strtok_r(NULL, "|", &rest)))
        if (!strncmp(field, "MPos:", 5))
            out->n_machine = read_axes(out->machine, field + 5);
        else if (!strncmp(field, "WPos:", 5))
            out->n_work = read_axes(out->work, field + 5);
        else if (!strncmp(field, "WCO:", 4))
            out->n_offset = read_axes(out->offset, field + 4);
}

static void read_setting(sheen_grbl_line *out, char *text)
{
    char *equals = strchr(text, '=');
    if (!equals)
        return;
    *equals = '\0';
    if (read_count(&out->number, text + 1) && read_number(&out->value, equals + 1))
        out->kind = SHEEN_GRBL_SETTING;
}

void sheen_grbl_line_parse(sheen_grbl_line *out, const char *line, size_t length)
{
    char text[SHEEN_GRBL_MAX_LINE];
    *out = (sheen_grbl_line){.kind = SHEEN_GRBL_OTHER};
    if (length >= sizeof text || memchr(line, '\0', length))
        return;
    memcpy(text, line, length);
    text[length] = '\0';
    snprintf(out->text, sizeof out->text, "%.*s", (int)sizeof out->text - 1, text);
    if (!strcmp(text, "ok"))
        out->kind = SHEEN_GRBL_OK;
    else if (!strncmp(text, "error:", 6) && read_count(&out->number, text + 6))
        out->kind = SHEEN_GRBL_ERROR;
    else if (!strncmp(text, "ALARM:", 6) && read_count(&out->number, text + 6))
        out->kind = SHEEN_GRBL_ALARM;
    else if (length > 2 && text[0] == '<' && text[length - 1] == '>') {
        text[length - 1] = '\0';
        read_status(out, text + 1);
    } else if (length >= 2 && text[0] == '[' && text[length - 1] == ']') {
        out->kind = SHEEN_GRBL_MESSAGE;
        snprintf(out->text, sizeof out->text, "%.*s", (int)(length - 2 < 95 ? length - 2 : 95), text + 1);
    } else if (text[0] == '$')
        read_setting(out, text);
    else if (!strncmp(text, "Grbl",
                      4)) // grblHAL and FluidNC begin with it, too: "GrblHAL 1.1f", "Grbl 3.7 [FluidNC"
        out->kind = SHEEN_GRBL_GREETING;
}

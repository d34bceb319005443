// SPDX-License-Identifier: Apache-2.0
// turntable_grbl.c - a turntable on an axis of a Grbl 1.1 controller, over a serial line that grbl_link.c looks after.
//
// A move is one jog ($J) to a place in machine coordinates, so that rounding does not add up over a turn. It is over when
// the state is Idle, a dwell (G4) has been answered, which Grbl does only once its planner is empty, and the state is
// still Idle. (Not the dwell first: while it jogs Grbl refuses every G-code with error 9.)
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "capture/grbl_link.h"
#include "capture/turntable_backend.h"

static const double still_units = 0.02; // of the place that was asked for

typedef struct grbl {
    sheen_grbl_link link;
    sheen_table_options options;
    int i_axis;
} grbl;

static double degrees_per_unit(const grbl *g)
{
    return g->options.config.degrees_per_unit * g->options.config.direction;
}

// Acceleration is a setting in the controller's lasting memory: written only where it differs.
static sheen_status set_acceleration(grbl *g, sheen_err *err)
{
    const double wanted = g->options.config.acceleration_deg_s2 / g->options.config.degrees_per_unit;
    const double has = g->link.acceleration_units_s2;
    char line[64];
    if (!(wanted > 0) || fabs(has - wanted) <= 0.005 * wanted)
        return SHEEN_OK;
    snprintf(line, sizeof line, "$%d=%.3f", 120 + g->i_axis, wanted);
    return sheen_grbl_command(&g->link, line, err);
}

static sheen_status grbl_open(void **self_out, const char *rest, const sheen_table_options *options,
                              sheen_err *err)
{
    grbl *g = calloc(1, sizeof *g);
    if (!g)
        return sheen_fail_memory(err, sizeof *g, "a turntable");
    g->options = *options;
    g->i_axis = sheen_grbl_axis_index(options->config.axis);
    sheen_status s = sheen_grbl_link_open(&g->link, rest, &g->options, g->i_axis, err);
    if (!s && g->link.status.state == SHEEN_GRBL_IDLE)
        s = set_acceleration(g, err);
    if (s) {
        sheen_grbl_link_close(&g->link);
        free(g);
        return s;
    }
    *self_out = g;
    return SHEEN_OK;
}

static sheen_status not_ready(const grbl *g, sheen_err *err)
{
    const char *name = sheen_grbl_state_name(g->link.status.state);
    switch (g->link.status.state) {
    case SHEEN_GRBL_ALARMED:
        return sheen_grbl_alarm_failed(&g->link, err);
    case SHEEN_GRBL_HOLD:
    case SHEEN_GRBL_DOOR:
        return sheen_fail(
            err, SHEEN_EIO,
            "the turntable is held (%s): close its door or press its resume button, then give the same "
            "command again",
            name);
    case SHEEN_GRBL_SLEEP:
        return sheen_fail(err, SHEEN_EIO, "the turntable sleeps, its motor is off: switch it off and on");
    default:
        return sheen_fail(err, SHEEN_EIO, "the turntable is busy (%s): another program or button turns it",
                          name);
    }
}

static double duration_s(const grbl *g, double units)
{
    const sheen_table_config *c = &g->options.config;
    double speed = c->speed_deg_s / c->degrees_per_unit;
    if (g->link.max_units_min > 0)
        speed = fmin(speed, g->link.max_units_min / 60);
    const double ramp_s = g->link.acceleration_units_s2 > 0 ? speed / g->link.acceleration_units_s2 : 0;
    return fabs(units) / speed + ramp_s;
}

// It said no: a jog cancel brakes without losing steps. Only where that does not help the controller is reset.
static sheen_status stop(grbl *g, sheen_err *err)
{
    sheen_status s = sheen_grbl_send_byte(&g->link, SHEEN_GRBL_JOG_CANCEL, err);
    if (!s)
        s = sheen_grbl_wait_idle(&g->link, g->link.answer_ms / 1000.0, NULL, NULL, err);
    if (!s)
        return sheen_fail(err, SHEEN_ECANCEL, "the turntable was stopped on the way");
    if (s != SHEEN_ETIMEOUT)
        return s;
    g->link.lost = true;
    s = sheen_grbl_send_byte(&g->link, SHEEN_GRBL_RESET, err);
    return s ? s
             : sheen_fail(err, SHEEN_ECANCEL,
                          "the turntable did not stop when told to, so its controller was reset: its angle "
                          "is not known "
                          "now. 'sheen turntable --unlock' makes it ready again");
}

static sheen_status arrive(grbl *g, double units, double seconds, sheen_err *err)
{
    const double limit_s = 1.5 * seconds + 2 * g->link.answer_ms / 1000.0;
    sheen_status s = sheen_grbl_wait_idle(&g->link, limit_s, g->options.go_on, g->options.self, err);
    if (s == SHEEN_ECANCEL)
        return stop(g, err);
    if (s == SHEEN_ETIMEOUT) {
        g->link.lost = true;
        sheen_grbl_send_byte(&g->link, SHEEN_GRBL_JOG_CANCEL, NULL);
        return sheen_fail(
            err, SHEEN_EIO,
            "the turntable did not arrive in %.0f seconds: is it blocked, or much slower than the speed in "
            "its file says? It was stopped; its angle is not known now",
            limit_s);
    }
    if (s || (s = sheen_grbl_command(&g->link, "G4 P0.01", err)) || (s = sheen_grbl_ask(&g->link, err)))
        return s;
    if (g->link.status.state != SHEEN_GRBL_IDLE)
        return not_ready(g, err);
    if (fabs(g->link.position_units - units) <= still_units)
        return SHEEN_OK;
    g->link.lost = true;
    return sheen_fail(
        err, SHEEN_EIO,
        "the turntable stopped at %.3f instead of %.3f of its units: was its stop pressed? Its angle is "
        "not known now",
        g->link.position_units, units);
}

static sheen_status jog(grbl *g, double units, sheen_err *err)
{
    const sheen_table_config *c = &g->options.config;
    char line[96];
    sheen_status s = sheen_grbl_ask(&g->link, err);
    if (s)
        return s;
    if (g->link.status.state != SHEEN_GRBL_IDLE)
        return not_ready(g, err);
    const double way = units - g->link.position_units;
    if (fabs(way) < 1e-6)
        return SHEEN_OK;
    snprintf(line, sizeof line, "$J=G53 G90 G21 %c%.4f F%.3f", c->axis, units,
             60 * c->speed_deg_s / c->degrees_per_unit);
    if ((s = sheen_grbl_command(&g->link, line, err)))
        return s;
    return arrive(g, units, duration_s(g, way), err);
}

// Always from below, so that the gear's play lies on the same side.
static sheen_status grbl_turn_to(void *self, double position_deg, sheen_err *err)
{
    grbl *g = self;
    const double play_deg = 1.5 * g->options.config.backlash_deg;
    sheen_status s = sheen_grbl_ask(&g->link, err);
    if (s)
        return s;
    if (play_deg > 0 && position_deg < degrees_per_unit(g) * g->link.position_units - 1e-6 &&
        (s = jog(g, (position_deg - play_deg) / degrees_per_unit(g), err)))
        return s;
    return jog(g, position_deg / degrees_per_unit(g), err);
}

static sheen_status grbl_get(void *self, sheen_table_state *out, sheen_err *err)
{
    grbl *g = self;
    const sheen_status s = sheen_grbl_ask(&g->link, err);
    snprintf(out->controller, sizeof out->controller, "%s", g->link.controller);
    if (s)
        return s;
    const sheen_grbl_state state = g->link.status.state;
    const char *why = state == SHEEN_GRBL_ALARMED ? sheen_grbl_alarm_text(g->link.alarm) : "";
    out->ready = state == SHEEN_GRBL_IDLE;
    out->position_deg = g->link.position_units * degrees_per_unit(g);
    snprintf(out->what, sizeof out->what, "%s%s%s", sheen_grbl_state_name(state), *why ? ": " : "", why);
    return SHEEN_OK;
}

static bool grbl_lost_count(void *self)
{
    grbl *g = self;
    const bool lost = g->link.lost;
    g->link.lost = false;
    return lost;
}

static sheen_status grbl_unlock(void *self, sheen_err *err)
{
    grbl *g = self;
    g->link.lost = true;
    sheen_status s = sheen_grbl_command(&g->link, "$X", err);
    if (!s)
        s = sheen_grbl_ask(&g->link, err);
    if (!s && g->link.status.state == SHEEN_GRBL_IDLE)
        g->link.alarm = 0;
    return s || g->link.status.state == SHEEN_GRBL_IDLE ? s : not_ready(g, err);
}

static sheen_status grbl_home(void *self, sheen_err *err)
{
    grbl *g = self;
    sheen_status s = sheen_grbl_command_within(&g->link, "$H", 120, err);
    if (s)
        return s;
    g->link.lost = false; // homing ends what went wrong before
    g->link.alarm = 0;
    return sheen_grbl_ask(&g->link, err);
}

static void grbl_close(void *self)
{
    grbl *g = self;
    sheen_grbl_link_close(&g->link);
    free(g);
}

const sheen_table_backend sheen_table_grbl = {
    .scheme = "grbl",
    .open = grbl_open,
    .turn_to = grbl_turn_to,
    .get = grbl_get,
    .lost_count = grbl_lost_count,
    .unlock = grbl_unlock,
    .home = grbl_home,
    .close = grbl_close,
};

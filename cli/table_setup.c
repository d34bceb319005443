// SPDX-License-Identifier: Apache-2.0
// table_setup.c - first how much a few degrees are, then a whole turn by least squares, then the play.
#include "cli/table_setup.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/pose3.h"
#include "cli/table_eye.h"

enum { STEPS = 12, TRIES = 8 };

static const double pi = 3.14159265358979323846;
static const double step_deg = 360.0 / STEPS, beyond_deg = 10, least_play_deg = 0.01;

// Turn that the tags see for one degree of the present file, from a move of 2 to 60 degrees.
static sheen_status coarse(double *gain, double *at_deg, sheen_table *table, const sheen_cli_setup *setup,
                           sheen_err *err)
{
    sheen_turntable_pose before, after;
    double move_deg = 5;
    sheen_status s = setup->observe(setup->self, &before, err);
    for (int i = 0; i < TRIES && !s; i++) {
        if ((s = sheen_table_turn_to(table, *at_deg + move_deg, err)) ||
            (s = setup->observe(setup->self, &after, err)))
            return s;
        *at_deg += move_deg;
        const double turn_deg = sheen_cli_eye_turn_deg(before.rt_cam_board, after.rt_cam_board);
        *gain = turn_deg / move_deg;
        if (fabs(turn_deg) >= 2 && fabs(turn_deg) <= 60)
            return SHEEN_OK;
        move_deg = fmin(360, move_deg * (fabs(turn_deg) < 2 ? 4 : 0.2));
        before = after;
    }
    return s ? s
             : sheen_fail(
                   err, SHEEN_EDATA,
                   "the board does not turn as the controller moves: is this the turntable's axis, does the "
                   "board lie on the table, does the motor hold?");
}

// Play: how far apart the table stands at one command when it came from below and from above.
static sheen_status find_play(double *play_deg, double at_deg, double gain, sheen_table *table,
                              const sheen_cli_setup *setup, sheen_err *err)
{
    sheen_turntable_pose below, above;
    sheen_status s = setup->observe(setup->self, &below, err);
    if (s || (s = sheen_table_turn_to(table, at_deg + beyond_deg / gain, err)) ||
        (s = sheen_table_turn_to(table, at_deg, err)) || (s = setup->observe(setup->self, &above, err)))
        return s;
    *play_deg = fabs(sheen_cli_eye_turn_deg(below.rt_cam_board, above.rt_cam_board));
    if (*play_deg < least_play_deg)
        *play_deg = 0;
    return SHEEN_OK;
}

static void put_axis(double axis_board[6], const sheen_turntable *t)
{
    double rt_board_table[6];
    sheen_Rt Rt;
    sheen_rt_invert(rt_board_table, t->rt_table_board);
    sheen_Rt_from_rt(&Rt, rt_board_table);
    for (int i = 0; i < 3; i++) {
        axis_board[i] = Rt.t[i];
        axis_board[3 + i] = Rt.R[i][2];
    }
}

static sheen_status solve(sheen_cli_setup_result *out, double gain,
                          const sheen_turntable_pose poses[STEPS + 1], sheen_err *err)
{
    double expected_rad[STEPS + 1];
    sheen_turntable table;
    sheen_turntable_gain line;
    for (int i = 0; i <= STEPS; i++)
        expected_rad[i] = i * step_deg * pi / 180;
    sheen_status s = sheen_turntable_solve(&table, poses, STEPS + 1, err);
    if (s)
        return s;
    s = sheen_turntable_compare(&line, &table, expected_rad, err);
    if (!s) {
        const double true_gain = gain * line.gain;
        out->config.degrees_per_unit *= fabs(true_gain);
        out->config.direction = true_gain < 0 ? -1 : 1;
        out->config.measured = true;
        out->sigma_share = line.sigma_gain / fabs(line.gain);
        out->rms_deg = line.rms_rad * 180 / pi;
        out->worst_deg = line.worst_rad * 180 / pi;
        out->sigma_axis_deg = table.sigma_axis_rad * 180 / pi;
        put_axis(out->config.axis_board, &table);
    }
    sheen_turntable_release(&table);
    return s;
}

sheen_status sheen_cli_table_setup(sheen_cli_setup_result *out, sheen_table *table,
                                   const sheen_table_config *config, const sheen_cli_setup *setup,
                                   sheen_err *err)
{
    sheen_turntable_pose poses[STEPS + 1];
    double gain = 0, at_deg = 0;
    *out = (sheen_cli_setup_result){.config = *config};
    sheen_status s = sheen_table_set_angle(table, 0, err);
    if (s || (s = coarse(&gain, &at_deg, table, setup, err)))
        return s;
    // From here on counter-clockwise only; a first stride takes up the play.
    at_deg += beyond_deg / gain;
    for (int i = 0; i <= STEPS; i++) {
        const double target_deg = at_deg + i * step_deg / gain;
        if ((s = sheen_table_turn_to(table, target_deg, err)) ||
            (s = setup->observe(setup->self, &poses[i], err)))
            return s;
    }
    s = solve(out, gain, poses, err);
    return s ? s : find_play(&out->config.backlash_deg, at_deg + 360 / gain, gain, table, setup, err);
}

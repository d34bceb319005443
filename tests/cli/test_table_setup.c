// SPDX-License-Identifier: Apache-2.0
// test_table_setup.c - the set-up finds what a simulated controller and its table keep to themselves.
#include "cli/table_eye.h"
#include "cli/table_setup.h"

#include <math.h>
#include <string.h>

#include "base/pose3.h"
#include "tests/fake/fake_grbl.h"
#include "tests/support.h"

typedef struct station {
    fake_grbl board;
    uint64_t seed;
    double tilt_rad;
} station;

// The board's pose as a camera would measure it: the axis is tilted to the board and lies beside its middle.
static sheen_status observe(void *self, sheen_turntable_pose *pose, sheen_err *err)
{
    station *s = self;
    const double angle_rad = fake_grbl_table_deg(&s->board, NULL) * 3.14159265358979323846 / 180;
    const double rt_cam_table[6] = {2.1, 0.1, 0.05, 0.01, -0.02, 0.6}, turn[6] = {0, 0, angle_rad, 0, 0, 0};
    const double rt_table_board[6] = {s->tilt_rad, 0, 0.4, 0.012, -0.007, 0.003};
    double rt[6];
    (void)err;
    sheen_rt_compose(rt, rt_cam_table, turn);
    sheen_rt_compose(pose->rt_cam_board, rt, rt_table_board);
    memset(pose->covariance, 0, sizeof pose->covariance);
    for (int i = 0; i < 6; i++) {
        const double sigma = i < 3 ? 2e-4 : 3e-5;
        pose->rt_cam_board[i] += sigma * test_random_normal(&s->seed);
        pose->covariance[7 * i] = sigma * sigma;
    }
    return SHEEN_OK;
}

static sheen_status measure(sheen_cli_setup_result *out, double true_deg_per_unit, double typed,
                            double play_deg, sheen_err *err)
{
    station s = {.seed = 11, .tilt_rad = 0.02};
    sheen_table *table;
    sheen_table_options o = {.greeting_ms = 30, .poll_ms = 3, .patience_ms = 6000};
    sheen_table_config_init(&o.config);
    o.config.degrees_per_unit = typed;
    o.config.speed_deg_s = 3000;
    fake_grbl_init(&s.board);
    s.board.true_deg_per_unit = true_deg_per_unit;
    s.board.play_deg = play_deg;
    fake_grbl_start(&s.board);
    assert_ok(sheen_table_open(&table, s.board.path, &o, err), *err);
    const sheen_cli_setup setup = {observe, &s};
    const sheen_status st = sheen_cli_table_setup(out, table, &o.config, &setup, err);
    sheen_table_close(&table);
    fake_grbl_stop(&s.board);
    return st;
}

static void measures_what_was_typed_wrong(void **state)
{
    (void)state;
    static const double cases[][3] = {{1, 1, 0}, {0.9, 1, 0.3}, {-1.8, 1, 0.5}, {7.2, 1, 0}, {0.25, 1, 0.1}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        sheen_cli_setup_result r;
        sheen_err err;
        assert_ok(measure(&r, cases[i][0], cases[i][1], cases[i][2], &err), err);
        assert_close(r.config.degrees_per_unit / fabs(cases[i][0]), 1, 0.001);
        assert_int_equal(r.config.direction, cases[i][0] < 0 ? -1 : 1);
        assert_close(r.config.backlash_deg, cases[i][2], 0.05);
        assert_close(hypot(r.config.axis_board[3], r.config.axis_board[4]), 0.02, 0.001); // the tilt
        assert_true(r.config.axis_board[5] > 0 && r.config.measured);
    }
}

static void a_motor_that_turns_nothing_is_said(void **state)
{
    (void)state;
    sheen_cli_setup_result r;
    sheen_err err;
    assert_fails(measure(&r, 1e-6, 1, 0, &err), err, SHEEN_EDATA, "does not turn as the controller moves");
}

// Poses on a tilted axis beside the board's middle, with noise; then the same with the camera touched.
static void a_camera_that_was_moved_is_noticed(void **state)
{
    (void)state;
    station s = {.seed = 5};
    const double rt_cam_table[6] = {2.1, 0.1, 0.05, 0.01, -0.02, 0.6};
    const double rt_table_board[6] = {0.03, 0, 0.4, 0.012, -0.007, 0.003};
    double rt[3][6], off_deg, shift_m;
    for (int i = 0; i < 40; i++) {
        const double deg[3] = {0, 30 + 4 * (i % 20), 15.0 * i};
        for (int k = 0; k < 3; k++) {
            const double turn[6] = {0, 0, deg[k] * 3.14159265358979323846 / 180, 0, 0, 0};
            sheen_rt_compose(rt[k], rt_cam_table, turn);
            sheen_rt_compose(rt[k], rt[k], rt_table_board);
            for (int c = 0; c < 6; c++)
                rt[k][c] += (c < 3 ? 2e-4 : 3e-5) * test_random_normal(&s.seed);
        }
        sheen_cli_eye_off_axis(&off_deg, &shift_m, rt[0], rt[1], rt[2]);
        assert_true(off_deg < 0.2);
        assert_true(shift_m < 1e-3);
        const double touched[6] = {0.6 * 3.14159265358979323846 / 180, 0, 0, 0, 0, 0},
                     pushed[6] = {0, 0, 0, 0.008, 0, 0};
        double moved[6];
        sheen_rt_compose(moved, touched, rt[2]);
        sheen_cli_eye_off_axis(&off_deg, &shift_m, rt[0], rt[1], moved);
        assert_true(off_deg > 0.5 || shift_m > 0.006);
        sheen_rt_compose(moved, pushed, rt[2]);
        sheen_cli_eye_off_axis(&off_deg, &shift_m, rt[0], rt[1], moved);
        assert_true(shift_m > 0.006);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(measures_what_was_typed_wrong),
                                       cmocka_unit_test(a_motor_that_turns_nothing_is_said),
                                       cmocka_unit_test(a_camera_that_was_moved_is_noticed)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// SPDX-License-Identifier: Apache-2.0
// test_rounds.c - one camera or several before a table that turns: found from poses and commanded angles, or refused.
#include "fit/rounds.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/pose3.h"
#include "tests/support.h"

enum { STEPS = 12, MOST = 4 * STEPS };

static const double RAD = 3.14159265358979323846 / 180;
// The table's axis is tilted to the board and lies beside its middle.
static const double rt_table_board[6] = {0.02, -0.01, 0.4, 0.013, -0.006, 0.004};
static const double cameras[3][6] = {{2.1, 0.2, -0.1, 0.02, -0.01, 0.55},
                                     {1.7, 0.1, -0.2, -0.01, 0.02, 0.6},
                                     {2.4, -0.1, 0.3, 0.01, 0.01, 0.5}};

static void put(sheen_round_frame *f, int camera, double angle_rad, uint64_t *seed, double noise)
{
    const double turn[6] = {0, 0, angle_rad, 0, 0, 0};
    sheen_rt_compose(f->rt_cam_board, cameras[camera], turn);
    sheen_rt_compose(f->rt_cam_board, f->rt_cam_board, rt_table_board);
    for (int k = 0; k < 6; k++)
        f->rt_cam_board[k] += noise * (k < 3 ? 2e-4 : 5e-5) * test_random_normal(seed);
    f->asked_rad = angle_rad + noise * 0.05 * RAD * test_random_normal(seed);
}

static size_t make(sheen_round_frame frames[MOST], int n_rounds, uint64_t seed, double noise)
{
    size_t n = 0;
    for (int r = 0; r < n_rounds; r++)
        for (int k = 0; k < STEPS; k++, n++) {
            put(&frames[n], r, 360.0 / STEPS * k * RAD, &seed, noise);
            snprintf(frames[n].name, sizeof frames[n].name, "r%d-%03d", r + 1, k);
        }
    return n;
}

// Where round r's camera truly stands in the board's frame of frame 0.
static void true_camera(double rt_world_cam[6], int r)
{
    double rt_cam_table[6], rt_world_table[6];
    memcpy(rt_cam_table, cameras[r], sizeof rt_cam_table);
    sheen_rt_invert(rt_world_table, rt_table_board);
    double rt_table_cam[6];
    sheen_rt_invert(rt_table_cam, rt_cam_table);
    sheen_rt_compose(rt_world_cam, rt_world_table, rt_table_cam);
}

static void assert_camera(const sheen_rounds *found, int r, double most_deg, double most_m)
{
    double want[6], back[6], off[6];
    true_camera(want, r);
    sheen_rt_invert(back, want);
    sheen_rt_compose(off, back, found->rt_world_cam[r]);
    assert_true(sqrt(off[0] * off[0] + off[1] * off[1] + off[2] * off[2]) < most_deg * RAD);
    assert_true(sqrt(off[3] * off[3] + off[4] * off[4] + off[5] * off[5]) < most_m);
}

static void one_camera_is_where_the_first_frame_says(void **state)
{
    (void)state;
    sheen_round_frame frames[MOST];
    sheen_rounds found;
    sheen_err err;
    double want[6];
    const size_t n = make(frames, 1, 3, 1);
    for (size_t i = 0; i < n; i++)
        frames[i].asked_rad = (double)NAN;
    assert_ok(sheen_rounds_find(&found, frames, n, 0, &err), err);
    assert_int_equal(found.n, 1);
    sheen_rt_invert(want, frames[0].rt_cam_board);
    assert_memory_equal(found.rt_world_cam[0], want, sizeof want);
    for (size_t i = 0; i < n; i++)
        assert_int_equal(frames[i].round, 0);
}

static void several_heights_are_tied_by_the_angles(void **state)
{
    (void)state;
    sheen_round_frame frames[MOST];
    sheen_rounds found;
    sheen_err err;
    for (uint64_t seed = 1; seed < 20; seed++) {
        const size_t n = make(frames, 3, seed, seed > 1);
        assert_ok(sheen_rounds_find(&found, frames, n, 0, &err), err);
        assert_int_equal(found.n, 3);
        for (size_t i = 0; i < n; i++)
            assert_int_equal(frames[i].round, i / STEPS);
        for (int r = 0; r < 3; r++)
            assert_camera(&found, r, seed > 1 ? 0.15 : 1e-6, seed > 1 ? 0.001 : 1e-9);
        assert_true(found.most_off_deg < 0.3);
    }
}

static void what_nothing_ties_is_refused(void **state)
{
    (void)state;
    sheen_round_frame frames[MOST];
    sheen_rounds found;
    sheen_err err;
    size_t n = make(frames, 2, 5, 1);
    frames[STEPS + 4].asked_rad = (double)NAN;
    assert_fails(sheen_rounds_find(&found, frames, n, 0, &err), err, SHEEN_EDATA, "no commanded angle");
    n = make(frames, 2, 5, 1);
    uint64_t seed = 9;
    for (size_t i = STEPS; i < n; i++) // turned by hand after the camera was moved; the controller counts on
        put(&frames[i], 1, (360.0 / STEPS * (double)(i - STEPS) + (i > STEPS + 5 ? 20 : 0)) * RAD, &seed, 0);
    for (size_t i = STEPS; i < n; i++)
        frames[i].asked_rad = 360.0 / STEPS * (double)(i - STEPS) * RAD;
    assert_fails(sheen_rounds_find(&found, frames, n, 0, &err), err, SHEEN_EDATA, "as it was told");
}

static void a_frame_by_a_camera_that_was_touched_is_marked(void **state)
{
    (void)state;
    sheen_round_frame frames[MOST];
    sheen_rounds found;
    sheen_err err;
    const size_t n = make(frames, 1, 7, 1);
    frames[5].rt_cam_board[0] += 0.3;
    assert_ok(sheen_rounds_find(&found, frames, n, 0, &err), err);
    assert_int_equal(found.n, 1);
    for (size_t i = 0; i < n; i++)
        assert_int_equal(frames[i].round, i == 5 ? -1 : 0);
}

// A camera in the hand before a table that turns: there is no axis, and no frame but the first is of its round.
static void both_moving_belongs_to_no_round(void **state)
{
    (void)state;
    sheen_round_frame frames[MOST];
    sheen_rounds found;
    sheen_err err;
    uint64_t seed = 13;
    const size_t n = make(frames, 1, 7, 0);
    for (size_t i = 0; i < n; i++)
        for (int k = 0; k < 6; k++)
            frames[i].rt_cam_board[k] += (k < 3 ? 0.3 : 0.05) * test_random_normal(&seed);
    if (!sheen_rounds_find(&found, frames, n, 0, &err)) {
        size_t n_out = 0;
        for (size_t i = 0; i < n; i++)
            n_out += frames[i].round < 0;
        assert_true(n_out >= n / 2);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_camera_is_where_the_first_frame_says),
        cmocka_unit_test(several_heights_are_tied_by_the_angles),
        cmocka_unit_test(what_nothing_ties_is_refused),
        cmocka_unit_test(a_frame_by_a_camera_that_was_touched_is_marked),
        cmocka_unit_test(both_moving_belongs_to_no_round),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

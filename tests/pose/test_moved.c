// SPDX-License-Identifier: Apache-2.0
// What moved: told from an axis and from the background, and not told where there is nothing to go by.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "pose/moved.h"
#include "support.h"
#include "support_board.h"

enum { N = 6, WIDTH = 320, HEIGHT = 240 };

static const double half_m[2] = {0.1, 0.08};

typedef struct scene {
    sheen_camera camera;
    sheen_moved_frame frames[N];
    sheen_image lights[N];
} scene;

// A room of random tiles, shifted by shift_px from frame to frame, with noise and changing exposure; contrast 0: a
// bare wall.
static void make(scene *s, bool turning, int shift_px, double contrast)
{
    sheen_err err;
    uint64_t seed = 3;
    assert_ok(
        sheen_camera_opencv(&s->camera, WIDTH, HEIGHT, (const double[4]){300, 300, 160, 120}, NULL, 0, &err),
        err);
    double base[6];
    test_board_look(base, (const double[2]){0, 0}, 0.6, 50, 20, 0);
    for (int i = 0; i < N; i++) {
        sheen_moved_frame *f = &s->frames[i];
        *f = (sheen_moved_frame){.asked_rad = (double)NAN, .light = &s->lights[i]};
        if (turning)
            sheen_rt_compose(f->rt_cam_board, base, (const double[6]){0, 0, 0.5 * i, 0, 0, 0});
        else
            test_board_look(f->rt_cam_board, (const double[2]){0.01 * i, 0}, 0.55 + 0.1 * test_random(&seed),
                            35 + 25 * test_random(&seed), 50 * i, 20 * test_random(&seed));
        for (size_t k = 0; k < 6; k++)
            f->covariance[7 * k] = k < 3 ? 1e-8 : 4e-10;
        assert_ok(sheen_image_init(&s->lights[i], WIDTH, HEIGHT, 1, &err), err);
        for (int y = 0; y < HEIGHT; y++)
            for (int x = 0; x < WIDTH; x++) {
                uint64_t tile = (uint64_t)((x + i * shift_px) / 5 * 1000 + y / 5 + 17);
                for (int k = 0; k < 4; k++)
                    test_random(&tile);
                *sheen_image_at(&s->lights[i], x, y) = (float)(0.4 + 0.02 * i +
                                                               contrast * (test_random(&tile) - 0.5) +
                                                               0.004 * test_random_normal(&seed));
            }
    }
}

static sheen_moved_verdict judge(scene *s)
{
    sheen_err err;
    sheen_moved_verdict v;
    assert_ok(sheen_moved_find(&v, &s->camera, half_m, 0.1, s->frames, N, &err), err);
    print_message("on axis %d, %d patches, %.2f still: %s\n", v.on_axis, v.n_patches, v.still, v.reason);
    for (int i = 0; i < N; i++)
        sheen_image_release(&s->lights[i]);
    return v;
}

static void tells_a_table_from_a_hand(void **state)
{
    (void)state;
    scene s;
    make(&s, true, 0, 0.3);
    sheen_moved_verdict v = judge(&s);
    assert_int_equal(v.moved, SHEEN_MOVED_OBJECT);
    assert_true(v.on_axis);
    make(&s, false, 23, 0.3);
    v = judge(&s);
    assert_int_equal(v.moved, SHEEN_MOVED_CAMERA);
    assert_false(v.on_axis);
    make(&s, false, 0, 0.3); // the object turned by hand before a camera that stands still
    assert_int_equal(judge(&s).moved, SHEEN_MOVED_OBJECT);
}

static void a_bare_wall_leaves_the_axis(void **state)
{
    (void)state;
    scene s;
    make(&s, true, 0, 0);
    assert_int_equal(judge(&s).moved, SHEEN_MOVED_OBJECT);
    make(&s, false, 0, 0);
    assert_int_equal(judge(&s).moved, SHEEN_MOVED_UNKNOWN);
}

// Commanded angles alone are not believed: a camera that is carried about sees the board's plane tilt.
static void a_bare_wall_leaves_the_boards_plane(void **state)
{
    (void)state;
    scene s;
    make(&s, false, 0, 0);
    for (int i = 0; i < N; i++)
        s.frames[i].asked_rad = 0.5 * i;
    assert_int_equal(judge(&s).moved, SHEEN_MOVED_BOTH);
    make(&s, true, 0, 0); // turned by hand, and shifted as it was
    for (int i = 0; i < N; i++) {
        const double shift[6] = {0, 0, 0, 0.02 * (i % 3), 0.01 * i, 0};
        double rt[6];
        sheen_rt_compose(rt, s.frames[i].rt_cam_board, shift);
        memcpy(s.frames[i].rt_cam_board, rt, sizeof rt);
        s.frames[i].asked_rad = 0.5 * i;
    }
    assert_int_equal(judge(&s).moved, SHEEN_MOVED_OBJECT);
}

static void both_are_noticed(void **state)
{
    (void)state;
    scene s;
    make(&s, false, 23, 0.3); // a table was turned, and the camera carried about
    for (int i = 0; i < N; i++)
        s.frames[i].asked_rad = 0.5 * i;
    assert_int_equal(judge(&s).moved, SHEEN_MOVED_BOTH);
    make(&s, true, 0, 0.3); // in the middle of a turn the camera was moved once and again
    sheen_image swap = s.lights[3];
    s.lights[3] = s.lights[1];
    s.lights[1] = swap;
    for (int i = 0; i < N / 2; i++)
        for (int k = 0; k < WIDTH * HEIGHT - 1000; k++)
            s.lights[2 * i].data[k] = s.lights[2 * i].data[k + (i == 1 ? 777 : 0)];
    assert_int_equal(judge(&s).moved, SHEEN_MOVED_BOTH);
}

// The camera put elsewhere between two rounds of a table is no camera that moved.
static void rounds_are_not_compared(void **state)
{
    (void)state;
    for (int told = 0; told < 2; told++) {
        scene s;
        make(&s, true, 0, 0.3);
        for (int i = 0; i < N; i++) {
            s.frames[i].asked_rad = 0.5 * i;
            s.frames[i].round = told ? 1 + i / 2 : 1;
            for (int k = 0; k < WIDTH * HEIGHT - 8000 && i >= 2; k++)
                s.lights[i].data[k] = s.lights[i].data[k + (i / 2) * 3333];
        }
        assert_int_equal(judge(&s).moved, told ? SHEEN_MOVED_OBJECT : SHEEN_MOVED_BOTH);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tells_a_table_from_a_hand),
        cmocka_unit_test(a_bare_wall_leaves_the_axis),
        cmocka_unit_test(a_bare_wall_leaves_the_boards_plane),
        cmocka_unit_test(both_are_noticed),
        cmocka_unit_test(rounds_are_not_compared),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// SPDX-License-Identifier: Apache-2.0
// test_stillness.c - motion and blur of photographs of a board whose motion and blur are known; views and their gaps.
#include "calib/stillness.h"

#include <math.h>
#include <stdlib.h>

#include "base/pose3.h"
#include "calib/detect.h"
#include "calib/view_sphere.h"
#include "tests/calib/support_board.h"
#include "tests/support.h"

enum { W = 640, H = 480 };
static const double pi = 3.14159265358979323846;

typedef struct seen {
    uint8_t *grey;
    sheen_tag_seen *tags;
    size_t n_tags;
} seen;

static void make_camera(sheen_camera *camera)
{
    static const double fxycxy[4] = {700, 700, 0.5 * (W - 1), 0.5 * (H - 1)};
    sheen_err err;
    assert_ok(sheen_camera_opencv(camera, W, H, fxycxy, NULL, 0, &err), err);
}

static void look(seen *s, const sheen_board *board, const sheen_camera *camera, double blur_px,
                 const double rt_cam_board[6])
{
    sheen_tag_detector *detector;
    sheen_err err;
    test_photo photo = {.board = board, .camera = camera, .blur_px = blur_px, .noise_dn = 1, .seed = 3};
    for (int i = 0; i < 6; i++)
        photo.rt_cam_board[i] = rt_cam_board[i];
    s->grey = test_photo_render(&photo);
    assert_ok(sheen_tag_detector_new(&detector, board->family, &err), err);
    sheen_board same = *board; // a set of one
    const sheen_board_set boards = {&same, 1};
    assert_ok(sheen_tags_detect(&s->tags, &s->n_tags, detector, s->grey, W, H, &boards, &err), err);
    sheen_tag_detector_free(&detector);
    assert_true(s->n_tags > 3);
}

static void release(seen *s)
{
    free(s->grey);
    free(s->tags);
}

// 10 % to 90 % of a Gaussian edge is 2.563 sigma; a pixel's own area has a sigma of sqrt(1/12).
static void blur_is_the_width_of_edges(void **state)
{
    (void)state;
    sheen_board board;
    sheen_camera camera;
    double rt_cam_board[6];
    const double middle[2] = {0, 0};
    make_camera(&camera);
    test_board_make(&board, 5, 4, 0.06, 0.75, 0, 0);
    test_board_look(rt_cam_board, middle, 0.3, 25, 40, 10);
    for (double sigma_px = 0.5; sigma_px < 2.2; sigma_px += 0.4) {
        seen s;
        look(&s, &board, &camera, sigma_px, rt_cam_board);
        const double want_px = 2.563 * sqrt(sigma_px * sigma_px + 1 / 12.0);
        const double got_px = sheen_tags_blur_px(s.grey, W, H, s.tags, s.n_tags);
        print_message("sigma %.1f px: edges %.2f px wide, %.2f by theory\n", sigma_px, got_px, want_px);
        assert_close(got_px, want_px, 0.12 * want_px + 0.15);
        release(&s);
    }
    sheen_board_release(&board);
    assert_true(isnan(sheen_tags_blur_px(NULL, W, H, NULL, 0)));
}

static void motion_is_that_of_the_corners(void **state)
{
    (void)state;
    sheen_board board;
    sheen_camera camera;
    double rt_cam_board[6];
    seen a, b;
    const double middle[2] = {0, 0};
    make_camera(&camera);
    test_board_make(&board, 7, 5, 0.04, 0.75, 0, 0);
    test_board_look(rt_cam_board, middle, 0.35, 0, 0, 0);
    look(&a, &board, &camera, 0.6, rt_cam_board);
    rt_cam_board[3] += 0.35 / 700 * 1.5; // to the side by one and a half pixels
    look(&b, &board, &camera, 0.6, rt_cam_board);
    assert_close(sheen_tags_motion_px(a.tags, a.n_tags, b.tags, b.n_tags), 1.5, 0.2);
    assert_close(sheen_tags_motion_px(a.tags, a.n_tags, a.tags, a.n_tags), 0, 0);
    assert_true(isnan(sheen_tags_motion_px(a.tags, a.n_tags, b.tags, 0)));
    release(&a);
    release(&b);
    sheen_board_release(&board);
}

// Where the camera stands, by its pose.
static void true_direction(double v_board[3], const double rt_cam_board[6])
{
    double rt_board_cam[6], length = 0;
    sheen_rt_invert(rt_board_cam, rt_cam_board);
    for (int j = 0; j < 3; j++)
        length += rt_board_cam[3 + j] * rt_board_cam[3 + j];
    for (int j = 0; j < 3; j++)
        v_board[j] = rt_board_cam[3 + j] / sqrt(length);
}

static void the_direction_of_view_is_found(void **state)
{
    (void)state;
    sheen_board board;
    sheen_camera camera;
    const double middle[2] = {0, 0};
    make_camera(&camera);
    test_board_make(&board, 7, 5, 0.04, 0.75, 0, 0);
    for (int azimuth = 0; azimuth < 360; azimuth += 60)
        for (int guess = 0; guess < 2; guess++) {
            double rt_cam_board[6], v[3], want[3], cosine = 0;
            seen s;
            test_board_look(rt_cam_board, middle, 0.5, 50, azimuth, 20);
            look(&s, &board, &camera, 0.6, rt_cam_board);
            assert_true(sheen_view_direction(v, guess ? NULL : &camera, W, H, s.tags, s.n_tags));
            true_direction(want, rt_cam_board);
            for (int j = 0; j < 3; j++)
                cosine += v[j] * want[j];
            assert_true(acos(fmin(1, cosine)) < (guess ? 6 : 1.5) * pi / 180);
            release(&s);
        }
    double v[3];
    assert_false(sheen_view_direction(v, &camera, W, H, NULL, 0));
    sheen_board_release(&board);
}

static void add(sheen_view_sphere *s, double azimuth_deg, double up)
{
    const double a = azimuth_deg * pi / 180, flat = sqrt(1 - up * up);
    const double v[3] = {flat * cos(a), flat * sin(a), up};
    sheen_view_sphere_add(s, v);
}

static void what_is_missing_is_told_from_where_one_began(void **state)
{
    (void)state;
    sheen_view_sphere s = {0};
    double middle;
    assert_close(sheen_view_sphere_hole_rad(&s, &middle), pi, 1e-9);
    add(&s, -90, 0.5); // in front of the page
    assert_close(sheen_view_sphere_hole_rad(&s, &middle), pi, 1e-9);
    assert_string_equal(sheen_view_side(middle), "behind");
    for (int a = -90; a <= 30; a += 15) // to the right and on to the far side
        add(&s, a, 0.5);
    // 120 degrees about the board to either side, at 30 degrees of height
    assert_close(sheen_view_sphere_hole_rad(&s, &middle), acos(0.25 + 0.75 * cos(120 * pi / 180)), 1e-9);
    assert_string_equal(sheen_view_side(middle), "behind on the left");
    add(&s, 180, 0.99); // from above: no side
    sheen_view_sphere_hole_rad(&s, &middle);
    assert_string_equal(sheen_view_side(middle), "behind on the left");
    for (int a = 45; a < 270; a += 15)
        add(&s, a, 0.4);
    assert_true(sheen_view_sphere_hole_rad(&s, &middle) < 15 * pi / 180);
    const double up[3] = {0, 0, 1};
    assert_close(sheen_view_sphere_nearest_rad(&s, up), acos(0.99), 1e-9);
    assert_string_equal(sheen_view_side(0.5 * pi), "the right");
    assert_string_equal(sheen_view_side(-0.75 * pi), "behind on the left");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blur_is_the_width_of_edges),
        cmocka_unit_test(motion_is_that_of_the_corners),
        cmocka_unit_test(the_direction_of_view_is_found),
        cmocka_unit_test(what_is_missing_is_told_from_where_one_began),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

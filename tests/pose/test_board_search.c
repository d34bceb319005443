// SPDX-License-Identifier: Apache-2.0
// Corners whose tags cannot be read are found by the pose; what only looks like one of them is not taken.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "calib/saddles.h"
#include "pose/board_pose.h"
#include "pose/board_search.h"
#include "support.h"
#include "support_board.h"

enum { WIDTH = 1280, HEIGHT = 960 };

typedef struct fixture {
    sheen_board board;
    sheen_camera camera;
    sheen_tag_detector *detector;
    test_photo photo;
    uint8_t *grey;
    sheen_board_view view;
} fixture;

static void make(fixture *f)
{
    sheen_err err;
    const double k[5] = {-0.2, 0.08, 0.0008, -0.0006, 0.01};
    *f = (fixture){0};
    assert_ok(
        sheen_camera_opencv(&f->camera, WIDTH, HEIGHT, (const double[4]){1100, 1104, 645, 474}, k, 5, &err),
        err);
    test_board_make(&f->board, 12, 9, 0.025, 0.72, 0, 0);
    assert_ok(sheen_tag_detector_new(&f->detector, "tag36h11", &err), err);
    f->photo = (test_photo){
        .board = &f->board, .camera = &f->camera, .blur_px = 0.8, .noise_dn = 2, .gamma = 2.2, .seed = 4};
    test_board_look(f->photo.rt_cam_board, (const double[2]){0.01, 0}, 0.45, 30, 60, 10);
    f->grey = test_photo_render(&f->photo);
}

static void release(fixture *f)
{
    sheen_board_view_release(&f->view);
    sheen_tag_detector_free(&f->detector);
    sheen_board_release(&f->board);
    free(f->grey);
}

static void observe(fixture *f)
{
    sheen_err err;
    assert_ok(sheen_board_observe(&f->view, f->detector, f->grey, WIDTH, HEIGHT, &f->board, &err), err);
}

static void search(fixture *f)
{
    sheen_err err;
    assert_ok(sheen_board_search(&f->view, f->grey, &f->camera, &f->board, &err), err);
}

// A disc of grey, out of focus at its rim.
static void smear(fixture *f, const double q_px[2], double radius_px)
{
    for (int y = (int)(q_px[1] - radius_px - 3); y <= (int)(q_px[1] + radius_px + 3); y++)
        for (int x = (int)(q_px[0] - radius_px - 3); x <= (int)(q_px[0] + radius_px + 3); x++) {
            if (x < 0 || y < 0 || x >= WIDTH || y >= HEIGHT)
                continue;
            const double share = fmin(1, fmax(0, radius_px - hypot(x - q_px[0], y - q_px[1])));
            uint8_t *p = &f->grey[WIDTH * y + x];
            *p = (uint8_t)lrint((1 - share) * *p + share * 150);
        }
}

// Makes the tags of the board's right half unreadable, their squares' borders and corners left alone.
static void smear_tags(fixture *f)
{
    for (size_t i = 0; i < f->board.n_tags; i++) {
        double centre[3] = {0}, q[2], corner[2];
        for (int k = 0; k < 4; k++)
            for (int c = 0; c < 3; c++)
                centre[c] += f->board.tags[i].corners_board[k][c] / 4;
        if (centre[0] < 0)
            continue;
        test_board_project(q, &f->camera, f->photo.rt_cam_board, centre);
        test_board_project(corner, &f->camera, f->photo.rt_cam_board, f->board.tags[i].corners_board[0]);
        smear(f, q, 0.5 * hypot(corner[0] - q[0], corner[1] - q[1]));
    }
}

// Distance of the view's worst corner from the truth.
static double worst_px(const fixture *f)
{
    double worst = 0;
    for (size_t i = 0; i < f->view.n_saddles; i++) {
        double q[2];
        test_board_project(q, &f->camera, f->photo.rt_cam_board, f->view.saddles[i].p_board);
        worst = fmax(worst, hypot(f->view.saddles[i].q_px[0] - q[0], f->view.saddles[i].q_px[1] - q[1]));
    }
    return worst;
}

static const sheen_saddle *saddle(const fixture *f, int row, int col)
{
    for (size_t i = 0; i < f->view.n_saddles; i++)
        if (f->view.saddles[i].row == row && f->view.saddles[i].col == col)
            return &f->view.saddles[i];
    return NULL;
}

static void corners_of_hidden_tags_are_found(void **state)
{
    (void)state;
    sheen_err err;
    fixture f;
    sheen_board_pose before, after;
    make(&f);
    smear_tags(&f);
    observe(&f);
    const size_t n_tags = f.view.n_tags, n_before = f.view.n_saddles;
    assert_ok(sheen_board_pose_find(&before, NULL, &f.camera, &f.board, &f.view, &err), err);
    search(&f);
    assert_ok(sheen_board_pose_find(&after, NULL, &f.camera, &f.board, &f.view, &err), err);
    print_message("%zu tags: %zu corners, then %zu, the worst off by %.3f px\n", n_tags, n_before,
                  f.view.n_saddles, worst_px(&f));
    assert_in_range(n_tags, 15, 40);
    assert_true(f.view.n_saddles >= n_before + 25);
    assert_true(worst_px(&f) < 0.15);
    assert_true(after.covariance[0] < before.covariance[0]);
    for (size_t i = 1; i < f.view.n_saddles; i++) { // row by row, each once
        const sheen_saddle *a = &f.view.saddles[i - 1], *b = &f.view.saddles[i];
        assert_true(a->row < b->row || (a->row == b->row && a->col < b->col));
    }
    release(&f);
}

// Where a corner is covered by something like a corner, too.
static void what_only_looks_like_a_corner_is_not_taken(void **state)
{
    (void)state;
    enum { HALF = 16 };
    static const double off_px[] = {0.7, 2, 6};
    for (size_t i = 0; i < sizeof off_px / sizeof *off_px; i++) {
        fixture f;
        double q[2];
        make(&f);
        smear_tags(&f);
        const sheen_board_corner *corner = NULL;
        for (size_t k = 0; k < f.board.n_corners; k++)
            if (f.board.corners[k].row == 4 && f.board.corners[k].col == 9)
                corner = &f.board.corners[k];
        assert_non_null(corner);
        test_board_project(q, &f.camera, f.photo.rt_cam_board, corner->p_board);
        const int x0 = (int)lrint(q[0]), y0 = (int)lrint(q[1]);
        fixture other = f; // the same board, a little aside: its corner goes over ours
        other.photo.rt_cam_board[3] += off_px[i] * f.photo.rt_cam_board[5] / 1100;
        other.grey = test_photo_render(&other.photo);
        for (int y = y0 - HALF; y <= y0 + HALF; y++)
            memcpy(&f.grey[WIDTH * y + x0 - HALF], &other.grey[WIDTH * y + x0 - HALF], 2 * HALF + 1);
        free(other.grey);
        observe(&f);
        assert_null(saddle(&f, 4, 9));
        const size_t n_before = f.view.n_saddles;
        search(&f);
        assert_null(saddle(&f, 4, 9));
        assert_true(f.view.n_saddles > n_before + 20);
        release(&f);
    }
}

static void a_grid_that_slipped_gains_nothing(void **state)
{
    (void)state;
    fixture f;
    make(&f);
    smear_tags(&f);
    observe(&f);
    const size_t n_before = f.view.n_saddles;
    for (size_t i = 0; i < n_before; i++) { // corners say one square to the right of what the tags say
        f.view.saddles[i].col++;
        f.view.saddles[i].p_board[0] += f.board.square_m;
    }
    search(&f);
    assert_int_equal(f.view.n_saddles, n_before);
    release(&f);
}

static void no_board_is_no_failure(void **state)
{
    (void)state;
    fixture f;
    make(&f);
    memset(f.grey, 120, (size_t)WIDTH * HEIGHT);
    observe(&f);
    search(&f);
    assert_int_equal(f.view.n_saddles, 0);
    release(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(corners_of_hidden_tags_are_found),
        cmocka_unit_test(what_only_looks_like_a_corner_is_not_taken),
        cmocka_unit_test(a_grid_that_slipped_gains_nothing),
        cmocka_unit_test(no_board_is_no_failure),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

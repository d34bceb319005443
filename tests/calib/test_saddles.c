// SPDX-License-Identifier: Apache-2.0
// Tags and saddles in rendered photographs of boards, against truth.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "calib/saddles.h"
#include "support.h"
#include "support_board.h"

static void camera_make(sheen_camera *camera)
{
    sheen_err err;
    const double k[8] = {-0.22, 0.09, 0.0009, -0.0007, 0.01, 0.02, -0.01, 0.004};
    assert_ok(sheen_camera_opencv(camera, 640, 480, (const double[4]){610, 606, 326, 233}, k, 8, &err), err);
}

static sheen_board_view observe(const test_photo *photo, const sheen_board *board)
{
    sheen_err err;
    sheen_tag_detector *detector;
    sheen_board_view view;
    const int width = photo->camera->width_px, height = photo->camera->height_px;
    const size_t n = (size_t)width * (size_t)height;
    uint8_t *grey = test_photo_render(photo), *copy = malloc(n);
    assert_non_null(copy);
    memcpy(copy, grey, n);
    assert_ok(sheen_tag_detector_new(&detector, board->family, &err), err);
    assert_ok(sheen_board_observe(&view, detector, grey, width, height, board, &err), err);
    sheen_tag_detector_free(&detector);
    assert_memory_equal(copy, grey, n); // the caller's picture stays as it was
    free(copy);
    free(grey);
    return view;
}

typedef struct errors {
    size_t n;
    double rms_px, max_px; // rms per axis
} errors;

static errors saddle_errors(const sheen_board_view *view, const test_photo *photo)
{
    errors e = {.n = view->n_saddles};
    for (size_t i = 0; i < view->n_saddles; i++) {
        double truth[2];
        test_board_project(truth, photo->camera, photo->rt_cam_board, view->saddles[i].p_board);
        const double distance = hypot(view->saddles[i].q_px[0] - truth[0],
                                      view->saddles[i].q_px[1] - truth[1]);
        e.rms_px += distance * distance / (2 * (double)e.n);
        e.max_px = fmax(e.max_px, distance);
    }
    e.rms_px = sqrt(e.rms_px);
    return e;
}

static void finds_corners_to_hundredths_of_a_pixel(void **state)
{
    (void)state;
    // boards and conditions: squares of 30 to 45 px in view
    static const struct {
        int cols, rows, first_id;
        double tag_ratio, distance_m, tilt_deg, blur_px, noise_dn, gamma, rms_px;
        size_t at_least;
    } cases[] = {
        {10, 7, 0, 0.64, 0.34, 0, 0.5, 2, 1, 0.04, 54},
        {9, 8, 100, 0.72, 0.36, 30, 0.7, 2, 2.2, 0.045, 56},
        {7, 5, 33, 0.60, 0.30, 45, 0.9, 3, 2.2, 0.04, 24},
        {8, 6, 0, 0.64, 0.26, 55, 0.7, 2, 2.2, 0.07, 32},
    };
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        sheen_board board;
        sheen_camera camera;
        camera_make(&camera);
        test_board_make(&board, cases[c].cols, cases[c].rows, 0.02, cases[c].tag_ratio, cases[c].first_id, 0);
        test_photo photo = {.board = &board,
                            .camera = &camera,
                            .blur_px = cases[c].blur_px,
                            .noise_dn = cases[c].noise_dn,
                            .gamma = cases[c].gamma,
                            .seed = c};
        test_board_look(photo.rt_cam_board, (const double[2]){0.003, -0.005}, cases[c].distance_m,
                        cases[c].tilt_deg, 70 * (double)c, 8);
        sheen_board_view view = observe(&photo, &board);
        const errors e = saddle_errors(&view, &photo);
        assert_in_range(e.n, cases[c].at_least, board.n_corners);
        assert_close(e.rms_px, 0, cases[c].rms_px);
        assert_close(e.max_px, 0, 0.5);
        sheen_board_view_release(&view);
        sheen_board_release(&board);
    }
}

// Corner order, the half pixel, and ids.
static void reads_tags_where_they_are(void **state)
{
    (void)state;
    sheen_board board;
    sheen_camera camera;
    camera_make(&camera);
    test_board_make(&board, 8, 6, 0.025, 0.64, 300, 0);
    test_photo photo = {.board = &board, .camera = &camera, .blur_px = 0.5, .noise_dn = 1, .seed = 1};
    test_board_look(photo.rt_cam_board, (const double[2]){0, 0}, 0.4, 25, 200, 140);
    sheen_board_view view = observe(&photo, &board);
    assert_int_equal(view.n_tags, board.n_tags);
    double mean[2] = {0};
    for (size_t i = 0; i < view.n_tags; i++) {
        assert_int_equal(view.tags[i].id, 300 + (int)i);
        for (int k = 0; k < 4; k++) {
            double truth[2];
            assert_close(view.tags[i].p_board[k][0], board.tags[i].corners_board[k][0], 0);
            test_board_project(truth, &camera, photo.rt_cam_board, view.tags[i].p_board[k]);
            for (int axis = 0; axis < 2; axis++) {
                assert_close(view.tags[i].q_px[k][axis], truth[axis], 1.0);
                mean[axis] += (view.tags[i].q_px[k][axis] - truth[axis]) / (4 * (double)view.n_tags);
            }
        }
    }
    assert_close(mean[0], 0, 0.03);
    assert_close(mean[1], 0, 0.03);
    sheen_board_view_release(&view);
    sheen_board_release(&board);
}

static void covered_corners_are_left_out(void **state)
{
    (void)state;
    sheen_board board;
    sheen_camera camera;
    camera_make(&camera);
    test_board_make(&board, 10, 7, 0.02, 0.64, 0, 0);
    test_photo photo = {
        .board = &board, .camera = &camera, .blur_px = 0.7, .noise_dn = 2, .gamma = 2.2, .seed = 2};
    photo.cover_board[0] = 0.02;
    photo.cover_radius_m = 0.05;
    test_board_look(photo.rt_cam_board, (const double[2]){0, 0}, 0.34, 20, 80, 0);
    sheen_board_view view = observe(&photo, &board);
    const errors e = saddle_errors(&view, &photo);
    assert_in_range(e.n, 20, 40);
    assert_close(e.rms_px, 0, 0.25);
    for (size_t i = 0; i < view.n_saddles; i++) {
        const double *p = view.saddles[i].p_board;
        assert_true(hypot(p[0] - photo.cover_board[0], p[1] - photo.cover_board[1]) >
                    photo.cover_radius_m - 0.001);
    }
    sheen_board_view_release(&view);
    sheen_board_release(&board);
}

// What the file says is not printed is not believed, even where the picture shows it.
static void only_printed_ones_count(void **state)
{
    (void)state;
    sheen_board board, blank;
    sheen_camera camera;
    camera_make(&camera);
    test_board_make(&board, 10, 7, 0.02, 0.64, 0, 0);
    test_board_make(&blank, 10, 7, 0.02, 0.64, 0, 0.045);
    test_photo photo = {.board = &board, .camera = &camera, .blur_px = 0.6, .seed = 3};
    test_board_look(photo.rt_cam_board, (const double[2]){0, 0}, 0.34, 10, 0, 0);
    sheen_board_view view = observe(&photo, &blank);
    assert_in_range(view.n_tags, 20, 30);
    for (size_t i = 0; i < view.n_tags; i++)
        assert_true(sheen_board_find_tag(&blank, view.tags[i].id)->printed);
    for (size_t i = 0; i < view.n_saddles; i++)
        assert_true(hypot(view.saddles[i].p_board[0], view.saddles[i].p_board[1]) > 0.045);
    assert_in_range(view.n_saddles, 20, 42);
    sheen_board_view_release(&view);
    sheen_board_release(&blank);

    test_board_make(&blank, 10, 7, 0.02, 0.64, 200, 0); // another board's ids
    view = observe(&photo, &blank);
    assert_int_equal(view.n_tags, 0);
    assert_int_equal(view.n_saddles, 0);
    sheen_board_view_release(&view);
    sheen_board_release(&blank);
    sheen_board_release(&board);
}

static void says_what_it_cannot_read(void **state)
{
    (void)state;
    sheen_err err;
    sheen_tag_detector *detector;
    sheen_tag_seen *tags;
    size_t n = 9;
    sheen_board board;
    const uint8_t pixels[16] = {0};
    assert_fails(sheen_tag_detector_new(&detector, "tag16h5", &err), err, SHEEN_EUNSUP, "'tag16h5'");
    assert_null(detector);
    test_board_make(&board, 4, 4, 0.02, 0.64, 0, 0);
    const sheen_board_set set = {.boards = &board, .n_boards = 1};
    assert_ok(sheen_tag_detector_new(&detector, "tag36h11", &err), err);
    assert_ok(sheen_tags_detect(&tags, &n, detector, pixels, 4, 4, &set, &err), err);
    assert_int_equal(n, 0);
    free(tags);
    sheen_tag_detector_free(&detector);
    sheen_tag_detector_free(&detector);
    sheen_board_release(&board);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(finds_corners_to_hundredths_of_a_pixel),
        cmocka_unit_test(reads_tags_where_they_are),
        cmocka_unit_test(covered_corners_are_left_out),
        cmocka_unit_test(only_printed_ones_count),
        cmocka_unit_test(says_what_it_cannot_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

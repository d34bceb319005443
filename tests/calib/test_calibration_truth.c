// SPDX-License-Identifier: Apache-2.0
// Photographs of boards, rendered through a known lens with tone curve, blur and noise, through detection and
// calibration, against truth. Prints its figures; docs/calibration.md quotes them.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "calib/calibrate.h"
#include "calib/saddles.h"
#include "support.h"
#include "support_board.h"

enum { FRAMES = 25, SETS = 3 };

static void camera_make(sheen_camera *camera)
{
    sheen_err err;
    const double k[8] = {-0.30, 0.10, 0.0008, -0.0006, 0.01, 0.02, -0.01, 0.003};
    assert_ok(sheen_camera_opencv(camera, 1280, 960, (const double[4]){1100, 1100, 645, 472}, k, 8, &err),
              err);
}

static sheen_board_view look(const test_photo *photo, sheen_tag_detector *detector)
{
    sheen_err err;
    sheen_board_view view;
    uint8_t *grey = test_photo_render(photo);
    assert_ok(sheen_board_observe(&view, detector, grey, photo->camera->width_px, photo->camera->height_px,
                                  photo->board, &err),
              err);
    free(grey);
    return view;
}

static void saddles_at_half_a_metre(void **state)
{
    (void)state;
    enum { POSES = 6 };
    sheen_err err;
    sheen_board board;
    sheen_camera camera;
    sheen_tag_detector *detector;
    double sum = 0;
    size_t n = 0;
    camera_make(&camera);
    test_board_make(&board, 12, 9, 0.025, 0.72, 0, 0);
    assert_ok(sheen_tag_detector_new(&detector, "tag36h11", &err), err);
    for (int i = 0; i < POSES; i++) {
        test_photo photo = {.board = &board,
                            .camera = &camera,
                            .blur_px = 0.7,
                            .gamma = 2.2,
                            .noise_dn = 2,
                            .seed = (uint64_t)i + 50};
        test_board_look(photo.rt_cam_board, (const double[2]){0.004 * i, -0.003 * i}, 0.5, 30, 61.0 * i,
                        9.0 * i);
        sheen_board_view view = look(&photo, detector);
        for (size_t k = 0; k < view.n_saddles; k++, n++) {
            double truth[2];
            test_board_project(truth, &camera, photo.rt_cam_board, view.saddles[k].p_board);
            for (int axis = 0; axis < 2; axis++)
                sum += pow(view.saddles[k].q_px[axis] - truth[axis], 2);
        }
        sheen_board_view_release(&view);
    }
    const double rms_px = sqrt(sum / (2 * (double)n));
    print_message("saddles at 0.5 m, 30 deg, gamma 2.2: %.4f px rms an axis, %zu of %d\n", rms_px, n,
                  POSES * (int)board.n_corners);
    assert_in_range(n, POSES * board.n_corners * 95 / 100, POSES * board.n_corners);
    assert_close(rms_px, 0, 0.04);
    sheen_tag_detector_free(&detector);
    sheen_board_release(&board);
}

// Where the board hangs in frame i of a session that a careful person would take: all over the image, tilted.
static void hang(test_photo *photo, const sheen_camera *camera, int i, uint64_t *seed)
{
    const double tilt_deg = i % 5 == 0 ? 8 : 18 + 28 * test_random(seed);
    const double distance_m = 0.36 + 0.16 * test_random(seed);
    double v[3];
    sheen_err err;
    // each frame's centre goes to another place of a 5 x 5 grid over the image
    const double q[2] = {(0.18 + 0.16 * (i % 5)) * camera->width_px,
                         (0.2 + 0.15 * ((double)(i / 5))) * camera->height_px};
    test_board_look(photo->rt_cam_board, (const double[2]){0, 0}, distance_m, tilt_deg,
                    360 * test_random(seed), 360 * test_random(seed));
    assert_ok(sheen_camera_unproject(camera, v, q, 1, &err), err);
    photo->rt_cam_board[3] += distance_m * v[0] / v[2];
    photo->rt_cam_board[4] += distance_m * v[1] / v[2];
}

// Difference to the truth, after the best turn and move, by rings about the image's centre (px, rms).
static void rings(double out_px[3], const sheen_camera *found, const sheen_camera *truth, double distance_m)
{
    static const double edge_px[4] = {0, 400, 600, 760};
    for (int k = 0; k < 3; k++) {
        sheen_camera_difference d;
        sheen_err err;
        assert_ok(sheen_camera_compare_ring(&d, found, truth, distance_m, edge_px[k], edge_px[k + 1], &err),
                  err);
        out_px[k] = d.moved_rms_px;
    }
}

static void calibrations_from_photographs(void **state)
{
    (void)state;
    sheen_err err;
    sheen_board board;
    sheen_camera camera;
    sheen_tag_detector *detector;
    double square = 0, worst[3] = {0};
    camera_make(&camera);
    test_board_make(&board, 12, 9, 0.025, 0.72, 0, 0);
    assert_ok(sheen_tag_detector_new(&detector, "tag36h11", &err), err);
    for (int set = 0; set < SETS; set++) {
        sheen_board_view views[FRAMES];
        sheen_calibration c;
        uint64_t seed = 1000 + (uint64_t)set;
        for (int i = 0; i < FRAMES; i++) {
            test_photo photo = {.board = &board,
                                .camera = &camera,
                                .blur_px = 0.8,
                                .gamma = 2.2,
                                .noise_dn = 3,
                                .seed = seed + 77 * (uint64_t)i};
            hang(&photo, &camera, i, &seed);
            views[i] = look(&photo, detector);
            snprintf(views[i].name, sizeof views[i].name, "f%02d", i);
        }
        const sheen_calibrate_options options = {0};
        assert_ok(sheen_calibrate(&c, &board, views, FRAMES, &options, &err), err);
        double error_px[3];
        rings(error_px, &c.camera, &camera, c.distance_m);
        print_message(
            "set %d: %d frames, %d corners, rms %.4f px; to the truth %.4f / %.4f / %.4f px (within 400, "
            "600, 760 px of the centre); halves %.2f times predicted; pattern %.2f\n",
            set, c.n_used, c.n_corners, c.rms_px, error_px[0], error_px[1], error_px[2], c.normalised_error,
            c.pattern);
        for (int k = 0; k < 3; k++)
            worst[k] = fmax(worst[k], error_px[k]);
        square += c.normalised_error * c.normalised_error / SETS;
        sheen_calibration_release(&c);
        for (int i = 0; i < FRAMES; i++)
            sheen_board_view_release(&views[i]);
    }
    print_message("normalised error of the halves, rms over the sets: %.2f\n", sqrt(square));
    assert_close(worst[0], 0, 0.02);
    assert_close(worst[1], 0, 0.05);
    assert_close(worst[2], 0, 0.15);
    assert_close(sqrt(square), 1.02, 0.23);
    sheen_tag_detector_free(&detector);
    sheen_board_release(&board);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(saddles_at_half_a_metre),
        cmocka_unit_test(calibrations_from_photographs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

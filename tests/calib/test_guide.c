// SPDX-License-Identifier: Apache-2.0
// Guidance for live calibration: is the board still and sharp, and does what it asks for help.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "calib/guide.h"
#include "calib/saddles.h"
#include "calib/steady.h"
#include "support.h"
#include "support_board.h"
#include "synthetic_views.h"

static void camera_make(sheen_camera *camera)
{
    sheen_err err;
    const double k[4] = {-0.22, 0.06, 0.0008, -0.0006};
    assert_ok(sheen_camera_opencv(camera, 800, 600, (const double[4]){760, 760, 404, 296}, k, 4, &err), err);
}

static sheen_board_view look(const test_photo *photo, double *blur_px)
{
    sheen_err err;
    sheen_board_view view;
    sheen_tag_detector *detector;
    uint8_t *grey = test_photo_render(photo);
    assert_ok(sheen_tag_detector_new(&detector, "tag36h11", &err), err);
    assert_ok(sheen_board_observe(&view, detector, grey, photo->camera->width_px, photo->camera->height_px,
                                  photo->board, &err),
              err);
    *blur_px = sheen_view_blur_px(&view, grey);
    sheen_tag_detector_free(&detector);
    free(grey);
    return view;
}

static void tells_blur_and_motion(void **state)
{
    (void)state;
    sheen_board board;
    sheen_camera camera;
    double before = 0;
    camera_make(&camera);
    test_board_make(&board, 8, 6, 0.03, 0.72, 0, 0);
    test_photo photo = {.board = &board, .camera = &camera, .noise_dn = 2, .gamma = 2.2, .seed = 9};
    test_board_look(photo.rt_cam_board, (const double[2]){0, 0}, 0.32, 25, 30, 5);
    sheen_board_view still = look(&photo, &before);
    for (int i = 1; i <= 3; i++) {
        double blur_px;
        photo.blur_px = 0.7 * i;
        photo.rt_cam_board[3] += 0.002; // 4.75 px at 0.32 m
        sheen_board_view moved = look(&photo, &blur_px);
        assert_true(blur_px > before + 0.2);
        assert_close(blur_px / photo.blur_px, 1.2, 0.25); // the pixels themselves blur, too
        assert_close(sheen_views_motion_px(&still, &moved), 4.75 * i, 0.6 * i);
        before = blur_px;
        sheen_board_view_release(&moved);
    }
    assert_close(sheen_views_motion_px(&still, &still), 0, 0);
    const sheen_board_view nothing = {0};
    assert_true(isnan(sheen_views_motion_px(&still, &nothing)));
    assert_true(isnan(sheen_view_blur_px(&nothing, NULL)));
    sheen_board_view_release(&still);
    sheen_board_release(&board);
}

// Somebody does what the words say, a little wrong, until it is enough: the lens then is as certain as promised.
static void what_it_asks_for_helps(void **state)
{
    (void)state;
    enum { MOST = 24 };
    const double accuracy_px = 0.15, flat[2] = {0, 0};
    sheen_err err;
    sheen_board board;
    sheen_camera camera;
    sheen_guidance next;
    sheen_board_view views[MOST];
    uint64_t seed = 12;
    int n = 0;
    camera_make(&camera);
    test_board_make(&board, 8, 6, 0.03, 0.72, 0, 0);
    assert_ok(sheen_guide_next(&next, &board, views, 0, accuracy_px, &err), err);
    assert_non_null(strstr(next.words, "hold the board in the middle"));
    double worst_promise = 0;
    for (; n < MOST && !next.done; n++) {
        double rt_cam_board[6];
        if (n < 6) // the middle, tilted this way and that
            test_board_look(rt_cam_board, (const double[2]){0, 0}, 0.36, n ? 32 : 5, 90.0 * n, 0);
        else
            memcpy(rt_cam_board, next.rt_cam_board, sizeof rt_cam_board);
        for (int k = 0; k < 6; k++)
            rt_cam_board[k] += (k < 3 ? 0.05 : 0.008) * (2 * test_random(&seed) - 1);
        test_view_make(&views[n], "frame", &board, &camera, rt_cam_board, 0.08, flat, &seed);
        const double expected_px = next.expected_px;
        assert_ok(sheen_guide_next(&next, &board, views, (size_t)n + 1, accuracy_px, &err), err);
        if (n >= 8)
            worst_promise = fmax(worst_promise, fabs(log(next.sigma_px / expected_px)));
    }
    assert_true(next.done);
    assert_in_range(n, SHEEN_GUIDE_MIN_FRAMES, 18);
    assert_true(worst_promise < 0.6); // what a frame brings is foreseen within a factor of 1.8

    const sheen_calibrate_options options = {0};
    sheen_calibration c;
    sheen_camera_difference d;
    assert_ok(sheen_calibrate(&c, &board, views, (size_t)n, &options, &err), err);
    assert_ok(sheen_camera_compare(&d, &c.camera, &camera, c.distance_m, &err), err);
    assert_true(d.moved_rms_px < accuracy_px);
    sheen_calibration_release(&c);
    for (int i = 0; i < n; i++)
        sheen_board_view_release(&views[i]);
    sheen_board_release(&board);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tells_blur_and_motion),
        cmocka_unit_test(what_it_asks_for_helps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// SPDX-License-Identifier: Apache-2.0
// A refined corner's covariance is that of repeated noise; its asymmetry is the noise, and tells of what intrudes.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "calib/saddle_noise.h"
#include "calib/saddle_refine.h"
#include "calib/saddles.h"
#include "support.h"
#include "support_board.h"

enum { SIDE = 48, TRIALS = 1200 };

static const double AT = 24;

// A saddle at (AT, AT), its edges skew, blurred, with noise; with an intruder, a dark corner at lower right.
static void draw(uint8_t grey[SIDE * SIDE], double noise_dn, bool intruder, uint64_t *seed)
{
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
            const double dx = x - AT, dy = y - AT;
            const double u = 0.95 * dx + 0.3 * dy, v = -0.1 * dx + 0.75 * dy;
            double code = 128 + 80 * tanh(u / 1.1) * tanh(v / 1.1);
            if (intruder && dx + dy > 8)
                code = 100;
            grey[SIDE * y + x] = (uint8_t)lrint(
                fmax(0, fmin(255, code + noise_dn * test_random_normal(seed))));
        }
}

static void covariance_is_that_of_repeated_noise(void **state)
{
    (void)state;
    sheen_err err;
    uint8_t grey[SIDE * SIDE];
    uint64_t seed = 4;
    static const int halves[] = {3, 5, 8};
    for (int h = 0; h < 3; h++) {
        const double noise_dn = 3;
        double sum[2] = {0}, squares[3] = {0}, said[3], asymmetry, alone[2] = {AT, AT};
        for (int i = 0; i < TRIALS; i++) {
            double q[2] = {AT + 0.3, AT - 0.2};
            draw(grey, noise_dn, false, &seed);
            assert_ok(sheen_saddle_refine(q, grey, SIDE, SIDE, halves[h], &err), err);
            sum[0] += (q[0] - AT) / TRIALS;
            sum[1] += (q[1] - AT) / TRIALS;
            squares[0] += (q[0] - AT) * (q[0] - AT) / TRIALS;
            squares[1] += (q[0] - AT) * (q[1] - AT) / TRIALS;
            squares[2] += (q[1] - AT) * (q[1] - AT) / TRIALS;
        }
        draw(grey, 0, false, &seed);
        assert_true(sheen_saddle_noise(said, &asymmetry, grey, SIDE, SIDE, alone, halves[h]));
        const double variance = noise_dn * noise_dn + 1 / 12.0; // with the rounding's
        const double xx = squares[0] - sum[0] * sum[0], xy = squares[1] - sum[0] * sum[1],
                     yy = squares[2] - sum[1] * sum[1];
        print_message("half %d: %.4f %.4f px, said %.4f %.4f; correlation %.2f, said %.2f\n", halves[h],
                      sqrt(xx), sqrt(yy), sqrt(variance * said[0]), sqrt(variance * said[2]),
                      xy / sqrt(xx * yy), said[1] / sqrt(said[0] * said[2]));
        assert_close(sqrt(variance * said[0] / xx), 1, 0.12);
        assert_close(sqrt(variance * said[2] / yy), 1, 0.12);
        assert_close(said[1] / sqrt(said[0] * said[2]), xy / sqrt(xx * yy), 0.12);
    }
}

static void asymmetry_is_noise_or_an_intruder(void **state)
{
    (void)state;
    uint8_t grey[SIDE * SIDE];
    uint64_t seed = 5;
    double covariance[3], asymmetry;
    const double q[2] = {AT, AT};
    draw(grey, 4, false, &seed);
    assert_true(sheen_saddle_noise(covariance, &asymmetry, grey, SIDE, SIDE, q, 7));
    assert_close(asymmetry, 4, 0.6);
    draw(grey, 4, true, &seed);
    assert_true(sheen_saddle_noise(covariance, &asymmetry, grey, SIDE, SIDE, q, 7));
    assert_true(asymmetry > 12);

    // what cannot be looked at
    const double edge[2] = {5, 24};
    assert_false(sheen_saddle_noise(covariance, &asymmetry, grey, SIDE, SIDE, edge, 7));
    assert_false(sheen_saddle_noise(covariance, &asymmetry, grey, SIDE, SIDE, q, 0));
    assert_false(
        sheen_saddle_noise(covariance, &asymmetry, grey, SIDE, SIDE, q, SHEEN_SADDLE_MAX_HALF_PX + 1));
    memset(grey, 90, sizeof grey);
    assert_false(sheen_saddle_noise(covariance, &asymmetry, grey, SIDE, SIDE, q, 7));
    assert_close(covariance[0], 0, 0);
}

// Beside an object's outline corners are right or left out.
static void a_covered_board_has_no_dragged_corners(void **state)
{
    (void)state;
    sheen_err err;
    sheen_board board;
    sheen_camera camera;
    sheen_tag_detector *detector;
    test_board_make(&board, 12, 9, 0.025, 0.72, 0, 0);
    assert_ok(sheen_camera_opencv(&camera, 1280, 960, (const double[4]){1100, 1102, 645, 474}, NULL, 0, &err),
              err);
    assert_ok(sheen_tag_detector_new(&detector, "tag36h11", &err), err);
    double worst_px = 0;
    size_t n = 0;
    for (int i = 0; i < 3; i++) {
        sheen_board_view view;
        test_photo photo = {.board = &board,
                            .camera = &camera,
                            .blur_px = 0.8,
                            .noise_dn = 3,
                            .gamma = 2.2,
                            .cover_board = {0.02 * i - 0.02, 0.01},
                            .cover_radius_m = 0.095,
                            .seed = (uint64_t)(i + 1)};
        test_board_look(photo.rt_cam_board, (const double[2]){0, 0}, 0.5, 25 + 12 * i, 40 + 110 * i, 20 * i);
        uint8_t *grey = test_photo_render(&photo);
        assert_ok(sheen_board_observe(&view, detector, grey, 1280, 960, &board, &err), err);
        for (size_t k = 0; k < view.n_saddles; k++) {
            double q[2];
            test_board_project(q, &camera, photo.rt_cam_board, view.saddles[k].p_board);
            worst_px = fmax(worst_px, hypot(view.saddles[k].q_px[0] - q[0], view.saddles[k].q_px[1] - q[1]));
        }
        n += view.n_saddles;
        sheen_board_view_release(&view);
        free(grey);
    }
    print_message("%zu corners, the worst off by %.3f px\n", n, worst_px);
    assert_true(n > 100);
    assert_true(worst_px < 0.2);
    sheen_tag_detector_free(&detector);
    sheen_board_release(&board);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(covariance_is_that_of_repeated_noise),
        cmocka_unit_test(asymmetry_is_noise_or_an_intruder),
        cmocka_unit_test(a_covered_board_has_no_dragged_corners),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

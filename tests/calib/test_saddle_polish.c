// SPDX-License-Identifier: Apache-2.0
// A polished corner is where it is whatever its place between the pixels; its covariance is that of repeated noise; its
// asymmetry is the noise, and tells of what intrudes.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "calib/saddle_polish.h"
#include "calib/saddle_refine.h"
#include "calib/saddles.h"
#include "support.h"
#include "support_board.h"

enum { SIDE = 48, TRIALS = 1200 };

static const double AT = 24;

// A saddle at (at_x, at_y), its edges skew, as soft as blur_px says, with noise; with an intruder, another grey at lower
// right.
typedef struct drawing {
    double at_x, at_y, blur_px, noise_dn, turn_rad;
    bool intruder;
} drawing;

static void draw(uint8_t grey[SIDE * SIDE], const drawing *d, uint64_t *seed)
{
    const double c = cos(d->turn_rad), s = sin(d->turn_rad), soft = sqrt(2.0) * d->blur_px;
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
            const double dx = c * (x - d->at_x) + s * (y - d->at_y),
                         dy = c * (y - d->at_y) - s * (x - d->at_x);
            const double u = (0.95 * dx + 0.3 * dy) / hypot(0.95, 0.3);
            const double v = (-0.1 * dx + 0.75 * dy) / hypot(0.1, 0.75);
            double code = 128 + 80 * erf(u / soft) * erf(v / soft);
            if (d->intruder && dx + dy > 9)
                code = 150;
            grey[SIDE * y + x] = (uint8_t)lrint(
                fmax(0, fmin(255, code + d->noise_dn * test_random_normal(seed))));
        }
}

// Mean errors by the corner's place between the pixels, over all other places and directions of the edges.
static void corners_are_not_drawn_between_the_pixels(void **state)
{
    (void)state;
    enum { PHASES = 8, TURNS = 5, REPEATS = 8, N = PHASES * TURNS * REPEATS };
    static const double blurs_px[] = {0.6, 0.8, 1.5};
    sheen_err err;
    uint8_t grey[SIDE * SIDE];
    uint64_t seed = 3;
    for (size_t b = 0; b < 3; b++) {
        double rough[2][PHASES] = {{0}}, fine[2][PHASES] = {{0}}, rough_px = 0, fine_px = 0;
        for (int i = 0; i < PHASES * N; i++) {
            const int phase[2] = {i % PHASES, i / PHASES % PHASES};
            const drawing d = {.at_x = AT + phase[0] / (double)PHASES,
                               .at_y = AT + phase[1] / (double)PHASES,
                               .blur_px = blurs_px[b],
                               .noise_dn = 0.5, // against the rounding's own pattern
                               .turn_rad = i / (PHASES * PHASES * REPEATS) * 0.4};
            const double at[2] = {d.at_x, d.at_y};
            sheen_saddle_polished polished;
            double q[2] = {AT + 0.5, AT + 0.4};
            draw(grey, &d, &seed);
            assert_ok(sheen_saddle_refine(q, grey, SIDE, SIDE, 6, &err), err);
            assert_true(sheen_saddle_polish(&polished, grey, SIDE, SIDE, q, 6));
            for (int k = 0; k < 2; k++) {
                rough[k][phase[k]] += (q[k] - at[k]) / N;
                fine[k][phase[k]] += (polished.q_px[k] - at[k]) / N;
            }
        }
        for (int i = 0; i < 2 * PHASES; i++) {
            rough_px = fmax(rough_px, fabs(rough[i / PHASES][i % PHASES]));
            fine_px = fmax(fine_px, fabs(fine[i / PHASES][i % PHASES]));
        }
        print_message("blur %.1f px: off by %.4f px at most, unpolished %.4f\n", blurs_px[b], fine_px,
                      rough_px);
        assert_true(fine_px < 0.35 * rough_px);
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
        const drawing noisy = {AT, AT, 0.9, noise_dn, 0, false}, clean = {AT, AT, 0.9, 0, 0, false};
        double sum[2] = {0}, squares[3] = {0};
        const double alone[2] = {AT, AT};
        sheen_saddle_polished one;
        for (int i = 0; i < TRIALS; i++) {
            double q[2] = {AT + 0.3, AT - 0.2};
            draw(grey, &noisy, &seed);
            assert_ok(sheen_saddle_refine(q, grey, SIDE, SIDE, halves[h], &err), err);
            assert_true(sheen_saddle_polish(&one, grey, SIDE, SIDE, q, halves[h]));
            memcpy(q, one.q_px, sizeof q);
            sum[0] += (q[0] - AT) / TRIALS;
            sum[1] += (q[1] - AT) / TRIALS;
            squares[0] += (q[0] - AT) * (q[0] - AT) / TRIALS;
            squares[1] += (q[0] - AT) * (q[1] - AT) / TRIALS;
            squares[2] += (q[1] - AT) * (q[1] - AT) / TRIALS;
        }
        draw(grey, &clean, &seed);
        assert_true(sheen_saddle_polish(&one, grey, SIDE, SIDE, alone, halves[h]));
        const double *said = one.covariance;
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
    sheen_err err;
    uint8_t grey[SIDE * SIDE];
    uint64_t seed = 5;
    sheen_saddle_polished one;
    drawing d = {.at_x = AT + 0.3, .at_y = AT - 0.4, .blur_px = 0.9, .noise_dn = 4};
    const double q[2] = {d.at_x, d.at_y};
    draw(grey, &d, &seed);
    assert_true(sheen_saddle_polish(&one, grey, SIDE, SIDE, q, 7));
    assert_close(one.asymmetry, 4, 0.6); // whatever the place between the pixels
    assert_in_range((int)one.n_pairs, 60, 17 * 17 / 2);
    d.intruder = true; // and the corner where the refinement then puts it
    double dragged[2] = {q[0], q[1]};
    draw(grey, &d, &seed);
    assert_ok(sheen_saddle_refine(dragged, grey, SIDE, SIDE, 7, &err), err);
    print_message("dragged by %.2f, %.2f px\n", dragged[0] - q[0], dragged[1] - q[1]);
    assert_true(sheen_saddle_polish(&one, grey, SIDE, SIDE, dragged, 7));
    assert_true(one.asymmetry > 12);

    // what cannot be looked at
    const double edge[2] = {5, 24};
    assert_false(sheen_saddle_polish(&one, grey, SIDE, SIDE, edge, 7));
    assert_false(sheen_saddle_polish(&one, grey, SIDE, SIDE, q, 0));
    assert_false(sheen_saddle_polish(&one, grey, SIDE, SIDE, q, SHEEN_SADDLE_MAX_HALF_PX + 1));
    memset(grey, 90, sizeof grey);
    assert_false(sheen_saddle_polish(&one, grey, SIDE, SIDE, q, 7));
    assert_close(one.covariance[0], 0, 0);
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
        cmocka_unit_test(corners_are_not_drawn_between_the_pixels),
        cmocka_unit_test(covariance_is_that_of_repeated_noise),
        cmocka_unit_test(asymmetry_is_noise_or_an_intruder),
        cmocka_unit_test(a_covered_board_has_no_dragged_corners),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

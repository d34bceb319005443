// SPDX-License-Identifier: Apache-2.0
// Vignetting that is known comes back from the board's white, as certain as said; where the frames do not show it, it is
// said why.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "calib/saddles.h"
#include "calib/vignetting.h"
#include "support.h"
#include "support_board.h"
#include "synthetic_views.h"

enum { FRAMES = 14 };

static const double flat[2] = {0, 0};

typedef struct fixture {
    sheen_board board;
    sheen_camera camera;
    sheen_board_view views[FRAMES];
    const sheen_board_view *list[FRAMES];
} fixture;

// A quarter of the light is missing at rho = 1.
static double true_log_light(const fixture *f, const double q_px[2])
{
    const double half_px = hypot(f->camera.width_px, f->camera.height_px) / 2;
    const double rho = hypot(q_px[0] - f->camera.intrinsics[2], q_px[1] - f->camera.intrinsics[3]) / half_px;
    return -0.18 * rho * rho - 0.11 * rho * rho * rho * rho;
}

static void make(fixture *f, double distance_m)
{
    sheen_err err;
    uint64_t seed = 9;
    const double k[5] = {-0.2, 0.08, 0.0008, -0.0006, 0.01};
    assert_ok(sheen_camera_opencv(&f->camera, 640, 480, (const double[4]){560, 562, 326, 236}, k, 5, &err),
              err);
    test_board_make(&f->board, 11, 8, 0.025, 0.7, 0, 0);
    for (int i = 0; i < FRAMES; i++) {
        double rt[6];
        test_calibration_pose(rt, i, distance_m);
        test_view_make(&f->views[i], "frame", &f->board, &f->camera, rt, 0.05, flat, &seed);
        f->views[i].transfer = SHEEN_TRANSFER_SRGB;
        f->list[i] = &f->views[i];
    }
}

// Codes of the white: exposure and slope of each frame its own; curved: light that bends over the board.
static void light(fixture *f, double exposure, double curved, double noise_dn)
{
    uint64_t seed = 3;
    for (int i = 0; i < FRAMES; i++) {
        const double level = exposure * (0.8 + 0.4 * test_random(&seed)), bend = test_random_normal(&seed);
        const double slope[2] = {test_random_normal(&seed), test_random_normal(&seed)};
        for (size_t c = 0; c < f->views[i].n_saddles; c++) {
            sheen_saddle *s = &f->views[i].saddles[c];
            const double x = s->p_board[0], y = s->p_board[1];
            const double l = level * exp(slope[0] * x + slope[1] * y + true_log_light(f, s->q_px) +
                                         curved * bend * (x * x + y * y));
            const double code = 255 * (double)sheen_transfer_encode(SHEEN_TRANSFER_SRGB, (float)fmin(1, l));
            s->white_dn = rint(code + noise_dn * test_random_normal(&seed));
        }
    }
}

static void release(fixture *f)
{
    for (int i = 0; i < FRAMES; i++)
        sheen_board_view_release(&f->views[i]);
    sheen_board_release(&f->board);
}

static void measure(sheen_vignetting *v, const fixture *f, size_t n)
{
    sheen_err err;
    assert_ok(sheen_vignetting_measure(v, &f->camera, f->list, n, &err), err);
}

static double truth_at(const fixture *f, double rho)
{
    const double half_px = hypot(f->camera.width_px, f->camera.height_px) / 2;
    const double q[2] = {f->camera.intrinsics[2] + rho * half_px, f->camera.intrinsics[3]};
    return exp(true_log_light(f, q));
}

static void known_vignetting_comes_back(void **state)
{
    (void)state;
    fixture f;
    sheen_vignetting v;
    make(&f, 0.3);
    light(&f, 0.5, 0, 1.5);
    measure(&v, &f, FRAMES);
    print_message("light at %.2f: %.4f +- %.4f, truth %.4f\n", v.reach, v.light, v.sigma,
                  truth_at(&f, v.reach));
    assert_true(v.measured);
    assert_int_equal(v.n_frames, FRAMES);
    assert_true(v.reach > 0.8);
    assert_close(v.light, truth_at(&f, v.reach), fmin(0.012, 3.5 * v.sigma));
    const double half = exp(v.k[0] * 0.25 + v.k[1] * 0.0625);
    assert_close(half, truth_at(&f, 0.5), 0.006);

    light(&f, 0.5, 3, 1.5); // lamps close by: less certain, and said so
    sheen_vignetting uneven;
    measure(&uneven, &f, FRAMES);
    assert_true(uneven.sigma > 2 * v.sigma);
    assert_close(uneven.light, truth_at(&f, v.reach), 4 * uneven.sigma);
    release(&f);
}

static void frames_that_do_not_show_it_are_said(void **state)
{
    (void)state;
    fixture f;
    sheen_vignetting v;
    make(&f, 0.3);
    measure(&v, &f, FRAMES); // corners without pictures
    assert_false(v.measured);
    assert_non_null(strstr(v.reason, "0 frames"));
    light(&f, 3, 0, 1); // overexposed
    measure(&v, &f, FRAMES);
    assert_false(v.measured);
    light(&f, 0.5, 0, 1);
    measure(&v, &f, 4);
    assert_false(v.measured);
    assert_non_null(strstr(v.reason, "4 frames"));
    light(&f, 0.5, 30, 1);
    measure(&v, &f, FRAMES);
    assert_false(v.measured);
    assert_non_null(strstr(v.reason, "uneven"));
    release(&f);

    make(&f, 0.3); // in the middle only
    for (int i = 0; i < FRAMES; i++)
        f.views[i].n_saddles = 0;
    light(&f, 0.5, 0, 1);
    for (int i = 0; i < FRAMES; i++) {
        uint64_t seed = (uint64_t)i + 1;
        double rt[6];
        sheen_board_view_release(&f.views[i]);
        test_board_look(rt, (const double[2]){0, 0}, 1.1, 30, 40.0 * i, 0);
        test_view_make(&f.views[i], "far", &f.board, &f.camera, rt, 0.05, flat, &seed);
    }
    light(&f, 0.5, 0, 1);
    measure(&v, &f, FRAMES);
    assert_false(v.measured);
    assert_non_null(strstr(v.reason, "corners"));
    release(&f);
}

// From photographs: the codes of rendered ones darkened as the lens would have.
static void photographs_show_it(void **state)
{
    (void)state;
    enum { PHOTOS = 8 };
    sheen_err err;
    fixture f;
    sheen_tag_detector *detector;
    sheen_vignetting v;
    make(&f, 0.3);
    assert_ok(sheen_tag_detector_new(&detector, "tag36h11", &err), err);
    for (int i = 0; i < PHOTOS; i++) {
        test_photo photo = {.board = &f.board,
                            .camera = &f.camera,
                            .blur_px = 0.7,
                            .noise_dn = 1.5,
                            .gamma = 2.2,
                            .seed = (uint64_t)i + 1};
        test_calibration_pose(photo.rt_cam_board, i, 0.3);
        uint8_t *grey = test_photo_render(&photo);
        for (int k = 0; k < 640 * 480; k++)
            grey[k] = (uint8_t)lrint(grey[k] *
                                     exp(true_log_light(&f, (const double[2]){k % 640, k / 640}) / 2.2));
        sheen_board_view_release(&f.views[i]);
        assert_ok(sheen_board_observe(&f.views[i], detector, grey, 640, 480, &f.board, &err), err);
        f.views[i].transfer = SHEEN_TRANSFER_GAMMA22;
        free(grey);
    }
    measure(&v, &f, PHOTOS);
    print_message("photographs: light at %.2f: %.4f +- %.4f, truth %.4f %s\n", v.reach, v.light, v.sigma,
                  truth_at(&f, v.reach), v.reason);
    assert_true(v.measured);
    assert_close(v.light, truth_at(&f, v.reach), 0.02);
    sheen_tag_detector_free(&detector);
    release(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_vignetting_comes_back),
        cmocka_unit_test(frames_that_do_not_show_it_are_said),
        cmocka_unit_test(photographs_show_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

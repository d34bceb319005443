// SPDX-License-Identifier: Apache-2.0
// Several boards about an object: places and poses with honest covariances, a board that was moved, one that nothing
// ties.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "pose/board_survey.h"
#include "pose/pose_tangent.h"
#include "support.h"
#include "support_board.h"
#include "synthetic_views.h"

enum { BOARDS = 3, FRAMES = 8 };

static const double DEG = 3.14159265358979323846 / 180;
// three sheets about an object, two of them leaning
static const double rt_ref_board[BOARDS][6] = {
    {0, 0, 0, 0, 0, 0}, {0.5, 0, 0.1, 0.02, 0.21, 0.05}, {0, -0.6, 0.3, 0.26, 0.02, 0.06}};

typedef struct fixture {
    sheen_camera camera;
    sheen_board boards[BOARDS];
    sheen_board_set set;
    sheen_board_view views[FRAMES * BOARDS];
    double rt_cam_ref[FRAMES][6];
} fixture;

static void make(fixture *f, double sigma_px, uint64_t *seed)
{
    sheen_err err;
    const double k[4] = {-0.15, 0.05, 0.0005, -0.0004};
    assert_ok(sheen_camera_opencv(&f->camera, 1280, 960, (const double[4]){1100, 1100, 640, 480}, k, 4, &err),
              err);
    for (int b = 0; b < BOARDS; b++)
        test_board_make(&f->boards[b], 8, 6, 0.022, 0.7, 30 * b, 0);
    f->set = (sheen_board_set){f->boards, BOARDS};
    for (int i = 0; i < FRAMES; i++) {
        test_board_look(f->rt_cam_ref[i], (const double[2]){0.1, 0.08}, 0.62, 20 + 25 * test_random(seed),
                        45.0 * i, 20 * test_random(seed));
        for (int b = 0; b < BOARDS; b++) {
            double rt[6];
            sheen_rt_compose(rt, f->rt_cam_ref[i], rt_ref_board[b]);
            test_view_make(&f->views[i * BOARDS + b], "f", &f->boards[b], &f->camera, rt, sigma_px,
                           (const double[2]){0, 0}, seed);
        }
    }
}

static void release(fixture *f)
{
    for (int i = 0; i < FRAMES * BOARDS; i++)
        sheen_board_view_release(&f->views[i]);
    for (int b = 0; b < BOARDS; b++)
        sheen_board_release(&f->boards[b]);
}

static double squared_error(const double got[6], const double want[6], const double covariance[36])
{
    sheen_Rt a, b;
    double wd[6], P[36];
    sheen_Rt_from_rt(&a, got);
    sheen_Rt_from_rt(&b, want);
    sheen_pose_difference(wd, &a, &b);
    assert_true(sheen_pose_information(P, got, covariance));
    return sheen_pose_product(wd, P, wd) / 6;
}

static void places_and_poses_with_honest_covariances(void **state)
{
    (void)state;
    enum { TRIALS = 12 };
    sheen_err err;
    uint64_t seed = 4;
    double chi2_boards = 0, chi2_frames = 0, worst_m = 0;
    for (int trial = 0; trial < TRIALS; trial++) {
        fixture f;
        sheen_survey s;
        make(&f, 0.05, &seed);
        assert_ok(sheen_survey_solve(&s, &f.camera, &f.set, f.views, FRAMES, &err), err);
        assert_close(s.rms_px, 0.05, 0.005);
        for (int b = 1; b < BOARDS; b++) {
            assert_true(s.boards[b].found);
            assert_int_equal(s.boards[b].n_moved, 0);
            chi2_boards += squared_error(s.boards[b].rt_ref_board, rt_ref_board[b], s.boards[b].covariance);
            for (int k = 3; k < 6; k++)
                worst_m = fmax(worst_m, fabs(s.boards[b].rt_ref_board[k] - rt_ref_board[b][k]));
        }
        for (int i = 0; i < FRAMES; i++) {
            assert_true(s.frames[i].found);
            assert_int_equal(s.frames[i].n_boards, BOARDS);
            chi2_frames += squared_error(s.frames[i].rt_cam_ref, f.rt_cam_ref[i], s.frames[i].covariance);
        }
        sheen_survey_release(&s);
        release(&f);
    }
    chi2_boards /= TRIALS * (BOARDS - 1);
    chi2_frames /= TRIALS * FRAMES;
    print_message("boards within %.3f mm; squared errors over variances: boards %.2f, frames %.2f\n",
                  1e3 * worst_m, chi2_boards, chi2_frames);
    assert_close(worst_m, 0, 1e-4);
    assert_close(chi2_boards, 1, 0.4);
    assert_close(chi2_frames, 1, 0.25);
}

static void notices_a_board_that_moved(void **state)
{
    (void)state;
    sheen_err err;
    fixture f;
    sheen_survey s;
    uint64_t seed = 9;
    // far, and by little
    const double by_m[2] = {0.03, 0.004};
    for (int far = 0; far < 2; far++) {
        make(&f, 0.05, &seed);
        for (int i = FRAMES - 3; i < FRAMES; i++) {
            double rt[6], moved[6];
            memcpy(moved, rt_ref_board[2], sizeof moved);
            moved[3] += by_m[far];
            sheen_board_view_release(&f.views[i * BOARDS + 2]);
            sheen_rt_compose(rt, f.rt_cam_ref[i], moved);
            test_view_make(&f.views[i * BOARDS + 2], "f", &f.boards[2], &f.camera, rt, 0.05,
                           (const double[2]){0, 0}, &seed);
        }
        assert_ok(sheen_survey_solve(&s, &f.camera, &f.set, f.views, FRAMES, &err), err);
        print_message("moved by %.1f mm: %d of %d frames without it, %s\n", 1e3 * by_m[far],
                      s.boards[2].n_moved, FRAMES, s.boards[2].reason);
        assert_int_equal(s.boards[2].n_moved, 3);
        assert_int_equal(s.boards[2].n_frames, FRAMES - 3);
        assert_int_equal(s.boards[1].n_moved, 0);
        assert_close(s.boards[2].moved_m, by_m[far], 3e-4);
        assert_non_null(strstr(s.boards[2].reason, "was moved"));
        assert_non_null(strstr(s.frames[FRAMES - 1].reason, "left out"));
        for (int k = 0; k < 6; k++)
            assert_close(s.boards[2].rt_ref_board[k], rt_ref_board[2][k], 2e-4);
        sheen_survey_release(&s);
        release(&f);
    }
}

static void says_what_nothing_ties(void **state)
{
    (void)state;
    sheen_err err;
    fixture f;
    sheen_survey s;
    uint64_t seed = 2;
    make(&f, 0.05, &seed);
    for (int i = 0; i < FRAMES; i++) // the third is seen alone, or not at all
        for (int b = 0; b < BOARDS; b++)
            if ((i == 0) == (b != 2))
                f.views[i * BOARDS + b].n_saddles = f.views[i * BOARDS + b].n_tags = 0;
    assert_ok(sheen_survey_solve(&s, &f.camera, &f.set, f.views, FRAMES, &err), err);
    assert_false(s.boards[2].found);
    assert_non_null(strstr(s.boards[2].reason, "no frame shows it together"));
    assert_false(s.frames[0].found);
    assert_true(s.frames[1].found);
    assert_close(sheen_rt_angle_rad(s.frames[1].rt_cam_ref, f.rt_cam_ref[1]), 0, 0.05 * DEG);
    sheen_survey_release(&s);
    for (int i = 0; i < FRAMES * BOARDS; i++)
        f.views[i].n_saddles = f.views[i].n_tags = 0;
    assert_fails(sheen_survey_solve(&s, &f.camera, &f.set, f.views, FRAMES, &err), err, SHEEN_EDATA,
                 "none of 8 frames");
    release(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(places_and_poses_with_honest_covariances),
        cmocka_unit_test(notices_a_board_that_moved),
        cmocka_unit_test(says_what_nothing_ties),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

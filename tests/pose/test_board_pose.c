// SPDX-License-Identifier: Apache-2.0
// One frame's pose: in rendered photographs with half the board covered, with outliers, and where it must refuse.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "calib/saddles.h"
#include "pose/board_pose.h"
#include "support.h"
#include "support_board.h"
#include "synthetic_views.h"

static const double flat[2] = {0, 0};

static void camera_make(sheen_camera *camera)
{
    sheen_err err;
    const double k[5] = {-0.2, 0.08, 0.0008, -0.0006, 0.01};
    assert_ok(sheen_camera_opencv(camera, 800, 600, (const double[4]){760, 764, 409, 293}, k, 5, &err), err);
}

// Distance between the poses of the board's centre, millimetres, and angle, degrees.
static void differ(double *mm, double *deg, const double a[6], const double b[6])
{
    *mm = 1e3 *
          sqrt((a[3] - b[3]) * (a[3] - b[3]) + (a[4] - b[4]) * (a[4] - b[4]) + (a[5] - b[5]) * (a[5] - b[5]));
    *deg = 57.29577951308232 * sheen_rt_angle_rad(a, b);
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void half_the_board_is_enough(void **state)
{
    (void)state;
    enum { POSES = 12 };
    sheen_err err;
    sheen_board board;
    sheen_camera camera;
    sheen_tag_detector *detector;
    double mm[POSES], deg[POSES];
    uint64_t seed = 31;
    camera_make(&camera);
    test_board_make(&board, 11, 8, 0.026, 0.66, 20, 0);
    assert_ok(sheen_tag_detector_new(&detector, "tag36h11", &err), err);
    for (int i = 0; i < POSES; i++) {
        test_photo photo = {
            .board = &board, .camera = &camera, .blur_px = 0.8, .noise_dn = 2, .gamma = 2.2, .seed = seed};
        photo.cover_board[0] = 0.03 * (test_random(&seed) - 0.5);
        photo.cover_radius_m = 0.095; // half of the board's 0.286 x 0.208 m
        test_board_look(photo.rt_cam_board, flat, 0.36, 50 * test_random(&seed), 360 * test_random(&seed),
                        360 * test_random(&seed));
        uint8_t *grey = test_photo_render(&photo);
        sheen_board_view view;
        sheen_board_pose pose;
        assert_ok(sheen_board_observe(&view, detector, grey, 800, 600, &board, &err), err);
        bool *is_inlier = calloc(view.n_saddles + 1, sizeof *is_inlier);
        assert_ok(sheen_board_pose_find(&pose, is_inlier, &camera, &board, &view, &err), err);
        int n_inliers = 0;
        for (size_t k = 0; k < view.n_saddles; k++)
            n_inliers += is_inlier[k];
        assert_int_equal(n_inliers, pose.n_points);
        assert_int_equal(pose.n_points + pose.n_outliers, (int)view.n_saddles);
        assert_false(pose.from_tags);
        differ(&mm[i], &deg[i], pose.rt_cam_board, photo.rt_cam_board);
        // the error is what the covariance promises, give or take
        for (int k = 3; k < 6; k++)
            assert_close(pose.rt_cam_board[k], photo.rt_cam_board[k],
                         6 * sqrt(pose.covariance[7 * k]) + 1e-5);
        free(is_inlier);
        sheen_board_view_release(&view);
        free(grey);
    }
    sheen_tag_detector_free(&detector);
    sheen_board_release(&board);
    qsort(mm, POSES, sizeof *mm, ascending);
    qsort(deg, POSES, sizeof *deg, ascending);
    print_message("half covered: median %.4f mm, %.4f deg; worst %.4f mm, %.4f deg\n", mm[POSES / 2],
                  deg[POSES / 2], mm[POSES - 1], deg[POSES - 1]);
    assert_close(mm[POSES / 2], 0, 0.05);
    assert_close(deg[POSES / 2], 0, 0.03);
    assert_close(mm[POSES - 1], 0, 0.3);
    assert_close(deg[POSES - 1], 0, 0.2);
}

typedef struct fixture {
    sheen_board board;
    sheen_camera camera;
    double rt[6];
    sheen_board_view view;
} fixture;

static void make(fixture *f, double sigma_px)
{
    uint64_t seed = 8;
    camera_make(&f->camera);
    test_board_make(&f->board, 9, 7, 0.03, 0.64, 0, 0);
    test_board_look(f->rt, flat, 0.42, 35, 70, 15);
    test_view_make(&f->view, "photo", &f->board, &f->camera, f->rt, sigma_px, flat, &seed);
}

static void release(fixture *f)
{
    sheen_board_view_release(&f->view);
    sheen_board_release(&f->board);
}

static void outliers_are_left_out(void **state)
{
    (void)state;
    sheen_err err;
    fixture f;
    sheen_board_pose pose;
    bool is_inlier[64];
    double mm, deg;
    make(&f, 0.03);
    uint64_t seed = 17;
    for (size_t k = 0; k < f.view.n_saddles; k += 5) { // a fifth of them, up to 6 px off
        f.view.saddles[k].q_px[0] += 2 + 4 * test_random(&seed);
        f.view.saddles[k].q_px[1] -= 2 * test_random(&seed);
    }
    assert_ok(sheen_board_pose_find(&pose, is_inlier, &f.camera, &f.board, &f.view, &err), err);
    for (size_t k = 0; k < f.view.n_saddles; k += 5)
        assert_false(is_inlier[k]);
    differ(&mm, &deg, pose.rt_cam_board, f.rt);
    assert_close(mm, 0, 0.05);
    assert_close(deg, 0, 0.03);
    assert_close(pose.rms_px, 0.03, 0.01);
    assert_in_range(pose.n_outliers, 9, 13);
    release(&f);
}

static void tags_step_in_where_saddles_are_few(void **state)
{
    (void)state;
    sheen_err err;
    fixture f;
    sheen_board_pose pose;
    double mm, deg;
    make(&f, 0.03);
    f.view.n_saddles = 4;
    assert_ok(sheen_board_pose_find(&pose, NULL, &f.camera, &f.board, &f.view, &err), err);
    assert_true(pose.from_tags);
    differ(&mm, &deg, pose.rt_cam_board, f.rt);
    assert_close(mm, 0, 0.1);
    assert_close(deg, 0, 0.05);
    assert_true(pose.covariance[35] > 1e-9); // and is not claimed to be as good as saddles
    f.view.n_tags = 1;                       // one tag alone fits two poses
    assert_fails(sheen_board_pose_find(&pose, NULL, &f.camera, &f.board, &f.view, &err), err, SHEEN_EDATA,
                 "only 1 tag and 4 corners of the board in view");
    release(&f);
}

static void refuses_what_is_not_to_be_believed(void **state)
{
    (void)state;
    sheen_err err;
    fixture f;
    sheen_board_pose pose;
    make(&f, 0.03);
    sheen_board_view view = f.view;

    view.n_tags = view.n_saddles = 0;
    assert_fails(sheen_board_pose_find(&pose, NULL, &f.camera, &f.board, &view, &err), err, SHEEN_EDATA,
                 "no tag of the board in view");
    view = f.view;
    view.n_saddles = 8; // one row of the board
    assert_fails(sheen_board_pose_find(&pose, NULL, &f.camera, &f.board, &view, &err), err, SHEEN_EDATA,
                 "the points in view do not determine a pose");
    view.n_saddles = 10; // and two corners of the next
    assert_fails(sheen_board_pose_find(&pose, NULL, &f.camera, &f.board, &view, &err), err, SHEEN_EDATA,
                 "lie in a strip");

    // another camera: half the focal length, strong distortion
    sheen_camera other;
    const double k[4] = {0.9, 0.5, 0, 0};
    assert_ok(sheen_camera_opencv(&other, 800, 600, (const double[4]){380, 382, 400, 300}, k, 4, &err), err);
    assert_fails(sheen_board_pose_find(&pose, NULL, &other, &f.board, &f.view, &err), err, SHEEN_EDATA,
                 "do not fit the camera");

    // a grid that slipped by one square: the saddles agree with each other but not with the tags
    for (size_t i = 0; i < f.view.n_saddles; i++)
        f.view.saddles[i].p_board[0] += f.board.square_m;
    assert_fails(sheen_board_pose_find(&pose, NULL, &f.camera, &f.board, &f.view, &err), err, SHEEN_EDATA,
                 "corners and tags contradict each other");
    f.view.saddles[3].q_px[1] = (double)NAN;
    assert_fails(sheen_board_pose_find(&pose, NULL, &f.camera, &f.board, &f.view, &err), err, SHEEN_EDATA,
                 "not a finite number");
    release(&f);
}

// A small board from afar: mirrored about the line of sight it fits nearly as well.
static void an_ambiguous_pose_is_none(void **state)
{
    (void)state;
    sheen_err err;
    fixture f;
    sheen_board_pose pose;
    uint64_t seed = 6;
    make(&f, 0.03);
    sheen_board_view_release(&f.view);
    double rt[6];
    test_board_look(rt, flat, 4.0, 30, 70, 15);
    test_view_make(&f.view, "far", &f.board, &f.camera, rt, 0.3, flat, &seed);
    assert_fails(sheen_board_pose_find(&pose, NULL, &f.camera, &f.board, &f.view, &err), err, SHEEN_EDATA,
                 "fit two poses equally well");
    release(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(half_the_board_is_enough),
        cmocka_unit_test(outliers_are_left_out),
        cmocka_unit_test(tags_step_in_where_saddles_are_few),
        cmocka_unit_test(refuses_what_is_not_to_be_believed),
        cmocka_unit_test(an_ambiguous_pose_is_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

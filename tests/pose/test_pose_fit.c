// SPDX-License-Identifier: Apache-2.0
// The least-squares pose: exact without noise, from afar, and with the covariance that repeated noise shows.
#include <math.h>
#include <string.h>

#include "base/pose3.h"
#include "pose/pose_fit.h"
#include "support.h"
#include "support_board.h"

static void camera_make(sheen_camera *camera)
{
    sheen_err err;
    const double k[8] = {-0.25, 0.1, 0.001, -0.0008, 0.01, 0.02, -0.01, 0.004};
    assert_ok(sheen_camera_opencv(camera, 1280, 960, (const double[4]){1080, 1083, 630, 490}, k, 8, &err),
              err);
}

enum { N = 40 };

static void points_make(sheen_pose_points *points, const sheen_camera *camera, const double rt[6])
{
    sheen_err err;
    uint64_t seed = 9;
    assert_ok(sheen_pose_points_init(points, N, &err), err);
    for (size_t i = 0; i < N; i++) {
        points->p_board[3 * i] = 0.24 * test_random(&seed) - 0.12;
        points->p_board[3 * i + 1] = 0.18 * test_random(&seed) - 0.09;
        test_board_project(points->q_px + 2 * i, camera, rt, points->p_board + 3 * i);
        points->use[i] = true;
    }
}

static void is_exact_without_noise(void **state)
{
    (void)state;
    sheen_err err;
    sheen_camera camera;
    uint64_t seed = 12;
    camera_make(&camera);
    for (int i = 0; i < 40; i++) {
        double rt[6], found[6], rms_px, errors[N];
        sheen_pose_points points;
        test_board_look(rt, (const double[2]){0.02, -0.01}, 0.3 + 0.4 * test_random(&seed),
                        65 * test_random(&seed), 360 * test_random(&seed), 360 * test_random(&seed));
        points_make(&points, &camera, rt);
        assert_ok(sheen_pose_seed(found, &camera, &points, &err), err);
        assert_close(sheen_rt_angle_rad(found, rt), 0, 1e-3);
        assert_ok(sheen_pose_refine(found, &rms_px, &camera, &points, &err), err);
        assert_close(rms_px, 0, 1e-6);
        assert_close(sheen_rt_angle_rad(found, rt), 0, 1e-8);
        for (int k = 3; k < 6; k++)
            assert_close(found[k], rt[k], 1e-8);
        assert_ok(sheen_pose_errors(errors, found, &camera, &points, &err), err);
        for (int k = 0; k < N; k++)
            assert_close(errors[k], 0, 1e-5);
        // and from a start that is well off
        for (int k = 0; k < 6; k++)
            found[k] = rt[k] + (k < 3 ? 0.15 : 0.03) * (test_random(&seed) - 0.5);
        assert_ok(sheen_pose_refine(found, &rms_px, &camera, &points, &err), err);
        assert_close(sheen_rt_angle_rad(found, rt), 0, 1e-7);
        sheen_pose_points_release(&points);
    }
}

static void covariance_is_that_of_repeated_noise(void **state)
{
    (void)state;
    enum { REPEATS = 600 };
    sheen_err err;
    sheen_camera camera;
    sheen_pose_points points;
    double rt[6], covariance[36], sampled[36] = {0}, q[2 * N];
    uint64_t seed = 2;
    camera_make(&camera);
    test_board_look(rt, (const double[2]){0.01, 0.02}, 0.5, 40, 30, 100);
    points_make(&points, &camera, rt);
    memcpy(q, points.q_px, sizeof q);
    assert_ok(sheen_pose_covariance(covariance, rt, 0.2, &camera, &points, &err), err);
    for (int r = 0; r < REPEATS; r++) {
        double found[6], rms_px;
        for (int k = 0; k < 2 * N; k++)
            points.q_px[k] = q[k] + 0.2 * test_random_normal(&seed);
        memcpy(found, rt, sizeof found);
        assert_ok(sheen_pose_refine(found, &rms_px, &camera, &points, &err), err);
        for (int u = 0; u < 6; u++)
            for (int v = 0; v < 6; v++)
                sampled[6 * u + v] += (found[u] - rt[u]) * (found[v] - rt[v]) / REPEATS;
    }
    for (int u = 0; u < 6; u++)
        for (int v = 0; v < 6; v++) {
            const double scale = sqrt(covariance[7 * u] * covariance[7 * v]);
            assert_close(sampled[6 * u + v] / scale, covariance[6 * u + v] / scale, 0.2);
        }
    sheen_pose_points_release(&points);
}

static void says_what_does_not_determine_a_pose(void **state)
{
    (void)state;
    sheen_err err;
    sheen_camera camera;
    sheen_pose_points points;
    double rt[6], found[6], covariance[36], rms_px;
    camera_make(&camera);
    test_board_look(rt, (const double[2]){0, 0}, 0.5, 20, 30, 100);
    points_make(&points, &camera, rt);
    for (size_t i = 3; i < N; i++)
        points.use[i] = false;
    assert_fails(sheen_pose_seed(found, &camera, &points, &err), err, SHEEN_EDATA, "do not determine");
    points.use[2] = false;
    memcpy(found, rt, sizeof found);
    assert_fails(sheen_pose_refine(found, &rms_px, &camera, &points, &err), err, SHEEN_EDATA,
                 "do not determine");
    assert_fails(sheen_pose_covariance(covariance, rt, 0.2, &camera, &points, &err), err, SHEEN_EDATA,
                 "do not determine");
    for (size_t i = 0; i < N; i++)
        points.use[i] = true;
    found[5] = -0.5; // behind the camera
    assert_fails(sheen_pose_refine(found, &rms_px, &camera, &points, &err), err, SHEEN_EDATA,
                 "do not determine");
    sheen_pose_points_release(&points);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(is_exact_without_noise),
        cmocka_unit_test(covariance_is_that_of_repeated_noise),
        cmocka_unit_test(says_what_does_not_determine_a_pose),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// SPDX-License-Identifier: Apache-2.0
// Homographies and the small linear solver beneath them.
#include <math.h>
#include <string.h>

#include "calib/cholesky.h"
#include "calib/homography.h"
#include "support.h"

static void solves_and_inverts(void **state)
{
    (void)state;
    enum { N = 6 };
    uint64_t seed = 3;
    double M[N * N], A[N * N] = {0}, L[N * N], x[N], b[N] = {0}, inverse[N * N];
    for (int i = 0; i < N * N; i++)
        M[i] = test_random_normal(&seed);
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++)
            for (int k = 0; k < N; k++)
                A[N * i + j] += M[N * i + k] * M[N * j + k];
    for (int i = 0; i < N; i++)
        x[i] = i - 2.5;
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++)
            b[i] += A[N * i + j] * x[j];
    memcpy(L, A, sizeof L);
    assert_true(sheen_cholesky(L, N));
    sheen_cholesky_solve(b, L, N);
    sheen_cholesky_invert(inverse, L, N);
    for (int i = 0; i < N; i++) {
        assert_close(b[i], x[i], 1e-9);
        for (int j = 0; j < N; j++) {
            double product = 0;
            for (int k = 0; k < N; k++)
                product += inverse[N * i + k] * A[N * k + j];
            assert_close(product, i == j, 1e-9);
        }
    }
}

static void refuses_what_is_not_positive_definite(void **state)
{
    (void)state;
    double negative[4] = {1, 0, 2, 1}, dependent[4] = {1, 0, 3, 9}, bad[4] = {(double)NAN, 0, 0, 1};
    assert_false(sheen_cholesky(negative, 2));
    assert_false(sheen_cholesky(dependent, 2));
    assert_false(sheen_cholesky(bad, 2));
}

// Points of a plane at a known pose, as (x/z, y/z).
static void look(double *xy, double *q, size_t n, const sheen_Rt *Rt)
{
    uint64_t seed = 7;
    for (size_t i = 0; i < n; i++) {
        double p[3] = {0.3 * test_random(&seed) - 0.1, 0.2 * test_random(&seed), 0};
        memcpy(xy + 2 * i, p, 2 * sizeof *xy);
        sheen_Rt_point(p, Rt, p);
        q[2 * i] = p[0] / p[2];
        q[2 * i + 1] = p[1] / p[2];
    }
}

static void recovers_a_pose(void **state)
{
    (void)state;
    const double rt[6] = {2.1, -0.7, 0.4, 0.03, -0.02, 0.6};
    double xy[24], q[24], H[9], found[6], out[2];
    sheen_Rt Rt;
    sheen_Rt_from_rt(&Rt, rt);
    look(xy, q, 12, &Rt);
    assert_true(sheen_homography_fit(H, xy, q, 12));
    assert_true(sheen_homography_apply(out, H, xy + 4));
    assert_close(out[0], q[4], 1e-12);
    assert_close(out[1], q[5], 1e-12);
    assert_true(sheen_homography_pose(&Rt, H, xy));
    sheen_rt_from_Rt(found, &Rt);
    for (int i = 0; i < 6; i++)
        assert_close(found[i], rt[i], 1e-9);
    // the same from a homography of the other sign, as long as a point in front is named
    for (int i = 0; i < 9; i++)
        H[i] *= -1;
    assert_true(sheen_homography_pose(&Rt, H, xy));
    sheen_rt_from_Rt(found, &Rt);
    assert_close(found[5], rt[5], 1e-9);
}

static void refuses_points_that_do_not_determine_one(void **state)
{
    (void)state;
    double xy[16], q[16], H[9];
    for (int i = 0; i < 8; i++) {
        xy[2 * i] = q[2 * i] = i;
        xy[2 * i + 1] = q[2 * i + 1] = 2 * i + 1; // on a line
    }
    assert_false(sheen_homography_fit(H, xy, q, 8));
    assert_false(sheen_homography_fit(H, xy, q, 3));
    memset(xy, 0, sizeof xy);
    assert_false(sheen_homography_fit(H, xy, q, 8));
    const double square[8] = {0, 0, 1, 0, 1, 1, 0, 1};
    double bad[8] = {0, 0, 1, 0, (double)NAN, 1, 0, 1}, out[2];
    assert_false(sheen_homography_fit(H, square, bad, 4));
    const double behind[9] = {1, 0, 0, 0, 1, 0, 0, 0, -1};
    assert_false(sheen_homography_apply(out, behind, square));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(solves_and_inverts),
        cmocka_unit_test(refuses_what_is_not_positive_definite),
        cmocka_unit_test(recovers_a_pose),
        cmocka_unit_test(refuses_points_that_do_not_determine_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

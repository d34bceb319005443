// SPDX-License-Identifier: Apache-2.0
// test_pose3.c - rotations and poses by hand, round trips near every awkward angle.
#include <math.h>

#include "base/pose3.h"
#include "base/vec.h"
#include "support.h"

static const double pi = 3.14159265358979323846;

static void quarter_turn_about_z_takes_x_to_y(void **state)
{
    (void)state;
    const double rt[6] = {0, 0, pi / 2, 1, 2, 3};
    const double p[3] = {1, 0, 0};
    double out[3];
    sheen_Rt m;
    sheen_Rt_from_rt(&m, rt);
    sheen_Rt_point(out, &m, p);
    assert_close(out[0], 1, 1e-15);
    assert_close(out[1], 3, 1e-15);
    assert_close(out[2], 3, 1e-15);
    sheen_Rt_direction(out, &m, p);
    assert_close(out[1], 1, 1e-15);
    assert_close(out[2], 0, 1e-15);
}

static void round_trip_at_every_angle(void **state)
{
    (void)state;
    static const double angles[] = {0, 1e-12, 1e-8, 1e-5, 1e-4,      1e-3,     0.1,
                                    1, 2,     3,    3.14, pi - 1e-6, pi - 1e-9};
    uint64_t seed = 1;
    for (size_t i = 0; i < sizeof angles / sizeof *angles; i++)
        for (int k = 0; k < 50; k++) {
            double axis[3] = {test_random_normal(&seed), test_random_normal(&seed),
                              test_random_normal(&seed)};
            sheen_normalize(axis);
            double rt[6] = {0, 0, 0, 0.1, -5, 7}, back[6];
            for (int c = 0; c < 3; c++)
                rt[c] = axis[c] * angles[i];
            sheen_Rt m;
            sheen_Rt_from_rt(&m, rt);
            for (int r = 0; r < 3; r++)
                assert_close(sheen_norm(m.R[r]), 1, 1e-14);
            sheen_rt_from_Rt(back, &m);
            for (int c = 0; c < 6; c++)
                assert_close(back[c], rt[c], 1e-7 * (angles[i] > 3 ? 1 : 1e-6));
        }
}

static void composition_and_inverse_are_those_of_points(void **state)
{
    (void)state;
    uint64_t seed = 2;
    for (int k = 0; k < 200; k++) {
        double ab[6], bc[6], ac[6], ba[6], p_c[3], p_b[3], p_a[3], q_a[3], q_b[3];
        for (int i = 0; i < 6; i++) {
            ab[i] = test_random_normal(&seed);
            bc[i] = test_random_normal(&seed);
        }
        for (int i = 0; i < 3; i++)
            p_c[i] = test_random_normal(&seed);
        sheen_Rt m_ab, m_bc, m_ac, m_ba;
        sheen_Rt_from_rt(&m_ab, ab);
        sheen_Rt_from_rt(&m_bc, bc);
        sheen_rt_compose(ac, ab, bc);
        sheen_rt_invert(ba, ab);
        sheen_Rt_from_rt(&m_ac, ac);
        sheen_Rt_from_rt(&m_ba, ba);
        sheen_Rt_point(p_b, &m_bc, p_c);
        sheen_Rt_point(p_a, &m_ab, p_b);
        sheen_Rt_point(q_a, &m_ac, p_c);
        sheen_Rt_point(q_b, &m_ba, p_a);
        for (int i = 0; i < 3; i++) {
            assert_close(q_a[i], p_a[i], 1e-12);
            assert_close(q_b[i], p_b[i], 1e-12);
        }
    }
}

static void angle_between_poses(void **state)
{
    (void)state;
    const double a[6] = {0.3, 0, 0, 1, 1, 1}, b[6] = {0.45, 0, 0, 9, 9, 9};
    assert_close(sheen_rt_angle_rad(a, b), 0.15, 1e-12);
    assert_close(sheen_rt_angle_rad(a, a), 0, 1e-12);
}

static void orthonormalize_mends_rounding_only(void **state)
{
    (void)state;
    const double rt[6] = {0.4, -1.2, 0.9, 0, 0, 0};
    sheen_Rt m;
    sheen_Rt_from_rt(&m, rt);
    double R[3][3], bad[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            R[i][j] = round(m.R[i][j] * 1e5) / 1e5;
            bad[i][j] = m.R[i][j] * 1.1;
        }
    assert_true(sheen_R_orthonormalize(R, 1e-4));
    for (int i = 0; i < 3; i++) {
        assert_close(sheen_norm(R[i]), 1, 1e-14);
        assert_close(sheen_dot(R[i], R[(i + 1) % 3]), 0, 1e-14);
    }
    assert_false(sheen_R_orthonormalize(bad, 1e-4));
    double mirror[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, -1}}, zero[3][3] = {{0}}, nan[3][3] = {{(double)NAN}};
    assert_false(sheen_R_orthonormalize(mirror, 1e-4));
    assert_false(sheen_R_orthonormalize(zero, 1e-4));
    assert_false(sheen_R_orthonormalize(nan, 1e-4));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(quarter_turn_about_z_takes_x_to_y),
        cmocka_unit_test(round_trip_at_every_angle),
        cmocka_unit_test(composition_and_inverse_are_those_of_points),
        cmocka_unit_test(angle_between_poses),
        cmocka_unit_test(orthonormalize_mends_rounding_only),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

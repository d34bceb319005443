// SPDX-License-Identifier: Apache-2.0
// test_lamp.c - lamps' responses agree with the formula in double precision, with eq. (7), and with GGX.
#include "render/lamp.h"
#include "tests/support.h"
#include "tests/support_scene.h"

#include <math.h>

#include "render/lobe.h"

static uint64_t seed = 3;

static sheen_lamp random_lamp(float radius_rad)
{
    sheen_lamp l = {.inverse_distance_per_m = (float)(3 * test_random(&seed)), .radius_rad = radius_rad};
    test_direction(l.direction_world, &seed);
    return l;
}

// A surface point at which the lamp's highlight is near: its normal within `off` of the bisector.
static void near_highlight(float x[3], float n[3], float v[3], const sheen_lamp *l, float off)
{
    float L[3], jitter[3];
    do {
        for (int k = 0; k < 3; k++) {
            x[k] = (float)(0.2 * (test_random(&seed) - 0.5));
            L[k] = l->direction_world[k] - l->inverse_distance_per_m * x[k];
        }
        sheen_normalizef(L);
        test_direction(v, &seed);
        test_direction(jitter, &seed);
        for (int k = 0; k < 3; k++)
            n[k] = L[k] + v[k];
        sheen_normalizef(n);
        for (int k = 0; k < 3; k++)
            n[k] += off * jitter[k];
        sheen_normalizef(n);
    } while (sheen_dotf(n, v) < 0.1f || sheen_dotf(n, L) < 0.1f);
}

static void fast_sums_are_the_formula(void **state)
{
    (void)state;
    static const float radii[] = {0, 0.01f, 0.05f, 0.12f, 0.3f}, offs[] = {0, 0.02f, 0.1f, 0.5f};
    sheen_err err;
    for (int rep = 0; rep < 400; rep++) {
        enum { N = 70 };
        sheen_lamp lamps[N];
        sheen_lamp_points points;
        const sheen_lobe_shape lobe = {0.01f + 0.08f * (float)test_random(&seed), (float)test_random(&seed),
                                       24 * (float)test_random(&seed)};
        for (int i = 0; i < N; i++)
            lamps[i] = random_lamp(radii[i % 5]);
        assert_ok(sheen_lamp_points_init(&points, lamps, N, lobe.sigma_rad, &err), err);
        float x[3], n[3], v[3], got[N];
        double want[N];
        near_highlight(x, n, v, &lamps[rep % N], offs[rep % 4]);
        sheen_lamp_responses(got, &points, 0, N, &lobe, x, n, v);
        sheen_lamp_responses_ref(want, lamps, N, &lobe, x, n, v);
        const double peak = (1 + (double)lobe.fresnel) /
                            0.2; // that the cut-off of discs far off may miss a share of
        for (int i = 0; i < N; i++)
            assert_close(got[i], want[i], 2e-5 * fabs(want[i]) + 1e-3 * peak);
        const int at = rep % N; // at the highlight itself no disc is cut off
        if (offs[rep % 4] <= 0.02f)
            assert_true(fabs((double)got[at] - want[at]) < 1e-4 * want[at] + 1e-6);
        float part[3];
        sheen_lamp_responses(part, &points, 40, 3, &lobe, x, n, v);
        for (int i = 0; i < 3; i++)
            assert_true(part[i] == got[40 + i]);
        sheen_lamp_points_release(&points);
    }
}

// Points strewn about a place, some far from every highlight: none exceeds the bound, and far from a narrow lobe the bound is small.
static void no_point_of_a_patch_exceeds_its_bound(void **state)
{
    (void)state;
    enum { POINTS = 12 };
    static const float radii[] = {0, 0.02f, 0.1f, 0.3f}, offs[] = {0.02f, 0.2f, 0.8f};
    sheen_err err;
    int n_small = 0;
    for (int rep = 0; rep < 3000; rep++) {
        const sheen_lamp lamp = random_lamp(radii[rep % 4]);
        const sheen_lobe_shape lobe = {0.01f + 0.08f * (float)test_random(&seed),
                                       rep % 2 ? (float)test_random(&seed) : 0,
                                       24 * (float)test_random(&seed)};
        const float size = 0.1f * (float)test_random(&seed);
        float middle[3][3], at[POINTS][3][3], most = 0;
        sheen_lamp_points points;
        sheen_lamp_patch patch = {.x_m = {0}};
        float *mean[3] = {patch.x_m, patch.n_world, patch.v_world},
              *reach[3] = {&patch.x_reach_m, &patch.n_reach, &patch.v_reach};
        near_highlight(middle[0], middle[1], middle[2], &lamp, offs[rep % 3]);
        assert_ok(sheen_lamp_points_init(&points, &lamp, 1, lobe.sigma_rad, &err), err);
        for (int i = 0; i < POINTS; i++) {
            float response;
            for (int k = 0; k < 3; k++) {
                float by[3];
                test_direction(by, &seed);
                for (int c = 0; c < 3; c++)
                    at[i][k][c] = middle[k][c] + size * by[c];
                if (k)
                    sheen_normalizef(at[i][k]);
                for (int c = 0; c < 3; c++)
                    mean[k][c] += at[i][k][c] / POINTS;
            }
            sheen_lamp_responses(&response, &points, 0, 1, &lobe, at[i][0], at[i][1], at[i][2]);
            most = fmaxf(most, response);
        }
        for (int i = 0; i < POINTS; i++)
            for (int k = 0; k < 3; k++) {
                float d[3];
                sheen_subf(d, at[i][k], mean[k]);
                *reach[k] = fmaxf(*reach[k], sqrtf(sheen_dotf(d, d)));
            }
        const float bound = sheen_lamp_response_bound(&lamp, &lobe, &patch);
        assert_true(bound + 1e-20f >= most); // the fast exponential ends at 2^-100
        n_small += bound < 1e-6f;
        sheen_lamp_points_release(&points);
    }
    assert_true(n_small > 100);
}

static void a_far_point_is_the_papers_light(void **state)
{
    (void)state;
    sheen_err err;
    for (int rep = 0; rep < 200; rep++) {
        sheen_lamp lamp = random_lamp(0);
        lamp.inverse_distance_per_m = 0;
        float *d = lamp.direction_world, one = 1, x[3], n[3], v[3], got;
        const sheen_lobe_shape lobe = {0.03f, 0, 0};
        const sheen_lights light = {&d[0], &d[1], &d[2], &one, 1};
        sheen_lamp_points points;
        assert_ok(sheen_lamp_points_init(&points, &lamp, 1, lobe.sigma_rad, &err), err);
        near_highlight(x, n, v, &lamp, 0.03f);
        sheen_lamp_responses(&got, &points, 0, 1, &lobe, x, n, v);
        assert_close(got, sheen_lobe_sum_ref(&light, n, v, lobe.sigma_rad), 1e-5 * (1 + (double)got));
        sheen_lamp_points_release(&points);
    }
}

// tail = 1 is the GGX distribution of roughness 2 sigma, to the difference between the angle and its tangent.
static void the_tail_is_ggx(void **state)
{
    (void)state;
    sheen_err err;
    const double alpha_g = 0.08;
    const sheen_lobe_shape lobe = {(float)alpha_g / 2, 1, 0};
    const sheen_lamp lamp = {.direction_world = {0, 0, 1}};
    sheen_lamp_points points;
    assert_ok(sheen_lamp_points_init(&points, &lamp, 1, lobe.sigma_rad, &err), err);
    for (int i = 0; i < 30; i++) {
        const double a = 0.01 * i, tangent = tan(a);
        const float x[3] = {0, 0, 0}, n[3] = {(float)sin(a), 0, (float)cos(a)}, v[3] = {0, 0, 1};
        float got;
        sheen_lamp_responses(&got, &points, 0, 1, &lobe, x, n, v);
        const double below = 1 + tangent * tangent / (alpha_g * alpha_g), c = cos(a);
        assert_close((double)got * c, 1 / (c * c * c * c * below * below), 0.004);
    }
    sheen_lamp_points_release(&points);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fast_sums_are_the_formula),
        cmocka_unit_test(no_point_of_a_patch_exceeds_its_bound),
        cmocka_unit_test(a_far_point_is_the_papers_light),
        cmocka_unit_test(the_tail_is_ggx),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

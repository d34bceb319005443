// SPDX-License-Identifier: Apache-2.0
// test_lobe.c - the fast lobe sums agree with the formula in double precision.
#include "render/lobe.h"

#include "base/cpu_level.h"
#include "tests/support.h"
#include "tests/support_scene.h"

#include <math.h>

enum { MAX_LIGHTS = 18151 };

static float dx[MAX_LIGHTS], dy[MAX_LIGHTS], dz[MAX_LIGHTS], weight[MAX_LIGHTS];
static uint64_t seed = 1;

// Random lights over the whole sphere, one in ten of no weight.
static sheen_lights random_lights(size_t count)
{
    for (size_t i = 0; i < count; i++) {
        float d[3];
        test_direction(d, &seed);
        dx[i] = d[0];
        dy[i] = d[1];
        dz[i] = d[2];
        weight[i] = i % 10 ? (float)test_random(&seed) : 0;
    }
    return (sheen_lights){dx, dy, dz, weight, count};
}

static void random_view(float n[3], float v[3])
{
    do {
        test_direction(n, &seed);
        test_direction(v, &seed);
    } while (sheen_dotf(n, v) <= 0);
}

// A light whose mirror image is `off` radians of alpha away: l mirrors v about a normal turned by that much.
static void light_at_alpha(float l[3], const float n[3], const float v[3], double off_rad)
{
    float axis[3], across[3], h[3];
    test_direction(axis, &seed);
    sheen_crossf(across, n, axis);
    sheen_normalizef(across);
    for (int k = 0; k < 3; k++)
        h[k] = (float)(cos(off_rad) * (double)n[k] + sin(off_rad) * (double)across[k]);
    sheen_normalizef(h);
    sheen_mirrorf(l, h, v);
    sheen_normalizef(l);
}

static void alpha_is_the_angle_to_the_bisector(void **state)
{
    (void)state;
    static const double offs_rad[] = {0, 1e-4, 0.003, 0.0114, 0.05, 0.2, 0.5, 1.0, 1.4};
    for (size_t i = 0; i < sizeof offs_rad / sizeof *offs_rad; i++)
        for (int rep = 0; rep < 200; rep++) {
            float n[3], v[3], l[3];
            do {
                random_view(n, v);
                light_at_alpha(l, n, v, offs_rad[i]);
            } while (sheen_dotf(n, l) <= 1e-3f || sheen_dotf(n, v) < 0.05f);
            const double got = (double)sheen_lobe_alpha2(n, v, l), want = offs_rad[i] * offs_rad[i];
            assert_close(got, want, 4e-7 * offs_rad[i] / (double)sheen_dotf(n, v) + 5e-7 * want + 1e-12);
        }
}

static void both_horizons_hide_the_light(void **state)
{
    (void)state;
    const float n[3] = {0, 0, 1}, up[3] = {0.6f, 0, 0.8f}, below[3] = {0.6f, 0, -0.8f};
    assert_true(isinf(sheen_lobe_alpha2(n, up, below)));
    assert_true(isinf(sheen_lobe_alpha2(n, below, up)));
    assert_true(isfinite(sheen_lobe_alpha2(n, up, up)));
    float lx = 0.6f, ly = 0, lz = -0.8f, w = 1;
    const sheen_lights one = {&lx, &ly, &lz, &w, 1};
    for (int level = 0; level <= sheen_cpu_level(); level++) {
        assert_true(sheen_lobe_sum_level(&one, n, up, 0.5f, level) == 0);
        assert_true(sheen_lobe_sum_level(&one, n, below, 0.5f, level) == 0);
    }
    assert_true(sheen_lobe_sum_ref(&one, n, up, 0.5f) == 0);
    assert_true(sheen_lobe_sum_ref(&one, n, below, 0.5f) == 0);
}

static void grazing_views_are_held(void **state)
{
    (void)state;
    const float n[3] = {0, 0, 1}, v[3] = {sqrtf(1 - 0.01f), 0, 0.1f};
    float lx = -v[0], ly = 0, lz = v[2], w = 2; // the mirror direction: alpha = 0
    const sheen_lights one = {&lx, &ly, &lz, &w, 1};
    assert_close(sheen_lobe_sum(&one, n, v, 0.1f), 2 / 0.2, 1e-5);
    assert_close(sheen_lobe_sum_ref(&one, n, v, 0.1f), 2 / 0.2, 1e-5);
}

static void fast_agrees_with_reference(void **state)
{
    (void)state;
    static const size_t counts[] = {0, 1, 7, 15, 16, 17, 255, 1000, MAX_LIGHTS};
    static const float sigmas_rad[] = {1e-4f, 0.0114f, 0.03f, 0.1f, 0.3f, 0.6f};
    for (int level = 0; level <= sheen_cpu_level(); level++) {
        double worst = 0;
        for (size_t c = 0; c < sizeof counts / sizeof *counts; c++)
            for (size_t s = 0; s < sizeof sigmas_rad / sizeof *sigmas_rad; s++)
                for (int rep = 0; rep < (counts[c] < 2000 ? 10 : 2); rep++) {
                    const sheen_lights l = random_lights(counts[c] < 300 ? counts[c] : rep ? counts[c] : 300);
                    float n[3], v[3];
                    random_view(n, v);
                    const double ref = sheen_lobe_sum_ref(&l, n, v, sigmas_rad[s]);
                    const double got = (double)sheen_lobe_sum_level(&l, n, v, sigmas_rad[s], level);
                    assert_close(got, ref, 1e-7 + 1e-4 * ref);
                    if (ref > 1e-3)
                        worst = fmax(worst, fabs(got - ref) / ref);
                }
        print_message("level %d: worst relative error %.2g\n", level, worst);
    }
}

// The term itself, over the whole reach, at the paper's sigma and at the widest.
static void each_term_is_exact_over_the_reach(void **state)
{
    (void)state;
    static const float sigmas_rad[] = {0.0114f, 0.3f};
    for (int level = 0; level <= sheen_cpu_level(); level++)
        for (size_t s = 0; s < 2; s++)
            for (int rep = 0; rep < 2000; rep++) {
                float n[3], v[3], l[3], w = 1;
                do {
                    random_view(n, v);
                    const double reach = fmin(5 * (double)sigmas_rad[s], 1.2);
                    light_at_alpha(l, n, v, reach * test_random(&seed));
                } while (sheen_dotf(n, l) <= 1e-3f || sheen_dotf(n, v) < 0.2f);
                const sheen_lights one = {l, l + 1, l + 2, &w, 1};
                const double ref = sheen_lobe_sum_ref(&one, n, v, sigmas_rad[s]);
                assert_close(sheen_lobe_sum_level(&one, n, v, sigmas_rad[s], level), ref, 2e-4 * ref);
            }
}

// Against the plain kernel: what may be missing is terms beyond the reach, each below exp(-12.5) of its
// weight.
static void compare_cells(const sheen_lights *l, float sigma_rad, int n_views)
{
    sheen_light_cells *cells = NULL;
    sheen_err err = {0};
    assert_ok(sheen_light_cells_new(&cells, l, sigma_rad, &err), err);
    double total = 0;
    for (size_t i = 0; i < l->count; i++)
        total += (double)l->weight[i];
    for (int rep = 0; rep < n_views; rep++) {
        float n[3], v[3];
        random_view(n, v);
        const double want = (double)sheen_lobe_sum(l, n, v, sigma_rad);
        const double left_out = exp(-12.5) * total * (double)sheen_lobe_inverse_cos(n, v);
        assert_close(sheen_light_cells_sum(cells, n, v), want, left_out + 1e-5 * want + 1e-12);
    }
    sheen_light_cells_free(&cells);
    assert_null(cells);
}

static void cells_agree_with_the_plain_sum(void **state)
{
    (void)state;
    static const float sigmas_rad[] = {1e-3f, 0.0114f, 0.03f, 0.05f, 0.1f, 0.15f, 0.3f, 0.6f};
    for (size_t s = 0; s < sizeof sigmas_rad / sizeof *sigmas_rad; s++) {
        sheen_lights l = random_lights(1162);
        compare_cells(&l, sigmas_rad[s], 500);
        l = random_lights(0);
        compare_cells(&l, sigmas_rad[s], 10);
        l = random_lights(1);
        compare_cells(&l, sigmas_rad[s], 100);
    }
    const sheen_lights all = random_lights(MAX_LIGHTS);
    compare_cells(&all, 0.0114f, 200);
    compare_cells(&all, 0.05f, 50);
}

// The highlight itself: lights exactly mirrored, where a light missing from a cell's list would show.
static void cells_hold_every_highlight(void **state)
{
    (void)state;
    static const float sigmas_rad[] = {0.0114f, 0.05f, 0.12f, 0.3f};
    for (size_t s = 0; s < sizeof sigmas_rad / sizeof *sigmas_rad; s++) {
        const sheen_lights l = random_lights(500);
        sheen_light_cells *cells = NULL;
        assert_int_equal(sheen_light_cells_new(&cells, &l, sigmas_rad[s], NULL), SHEEN_OK);
        for (int rep = 0; rep < 2000; rep++) {
            const size_t i = (size_t)(test_random(&seed) * 500);
            const float d[3] = {dx[i], dy[i], dz[i]};
            float v[3], n[3], off[3];
            test_direction(v, &seed);
            test_direction(off, &seed);
            const float turn = 4 * sigmas_rad[s] * (float)test_random(&seed); // within the reach
            for (int k = 0; k < 3; k++)
                n[k] = d[k] + v[k];
            if (sheen_normalizef(n) < 0.4f)
                continue;
            for (int k = 0; k < 3; k++)
                n[k] += turn * off[k];
            sheen_normalizef(n);
            const double want = sheen_lobe_sum_ref(&l, n, v, sigmas_rad[s]);
            assert_close(sheen_light_cells_sum(cells, n, v), want, 1e-4 * want + 500 * exp(-12.5) * 5);
        }
        sheen_light_cells_free(&cells);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(alpha_is_the_angle_to_the_bisector),
        cmocka_unit_test(both_horizons_hide_the_light),
        cmocka_unit_test(grazing_views_are_held),
        cmocka_unit_test(fast_agrees_with_reference),
        cmocka_unit_test(each_term_is_exact_over_the_reach),
        cmocka_unit_test(cells_agree_with_the_plain_sum),
        cmocka_unit_test(cells_hold_every_highlight),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

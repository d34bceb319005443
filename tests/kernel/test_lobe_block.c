// SPDX-License-Identifier: Apache-2.0
// test_lobe_block.c - the sum for many samples at once agrees with the sum for each, at every instruction set.
#include "render/lobe_block.h"

#include "base/cpu_level.h"
#include "tests/support.h"
#include "tests/support_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { N_LIGHTS = 1200 };

static float dx[N_LIGHTS], dy[N_LIGHTS], dz[N_LIGHTS], weight[N_LIGHTS];
static uint64_t seed = 7;

// Over the upper half; gathered within `spread` of a few lamps, or everywhere (0).
static sheen_lights make_lights(size_t count, float spread)
{
    float lamps[5][3];
    for (int i = 0; i < 5; i++)
        test_direction(lamps[i], &seed);
    for (size_t i = 0; i < count; i++) {
        float d[3];
        test_direction(d, &seed);
        for (int k = 0; k < 3 && spread > 0; k++)
            d[k] = lamps[i % 5][k] + spread * d[k];
        sheen_normalizef(d);
        dx[i] = d[0];
        dy[i] = d[1];
        dz[i] = fabsf(d[2]);
        weight[i] = 1.0f / (float)count;
    }
    return (sheen_lights){dx, dy, dz, weight, count};
}

// A patch whose normals turn by `bend` radians from side to side; in the second half of a `broken` one they
// jump.
static void make_block(sheen_lobe_block *b, int count, float bend, int broken)
{
    float n0[3], v0[3], other[3], a[3], c[3];
    do {
        test_direction(n0, &seed);
        test_direction(v0, &seed);
    } while (sheen_dotf(n0, v0) < 0.03f);
    test_direction(other, &seed);
    sheen_crossf(a, n0, other);
    sheen_normalizef(a);
    sheen_crossf(c, n0, a);
    b->count = count;
    for (int i = 0; i < count; i++) {
        const int x = (i & 1) | (i >> 1 & 2) | (i >> 2 & 4) | (i >> 3 & 8);
        const int y = (i >> 1 & 1) | (i >> 2 & 2) | (i >> 3 & 4) | (i >> 4 & 8);
        const float s = bend * ((float)x / 16 - 0.5f), t = bend * ((float)y / 16 - 0.5f);
        float n[3], v[3];
        for (int k = 0; k < 3; k++) {
            n[k] = n0[k] + s * a[k] + (t + s * t) * c[k] + (broken && i > count / 2 ? 0.4f * c[k] : 0);
            v[k] = v0[k] + 0.01f * (s * c[k] - t * a[k]);
        }
        sheen_normalizef(n);
        sheen_normalizef(v);
        b->nx[i] = n[0];
        b->ny[i] = n[1];
        b->nz[i] = n[2];
        b->vx[i] = v[0];
        b->vy[i] = v[1];
        b->vz[i] = v[2];
    }
}

// What lights beyond the lobe's reach add to a single sum, and may or may not to a block's.
static float beyond_reach(const sheen_lobe_block *b, int i, const sheen_lights *lights, float sigma_rad)
{
    const float n[3] = {b->nx[i], b->ny[i], b->nz[i]}, v[3] = {b->vx[i], b->vy[i], b->vz[i]};
    float sum = 0;
    for (size_t k = 0; k < lights->count; k++) {
        const float l[3] = {lights->dx[k], lights->dy[k], lights->dz[k]};
        const float q = sheen_lobe_alpha2(n, v, l) / (sigma_rad * sigma_rad);
        if (q > 0.999f * SHEEN_LOBE_REACH_SIGMA * SHEEN_LOBE_REACH_SIGMA && q < 100)
            sum += lights->weight[k] * expf(-0.5f * q);
    }
    return sum * sheen_lobe_inverse_cos(n, v);
}

static float worst_of(const sheen_lobe_block *got, const sheen_lobe_block *want, const sheen_lights *lights,
                      float sigma_rad, float tolerance)
{
    float worst = 0;
    for (int i = 0; i < want->count; i++) {
        const float allowed = fmaxf(tolerance, 1e-3f * want->sum[i]);
        float off = fabsf(got->sum[i] - want->sum[i]);
        if (off > 6 * allowed && got->sum[i] < want->sum[i])
            off = fmaxf(0, off - beyond_reach(want, i, lights, sigma_rad));
        worst = fmaxf(worst, off / allowed);
    }
    return worst;
}

// Errors in units of what is asked: only four samples of a group are checked, so that others may be off by more.
static void compare(float sigma_rad, size_t n_lights, float spread)
{
    static sheen_lobe_block b, ref;
    sheen_err err = {0};
    const sheen_lights lights = make_lights(n_lights, spread);
    static const float bends[] = {0, 0.003f, 0.02f, 0.06f, 0.2f, 1.0f};
    static const int counts[] = {256, 256, 64, 37, 7, 1};
    for (int wide = 0; wide < 2; wide++) {
        sheen_light_cells *cells;
        assert_ok((wide ? sheen_lobe_block_cells : sheen_light_cells_new)(&cells, &lights, sigma_rad, &err),
                  err);
        for (int i = 0; i < 120; i++) {
            make_block(&b, counts[i % 6], bends[i / 6 % 6], i % 5 == 4);
            ref = b;
            sheen_lobe_block_sum_ref(&ref, cells);
            float most = 0;
            for (int k = 0; k < ref.count; k++)
                most = fmaxf(most, ref.sum[k]);
            const float tolerance = 1e-4f * fmaxf(most, 1e-3f);
            for (int level = 0; level <= sheen_cpu_level(); level++) {
                memset(b.sum, 0xff, sizeof b.sum);
                sheen_lobe_block_sum_level(&b, cells, tolerance, level);
                const float worst = worst_of(&b, &ref, &lights, sigma_rad, tolerance);
                if (worst > 6)
                    print_error("sigma %g, %zu lights about %g, block %d, level %d: off by %g\n",
                                (double)sigma_rad, n_lights, (double)spread, i, level, (double)worst);
                assert_true(worst <= 6);
            }
        }
        sheen_light_cells_free(&cells);
    }
}

static void blocks_agree_with_single_sums(void **state)
{
    (void)state;
    static const float sigmas_rad[] = {0.0114f, 0.03f, 0.1f, 0.16f, 0.3f, 0.8f};
    for (int i = 0; i < 6; i++) {
        compare(sigmas_rad[i], N_LIGHTS, 0);
        compare(sigmas_rad[i], N_LIGHTS, 0.2f);
        compare(sigmas_rad[i], 60, 0.02f);
        compare(sigmas_rad[i], 1, 0);
    }
}

static void nothing_to_sum(void **state)
{
    (void)state;
    static sheen_lobe_block b;
    sheen_err err = {0};
    sheen_light_cells *cells;
    const sheen_lights none = {dx, dy, dz, weight, 0};
    assert_ok(sheen_lobe_block_cells(&cells, &none, 0.05f, &err), err);
    sheen_lobe_block_sum(&b, cells, 1e-3f);
    make_block(&b, 5, 0.1f, 0);
    sheen_lobe_block_sum(&b, cells, 1e-3f);
    for (int i = 0; i < 5; i++)
        assert_close(b.sum[i], 0, 0);
    sheen_light_cells_free(&cells);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_agree_with_single_sums),
        cmocka_unit_test(nothing_to_sum),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

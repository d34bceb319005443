// SPDX-License-Identifier: Apache-2.0
// lobe.c - the specular lobe summed over lights, eq. (7) of the paper without k_S.
//
// The body (lobe_math.h) is compiled for three instruction sets and chosen when called, so a sum repeats
// exactly on one machine, and to the tolerance of the test on another.
#include "render/lobe.h"

#include <assert.h>

#include "base/cpu_level.h"
#include "render/lobe_math.h"

enum { LANES = 16 };

float sheen_lobe_alpha2(const float n[3], const float v[3], const float l[3])
{
    if (!(sheen_dotf(n, l) > 0) || !(sheen_dotf(n, v) > 0))
        return HUGE_VALF;
    const float h[3] = {l[0] + v[0], l[1] + v[1], l[2] + v[2]};
    const float inv_h = 1.0f / sqrtf(sheen_dotf(h, h));
    const float e[3] = {n[0] - h[0] * inv_h, n[1] - h[1] * inv_h, n[2] - h[2] * inv_h};
    return sheen_alpha2_of(0.5f * sheen_dotf(e, e), 0);
}

// The body over whole vectors, and the lights that are left in one that is filled up with lights of no weight: what the compiler
// makes of an unfilled vector takes as long as several.
SHEEN_KERNEL_INLINE float sum_vectors(const sheen_lights *lights, const float n[3], const float v[3],
                                      float sigma_rad, int fused)
{
    sheen_lights whole = *lights;
    whole.count = lights->count / LANES * LANES;
    float sum = sheen_lobe_sum_body(&whole, n, v, sigma_rad, fused);
    if (whole.count == lights->count)
        return sum;
    float dx[LANES], dy[LANES], dz[LANES], weight[LANES];
    for (size_t i = 0; i < LANES; i++) {
        const size_t light = whole.count + i, k = light < lights->count ? light : whole.count;
        dx[i] = lights->dx[k];
        dy[i] = lights->dy[k];
        dz[i] = lights->dz[k];
        weight[i] = light < lights->count ? lights->weight[k] : 0;
    }
    const sheen_lights last = {dx, dy, dz, weight, LANES};
    return sum + sheen_lobe_sum_body(&last, n, v, sigma_rad, fused);
}

static float sum_baseline(const sheen_lights *lights, const float n[3], const float v[3], float sigma_rad)
{
    return sum_vectors(lights, n, v, sigma_rad, 0);
}

#if defined(__x86_64__)
SHEEN_TARGET_AVX2 static float sum_avx2(const sheen_lights *lights, const float n[3], const float v[3],
                                        float sigma_rad)
{
    return sum_vectors(lights, n, v, sigma_rad, 1);
}

SHEEN_TARGET_AVX512 static float sum_avx512(const sheen_lights *lights, const float n[3], const float v[3],
                                            float sigma_rad)
{
    return sum_vectors(lights, n, v, sigma_rad, 1);
}
#endif

float sheen_lobe_sum_level(const sheen_lights *lights, const float n[3], const float v[3], float sigma_rad,
                           int level)
{
    assert(sigma_rad > 0);
    if (!(sheen_dotf(n, v) > 0))
        return 0;
    const float inverse_cos = sheen_lobe_inverse_cos(n, v);
#if defined(__x86_64__)
    if (level >= SHEEN_CPU_AVX512)
        return inverse_cos * sum_avx512(lights, n, v, sigma_rad);
    if (level == SHEEN_CPU_AVX2)
        return inverse_cos * sum_avx2(lights, n, v, sigma_rad);
#endif
    (void)level;
    return inverse_cos * sum_baseline(lights, n, v, sigma_rad);
}

float sheen_lobe_sum(const sheen_lights *lights, const float n[3], const float v[3], float sigma_rad)
{
    return sheen_lobe_sum_level(lights, n, v, sigma_rad, sheen_cpu_level());
}

// The angle by atan2 of sine and cosine: acos would lose half the digits near the highlight.
double sheen_lobe_sum_ref(const sheen_lights *lights, const float n[3], const float v[3], float sigma_rad)
{
    const double nd[3] = {(double)n[0], (double)n[1], (double)n[2]};
    const double vd[3] = {(double)v[0], (double)v[1], (double)v[2]};
    const double cos_r = sheen_dot(nd, vd), least = (double)SHEEN_LOBE_MIN_COS, sigma = (double)sigma_rad;
    if (!(cos_r > 0))
        return 0;
    double sum = 0;
    for (size_t i = 0; i < lights->count; i++) {
        const double l[3] = {(double)lights->dx[i], (double)lights->dy[i], (double)lights->dz[i]};
        if (!(sheen_dot(nd, l) > 0))
            continue;
        double h[3] = {l[0] + vd[0], l[1] + vd[1], l[2] + vd[2]}, across[3];
        sheen_normalize(h);
        sheen_cross(across, nd, h);
        const double alpha_rad = atan2(sheen_norm(across), sheen_dot(nd, h));
        sum += (double)lights->weight[i] * exp(-alpha_rad * alpha_rad / (2 * sigma * sigma));
    }
    return sum / (cos_r > least ? cos_r : least);
}

// SPDX-License-Identifier: Apache-2.0
// lobe.c - the specular lobe summed over lights, eq. (7) of the paper without k_S.
//
// The innermost loop of drawing, and the formula that fitting inverts. It is written for the compiler's
// vectoriser:
//
//   * lights are separate arrays, so that all loads are of neighbours; the body has no branch and no call;
//   * alpha^2 / x is a polynomial in x = 1 - cos(alpha), good to 2.9e-7 (relative) over 0..90 degrees;
//   * x is computed as |n - h|^2 / 2, because 1 - n.h cancels near the highlight;
//   * the exponent is held below EXPONENT_MAX by comparing bits as integers (non-negative floats order like
//     their bits): a comparison of floats becomes a branch in gcc 12, and smaller results would become
//     denormal, which the processor handles slowly;
//   * `omp simd reduction` permits reordering this one sum. The body is compiled for three instruction sets
//     and chosen when called, so a sum repeats exactly on one machine, and to the tolerance of the test on
//     another.
//
// Both polynomials were fitted here to the least greatest relative error (iteratively reweighted least
// squares).
#include "render/lobe.h"

#include <assert.h>
#include <stdint.h>
#include <string.h>

#include "base/cpu_level.h"

// 2^-100 = 1e-30: far below every tolerance, far above denormal.
#define EXPONENT_MAX 100.0f

// a * b + c; in one rounding where the instruction set has it (constant `fused`: one of the two is compiled).
SHEEN_KERNEL_INLINE float mad(float a, float b, float c, int fused)
{
    return fused ? __builtin_fmaf(a, b, c) : a * b + c;
}

// alpha^2 = acos(1 - x)^2 for x in 0..1.
SHEEN_KERNEL_INLINE float alpha2_of(float x, int fused)
{
    float p = 9.217112091e-3f;
    p = mad(p, x, -1.05966902e-2f, fused);
    p = mad(p, x, 2.171258428e-2f, fused);
    p = mad(p, x, 2.409557386e-2f, fused);
    p = mad(p, x, 8.969094345e-2f, fused);
    p = mad(p, x, 3.3328031e-1f, fused);
    p = mad(p, x, 2.000000567f, fused);
    return p * x;
}

// 2^-t for t >= 0, relative error below 2e-7; never below 1e-30.
SHEEN_KERNEL_INLINE float exp2_minus(float t, int fused)
{
    const float most = EXPONENT_MAX;
    int32_t bits, most_bits;
    memcpy(&bits, &t, sizeof bits);
    memcpy(&most_bits, &most, sizeof most_bits);
    bits = bits < most_bits ? bits : most_bits;
    memcpy(&t, &bits, sizeof t);

    const int32_t k = (int32_t)(t + 0.5f); // nearest integer, as t >= 0
    const float f = (float)k - t;          // -0.5..0.5
    float p = 1.327644276e-3f;
    p = mad(p, f, 9.675541101e-3f, fused);
    p = mad(p, f, 5.550713364e-2f, fused);
    p = mad(p, f, 2.402211973e-1f, fused);
    p = mad(p, f, 6.93146967e-1f, fused);
    p = mad(p, f, 1.000000072f, fused);
    bits = (127 - k) * (1 << 23); // 2^-k
    float scale;
    memcpy(&scale, &bits, sizeof scale);
    return p * scale;
}

float sheen_lobe_alpha2(const float n[3], const float v[3], const float l[3])
{
    if (!(sheen_dotf(n, l) > 0) || !(sheen_dotf(n, v) > 0))
        return HUGE_VALF;
    const float h[3] = {l[0] + v[0], l[1] + v[1], l[2] + v[2]};
    const float inv_h = 1.0f / sqrtf(sheen_dotf(h, h));
    const float e[3] = {n[0] - h[0] * inv_h, n[1] - h[1] * inv_h, n[2] - h[2] * inv_h};
    return alpha2_of(0.5f * sheen_dotf(e, e), 0);
}

SHEEN_KERNEL_INLINE float sum_body(const sheen_lights *lights, const float n[3], const float v[3],
                                   float sigma_rad, int fused)
{
    const float *restrict dx = lights->dx;
    const float *restrict dy = lights->dy;
    const float *restrict dz = lights->dz;
    const float *restrict weight = lights->weight;
    const size_t count = lights->count;
    const float nx = n[0], ny = n[1], nz = n[2];
    const float vx = v[0], vy = v[1], vz = v[2];
    const float per_alpha2 = 0.721347520f /
                             (sigma_rad * sigma_rad); // exp(-a / (2 s^2)) = 2^-(a log2(e) / (2 s^2))

    float sum = 0;
#pragma omp simd reduction(+ : sum)
    for (size_t i = 0; i < count; i++) {
        const float lx = dx[i], ly = dy[i], lz = dz[i];
        const float n_dot_l = mad(nx, lx, mad(ny, ly, nz * lz, fused), fused);
        const float hx = lx + vx, hy = ly + vy, hz = lz + vz;
        // Opposite directions have no bisector; they are below the horizon, and the small term keeps them
        // finite.
        const float h2 = mad(hx, hx, mad(hy, hy, mad(hz, hz, 1e-12f, fused), fused), fused);
        const float inv_h = 1.0f / sqrtf(h2);
        const float ex = mad(-hx, inv_h, nx, fused), ey = mad(-hy, inv_h, ny, fused),
                    ez = mad(-hz, inv_h, nz, fused);
        const float x = 0.5f * mad(ex, ex, mad(ey, ey, ez * ez, fused), fused);
        const float lit = n_dot_l > 0.0f ? 1.0f
                                         : 0.0f; // selecting weight[i] itself would be a branch about a load
        sum += lit * weight[i] * exp2_minus(alpha2_of(x, fused) * per_alpha2, fused);
    }
    return sum;
}

static float sum_baseline(const sheen_lights *lights, const float n[3], const float v[3], float sigma_rad)
{
    return sum_body(lights, n, v, sigma_rad, 0);
}

#if defined(__x86_64__)
SHEEN_TARGET_AVX2 static float sum_avx2(const sheen_lights *lights, const float n[3], const float v[3],
                                        float sigma_rad)
{
    return sum_body(lights, n, v, sigma_rad, 1);
}

SHEEN_TARGET_AVX512 static float sum_avx512(const sheen_lights *lights, const float n[3], const float v[3],
                                            float sigma_rad)
{
    return sum_body(lights, n, v, sigma_rad, 1);
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

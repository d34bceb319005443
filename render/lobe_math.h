// SPDX-License-Identifier: Apache-2.0
// lobe_math.h - the lobe's kernel and its functions, for the compiler's vectoriser. Used inside render only.
//
//   * lights are separate arrays, so that all loads are of neighbours; the body has no branch and no call;
//   * x = 1 - cos(alpha) is computed as |n - h|^2 / 2, because 1 - n.h cancels near the highlight;
//   * `omp simd reduction` permits reordering this one sum;
//   * alpha^2 / x is a polynomial in x, good to 2.9e-7 (relative) over 0..90 degrees;
//   * the exponent is held below SHEEN_LOBE_EXPONENT_MAX by comparing bits as integers (non-negative floats
//     order like their bits): a comparison of floats becomes a branch in gcc 12, and smaller results would
//     become denormal, which the processor handles slowly.
//
// Both polynomials were fitted here to the least greatest relative error (iteratively reweighted least
// squares).
#ifndef SHEEN_RENDER_LOBE_MATH_H
#define SHEEN_RENDER_LOBE_MATH_H

#include <stdint.h>
#include <string.h>

#include "base/cpu_level.h"
#include "render/lobe.h"

// 2^-100 = 1e-30: far below every tolerance, far above denormal.
#define SHEEN_LOBE_EXPONENT_MAX 100.0f

// a * b + c; in one rounding where the instruction set has it (constant `fused`: one of the two is compiled).
SHEEN_KERNEL_INLINE float sheen_mad(float a, float b, float c, int fused)
{
    return fused ? __builtin_fmaf(a, b, c) : a * b + c;
}

// alpha^2 = acos(1 - x)^2 for x in 0..1.
SHEEN_KERNEL_INLINE float sheen_alpha2_of(float x, int fused)
{
    float p = 9.217112091e-3f;
    p = sheen_mad(p, x, -1.05966902e-2f, fused);
    p = sheen_mad(p, x, 2.171258428e-2f, fused);
    p = sheen_mad(p, x, 2.409557386e-2f, fused);
    p = sheen_mad(p, x, 8.969094345e-2f, fused);
    p = sheen_mad(p, x, 3.3328031e-1f, fused);
    p = sheen_mad(p, x, 2.000000567f, fused);
    return p * x;
}

// 2^-t for t >= 0, relative error below 2e-7; never below 1e-30.
SHEEN_KERNEL_INLINE float sheen_exp2_minus(float t, int fused)
{
    const float most = SHEEN_LOBE_EXPONENT_MAX;
    int32_t bits, most_bits;
    memcpy(&bits, &t, sizeof bits);
    memcpy(&most_bits, &most, sizeof most_bits);
    bits = bits < most_bits ? bits : most_bits;
    memcpy(&t, &bits, sizeof t);

    const int32_t k = (int32_t)(t + 0.5f); // nearest integer, as t >= 0
    const float f = (float)k - t;          // -0.5..0.5
    float p = 1.327644276e-3f;
    p = sheen_mad(p, f, 9.675541101e-3f, fused);
    p = sheen_mad(p, f, 5.550713364e-2f, fused);
    p = sheen_mad(p, f, 2.402211973e-1f, fused);
    p = sheen_mad(p, f, 6.93146967e-1f, fused);
    p = sheen_mad(p, f, 1.000000072f, fused);
    bits = (127 - k) * (1 << 23); // 2^-k
    float scale;
    memcpy(&scale, &bits, sizeof scale);
    return p * scale;
}

// sum_l weight_l exp(-alpha_l^2 / (2 sigma^2)) over lights above the horizon; n.v > 0.
SHEEN_KERNEL_INLINE float sheen_lobe_sum_body(const sheen_lights *lights, const float n[3], const float v[3],
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
        const float n_dot_l = sheen_mad(nx, lx, sheen_mad(ny, ly, nz * lz, fused), fused);
        const float hx = lx + vx, hy = ly + vy, hz = lz + vz;
        // Opposite directions have no bisector; they are below the horizon, and the small term keeps them
        // finite.
        const float h2 = sheen_mad(hx, hx, sheen_mad(hy, hy, sheen_mad(hz, hz, 1e-12f, fused), fused), fused);
        const float inv_h = 1.0f / sqrtf(h2);
        const float ex = sheen_mad(-hx, inv_h, nx, fused), ey = sheen_mad(-hy, inv_h, ny, fused),
                    ez = sheen_mad(-hz, inv_h, nz, fused);
        const float x = 0.5f * sheen_mad(ex, ex, sheen_mad(ey, ey, ez * ez, fused), fused);
        const float lit = n_dot_l > 0.0f ? 1.0f
                                         : 0.0f; // selecting weight[i] itself would be a branch about a load
        sum += lit * weight[i] * sheen_exp2_minus(sheen_alpha2_of(x, fused) * per_alpha2, fused);
    }
    return sum;
}

#endif

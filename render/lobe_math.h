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

// sum + a * b, where `sum` is what a vectorised loop adds up: clang does not take a fused one for a sum.
SHEEN_KERNEL_INLINE float sheen_add_product(float sum, float a, float b, int fused)
{
#ifdef __clang__
    (void)fused;
    return sum + a * b;
#else
    return sheen_mad(a, b, sum, fused);
#endif
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

// alpha^2 = asin(sqrt(y))^2 from y = sin(alpha)^2: relative error below 3e-7 for alpha <= 30 degrees; beyond it comes out too
// small, by less than a third. Times `scale`, a constant of the caller's loop.
SHEEN_KERNEL_INLINE float sheen_sine2_alpha2(float y, float scale, int fused)
{
    float p = 0.136655671f * scale;
    p = sheen_mad(p, y, 0.100817059f * scale, fused);
    p = sheen_mad(p, y, 0.179038505f * scale, fused);
    p = sheen_mad(p, y, 0.333293086f * scale, fused);
    p = sheen_mad(p, y, 1.0000002f * scale, fused);
    return p * y;
}

// Widest lobe of which 5 sigma end within 30 degrees.
#define SHEEN_LOBE_NARROW_RAD 0.1045f

// 2^-t for t >= 0, relative error below 2e-7; never below 1e-30.
SHEEN_KERNEL_INLINE float sheen_exp2_minus(float t, int fused)
{
    const float most = SHEEN_LOBE_EXPONENT_MAX,
                whole = 12582912.0f; // 1.5 * 2^23: next to it floats are whole numbers
    int32_t bits, most_bits, k;
    memcpy(&bits, &t, sizeof bits);
    memcpy(&most_bits, &most, sizeof most_bits);
    bits = bits < most_bits ? bits : most_bits;
    memcpy(&t, &bits, sizeof t);

    const float rounded = t + whole; // its last bits are the nearest whole number k
    const float f = (rounded - whole) - t;
    float p = 1.327644276e-3f;
    p = sheen_mad(p, f, 9.675541101e-3f, fused);
    p = sheen_mad(p, f, 5.550713364e-2f, fused);
    p = sheen_mad(p, f, 2.402211973e-1f, fused);
    p = sheen_mad(p, f, 6.93146967e-1f, fused);
    p = sheen_mad(p, f, 1.000000072f, fused);
    memcpy(&k, &rounded, sizeof k);
    memcpy(&bits, &p, sizeof bits);
    bits -= (int32_t)((uint32_t)k << 23); // times 2^-k
    memcpy(&p, &bits, sizeof p);
    return p;
}

// x > 0 ? weight : 0, selected as integers.
SHEEN_KERNEL_INLINE float sheen_if_positive(float x, float weight)
{
    int32_t sign, bits;
    memcpy(&sign, &x, sizeof sign);
    memcpy(&bits, &weight, sizeof bits);
    bits = sign > 0 ? bits : 0;
    memcpy(&weight, &bits, sizeof weight);
    return weight;
}

// sum_l weight_l exp(-alpha_l^2 / (2 sigma^2)) over lights above the horizon; n.v > 0.
SHEEN_KERNEL_INLINE float sheen_lobe_sum_wide(const sheen_lights *lights, const float n[3], const float v[3],
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
        sum += sheen_if_positive(n_dot_l, weight[i]) *
               sheen_exp2_minus(sheen_alpha2_of(x, fused) * per_alpha2, fused);
    }
    return sum;
}

// The same for a lobe that ends within the range of sheen_sine2_alpha2. s = l + v has the part d = n.s along n and u across
// it, and sin(alpha)^2 = |u|^2 / (|u|^2 + d^2): no root, and no cancelling near the highlight.
SHEEN_KERNEL_INLINE float sheen_lobe_sum_narrow(const sheen_lights *lights, const float n[3],
                                                const float v[3], float sigma_rad, int fused)
{
    const float *restrict dx = lights->dx;
    const float *restrict dy = lights->dy;
    const float *restrict dz = lights->dz;
    const float *restrict weight = lights->weight;
    const size_t count = lights->count;
    const float nx = n[0], ny = n[1], nz = n[2];
    const float vx = v[0], vy = v[1], vz = v[2], n_dot_v = nx * vx + ny * vy + nz * vz;
    const float per_alpha2 = 0.721347520f / (sigma_rad * sigma_rad);
    float sum = 0;
#pragma omp simd reduction(+ : sum)
    for (size_t i = 0; i < count; i++) {
        const float lx = dx[i], ly = dy[i], lz = dz[i];
        const float n_dot_l = sheen_mad(nx, lx, sheen_mad(ny, ly, nz * lz, fused), fused);
        const float d = n_dot_l + n_dot_v;
        const float ux = sheen_mad(-d, nx, lx + vx, fused), uy = sheen_mad(-d, ny, ly + vy, fused),
                    uz = sheen_mad(-d, nz, lz + vz, fused);
        const float u2 = sheen_mad(ux, ux, sheen_mad(uy, uy, uz * uz, fused), fused);
        const float y = u2 / sheen_mad(d, d, u2, fused);
        sum = sheen_add_product(sum, sheen_if_positive(n_dot_l, weight[i]),
                                sheen_exp2_minus(sheen_sine2_alpha2(y, per_alpha2, fused), fused), fused);
    }
    return sum;
}

SHEEN_KERNEL_INLINE float sheen_lobe_sum_body(const sheen_lights *lights, const float n[3], const float v[3],
                                              float sigma_rad, int fused)
{
    return sigma_rad <= SHEEN_LOBE_NARROW_RAD ? sheen_lobe_sum_narrow(lights, n, v, sigma_rad, fused)
                                              : sheen_lobe_sum_wide(lights, n, v, sigma_rad, fused);
}

#endif

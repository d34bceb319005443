// SPDX-License-Identifier: Apache-2.0
// lamp.c - responses of lamps (the formula in lamp.h), a vector of points at a time; written like lobe.c.
#include "render/lamp.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/cpu_level.h"
#include "base/vec.h"
#include "render/lobe.h"
#include "render/lobe_math.h"

enum { LANES = 16, AT_A_TIME = 64 };

// In alpha v.h, beyond which a disc is a point: seen at a slant, a small move of the light turns the bisector more.
static const float far_sigmas = 6, far_radii = 0.75f;

static const float golden_rad = 2.39996323f;

size_t sheen_lamp_point_count(float radius_rad, float sigma_rad)
{
    const float ratio = radius_rad / sigma_rad;
    return ratio < 0.05f ? 1 : ratio < 1 ? 8 : ratio < 2 ? 16 : ratio < 4 ? 32 : ratio < 8 ? 64 : 128;
}

static void disc_point(float out[3], const sheen_lamp *lamp, const float a[3], const float b[3], size_t k,
                       size_t n)
{
    const float r = n > 1 ? lamp->radius_rad * sqrtf(((float)k + 0.5f) / (float)n) : 0,
                turn = golden_rad * (float)k;
    for (int i = 0; i < 3; i++)
        out[i] = lamp->direction_world[i] + r * (cosf(turn) * a[i] + sinf(turn) * b[i]);
}

static void place_points(sheen_lamp_points *p, size_t i, const sheen_lamp *lamp, size_t n)
{
    float a[3], b[3];
    sheen_axes_aboutf(a, b, lamp->direction_world);
    for (size_t k = 0; k < n; k++) {
        float d[3];
        const size_t at = p->first[i] + k;
        disc_point(d, lamp, a, b, k, n);
        p->dx[at] = d[0];
        p->dy[at] = d[1];
        p->dz[at] = d[2];
        p->inverse_distance[at] = lamp->inverse_distance_per_m;
        p->share[at] = 1 / (float)n;
    }
}

static sheen_status make_points(sheen_lamp_points *out, const sheen_lamp *lamps, size_t n, float sigma_rad,
                                int as_points, sheen_err *err)
{
    *out = (sheen_lamp_points){.n_lamps = n};
    size_t total = 0;
    out->first = malloc((n + 1) * sizeof *out->first);
    out->far_alpha2 = malloc((n + 1) * sizeof *out->far_alpha2);
    if (!out->first || !out->far_alpha2)
        return sheen_fail_memory(err, 12.0 * (double)n, "lamps");
    for (size_t i = 0; i < n; i++) {
        const float far_alpha = far_sigmas * sigma_rad + far_radii * lamps[i].radius_rad;
        out->far_alpha2[i] = far_alpha * far_alpha;
        out->first[i] = total;
        total += as_points ? 1 : sheen_lamp_point_count(lamps[i].radius_rad, sigma_rad);
    }
    out->first[n] = total;
    out->n_points = total;
    float **arrays[] = {&out->dx, &out->dy, &out->dz, &out->inverse_distance, &out->share};
    for (size_t k = 0; k < 5; k++)
        if (!(*arrays[k] = calloc(total + LANES, sizeof(float))))
            return sheen_fail_memory(err, 20.0 * (double)total, "the points of lamps");
    for (size_t i = 0; i < n; i++)
        place_points(out, i, &lamps[i], out->first[i + 1] - out->first[i]);
    return SHEEN_OK;
}

sheen_status sheen_lamp_points_init(sheen_lamp_points *out, const sheen_lamp *lamps, size_t n,
                                    float sigma_rad, sheen_err *err)
{
    sheen_status s = make_points(out, lamps, n, sigma_rad, 0, err);
    if (!s && !(out->middles = malloc(sizeof *out->middles)))
        s = sheen_fail_memory(err, 100, "lamps");
    if (!s)
        s = make_points(out->middles, lamps, n, sigma_rad, 1, err);
    if (s)
        sheen_lamp_points_release(out);
    return s;
}

void sheen_lamp_points_release(sheen_lamp_points *p)
{
    if (p->middles)
        sheen_lamp_points_release(p->middles);
    free(p->middles);
    free(p->dx);
    free(p->dy);
    free(p->dz);
    free(p->inverse_distance);
    free(p->share);
    free(p->first);
    free(p->far_alpha2);
    *p = (sheen_lamp_points){0};
}

// What the terms of one surface point have in common.
typedef struct place {
    float x[3], n[3], v[3];
    float per_alpha2; // exp(-a / (2 s^2)) = 2^-(a log2(e) / (2 s^2))
    float per_tail;   // 1 / (4 s^2)
    float gauss, tail, fresnel;
} place;

SHEEN_KERNEL_INLINE void terms_body(float *restrict term, float *restrict alpha2,
                                    const sheen_lamp_points *points, size_t begin, size_t count,
                                    const place *q, int fused)
{
    const float *restrict dx = points->dx + begin;
    const float *restrict dy = points->dy + begin;
    const float *restrict dz = points->dz + begin;
    const float *restrict rho = points->inverse_distance + begin;
    const float *restrict share = points->share + begin;
    const float x = q->x[0], y = q->x[1], z = q->x[2], nx = q->n[0], ny = q->n[1], nz = q->n[2];
    const float vx = q->v[0], vy = q->v[1], vz = q->v[2];
    const float per_alpha2 = q->per_alpha2, per_tail = q->per_tail;
    const float gauss = q->gauss, tail = q->tail, fresnel = q->fresnel;
    // Whole vectors: the arrays are longer by LANES, and what is computed beyond count nobody reads
    const size_t whole = (count + LANES - 1) / LANES * LANES;
#pragma omp simd
    for (size_t i = 0; i < whole; i++) {
        const float Lx = sheen_mad(-rho[i], x, dx[i], fused), Ly = sheen_mad(-rho[i], y, dy[i], fused),
                    Lz = sheen_mad(-rho[i], z, dz[i], fused);
        const float L2 = sheen_mad(Lx, Lx, sheen_mad(Ly, Ly, sheen_mad(Lz, Lz, 1e-12f, fused), fused), fused);
        const float inv_L = 1.0f / sqrtf(L2);
        const float lx = Lx * inv_L, ly = Ly * inv_L, lz = Lz * inv_L;
        const float n_dot_l = sheen_mad(nx, lx, sheen_mad(ny, ly, nz * lz, fused), fused);
        const float hx = lx + vx, hy = ly + vy, hz = lz + vz;
        const float h2 = sheen_mad(hx, hx, sheen_mad(hy, hy, sheen_mad(hz, hz, 1e-12f, fused), fused), fused);
        const float inv_h = 1.0f / sqrtf(h2);
        const float ex = sheen_mad(-hx, inv_h, nx, fused), ey = sheen_mad(-hy, inv_h, ny, fused),
                    ez = sheen_mad(-hz, inv_h, nz, fused);
        const float half = 0.5f * sheen_mad(ex, ex, sheen_mad(ey, ey, ez * ez, fused), fused);
        const float a2 = sheen_alpha2_of(half, fused);
        alpha2[i] = a2 * 0.25f * h2; // times (v.h)^2
        const float wide = 1.0f / sheen_mad(a2, per_tail, 1.0f, fused);
        const float lobe = sheen_mad(gauss, sheen_exp2_minus(a2 * per_alpha2, fused), tail * wide * wide,
                                     fused);
        const float u = 1.0f - 0.5f * h2 * inv_h, u2 = u * u; // v.h = |v + l| / 2
        const float lit = n_dot_l > 0.0f ? 1.0f : 0.0f;
        term[i] = lit * share[i] * inv_L * inv_L * lobe * sheen_mad(fresnel, u2 * u2 * u, 1.0f, fused);
    }
}

static void terms_baseline(float *term, float *alpha2, const sheen_lamp_points *p, size_t begin, size_t count,
                           const place *q)
{
    terms_body(term, alpha2, p, begin, count, q, 0);
}

#if defined(__x86_64__)
SHEEN_TARGET_AVX2 static void terms_avx2(float *term, float *alpha2, const sheen_lamp_points *p, size_t begin,
                                         size_t count, const place *q)
{
    terms_body(term, alpha2, p, begin, count, q, 1);
}

SHEEN_TARGET_AVX512 static void terms_avx512(float *term, float *alpha2, const sheen_lamp_points *p,
                                             size_t begin, size_t count, const place *q)
{
    terms_body(term, alpha2, p, begin, count, q, 1);
}
#endif

static void terms(float *term, float *alpha2, const sheen_lamp_points *p, size_t begin, size_t count,
                  const place *q)
{
#if defined(__x86_64__)
    const int level = sheen_cpu_level();
    if (level >= SHEEN_CPU_AVX512) {
        terms_avx512(term, alpha2, p, begin, count, q);
        return;
    }
    if (level == SHEEN_CPU_AVX2) {
        terms_avx2(term, alpha2, p, begin, count, q);
        return;
    }
#endif
    terms_baseline(term, alpha2, p, begin, count, q);
}

static float sum_of_terms(const sheen_lamp_points *p, size_t begin, size_t count, const place *q)
{
    float term[SHEEN_LAMP_MAX_POINTS], alpha2[SHEEN_LAMP_MAX_POINTS], sum = 0;
    terms(term, alpha2, p, begin, count, q);
    for (size_t k = 0; k < count; k++)
        sum += term[k];
    return sum;
}

void sheen_lamp_responses(float *response, const sheen_lamp_points *p, size_t begin, size_t n,
                          const sheen_lobe_shape *lobe, const float x_m[3], const float n_world[3],
                          const float v_world[3])
{
    memset(response, 0, n * sizeof *response);
    if (!(sheen_dotf(n_world, v_world) > 0))
        return;
    const float inverse_variance = 1 / (lobe->sigma_rad * lobe->sigma_rad);
    place q = {.per_alpha2 = 0.721347520f * inverse_variance,
               .per_tail = 0.25f * inverse_variance,
               .gauss = 1 - lobe->tail,
               .tail = lobe->tail,
               .fresnel = lobe->fresnel};
    memcpy(q.x, x_m, sizeof q.x);
    memcpy(q.n, n_world, sizeof q.n);
    memcpy(q.v, v_world, sizeof q.v);
    const float inverse_cos = sheen_lobe_inverse_cos(n_world, v_world);
    for (size_t done = 0; done < n; done += AT_A_TIME) {
        float middle[AT_A_TIME], alpha2[AT_A_TIME]; // whole vectors
        const size_t n_now = n - done < AT_A_TIME ? n - done : AT_A_TIME;
        terms(middle, alpha2, p->middles, begin + done, n_now, &q);
        for (size_t i = 0; i < n_now; i++) {
            const size_t lamp = begin + done + i, n_points = p->first[lamp + 1] - p->first[lamp];
            if (n_points > 1 && alpha2[i] < p->far_alpha2[lamp])
                middle[i] = sum_of_terms(p, p->first[lamp], n_points, &q);
            response[done + i] = inverse_cos * middle[i];
        }
    }
}

// An angle is at most this many times its chord, up to a chord of 1; and an arc sine its sine, up to 1/2.
static const float angle_per_chord = 1.05f;

// The angle at any point from the middle's: alpha >= alpha_middle - (n's turn) - (h's turn), h = l + v, where |dh| <= |dl| + |dv|.
float sheen_lamp_response_bound(const sheen_lamp *lamp, const sheen_lobe_shape *lobe,
                                const sheen_lamp_patch *patch)
{
    float n[3], v[3], l[3], h[3], apart[3];
    memcpy(n, patch->n_world, sizeof n);
    memcpy(v, patch->v_world, sizeof v);
    // What a unit vector differs from the mean's direction by is at most twice what it differs from the mean
    const float n_turn = 2 * patch->n_reach, v_turn = 2 * patch->v_reach;
    for (int i = 0; i < 3; i++)
        l[i] = lamp->direction_world[i] - lamp->inverse_distance_per_m * patch->x_m[i];
    const float L = sheen_normalizef(l),
                L_reach = lamp->radius_rad + lamp->inverse_distance_per_m * patch->x_reach_m;
    if (!(L > 2 * L_reach) || !(sheen_normalizef(n) > 0) || !(sheen_normalizef(v) > 0))
        return HUGE_VALF;
    for (int i = 0; i < 3; i++)
        h[i] = l[i] + v[i];
    const float H = sheen_normalizef(h), H_reach = angle_per_chord * L_reach / L + v_turn;
    if (!(H > 2 * H_reach) || n_turn > 0.5f)
        return HUGE_VALF;
    sheen_subf(apart, n, h);
    const float turn = angle_per_chord * (n_turn + H_reach / H);
    const float alpha = fmaxf(0, sqrtf(sheen_dotf(apart, apart)) - turn) / lobe->sigma_rad;
    const float wide = 1 / (1 + 0.25f * alpha * alpha);
    const float value = (1 - lobe->tail) * expf(-0.5f * alpha * alpha) + lobe->tail * wide * wide;
    const float least_cos = fmaxf(SHEEN_LOBE_MIN_COS, sheen_dotf(n, v) - n_turn - v_turn);
    // A little more, for what rounding may do
    return 1.01f * (1 + lobe->fresnel) * value / (least_cos * (L - L_reach) * (L - L_reach));
}

static double response_ref(const sheen_lamp *lamp, const sheen_lobe_shape *lobe, const float x_m[3],
                           const double n[3], const double v[3])
{
    const double sigma = (double)lobe->sigma_rad, tail = (double)lobe->tail;
    const size_t n_points = sheen_lamp_point_count(lamp->radius_rad, lobe->sigma_rad);
    float a[3], b[3];
    sheen_axes_aboutf(a, b, lamp->direction_world);
    double sum = 0;
    for (size_t k = 0; k < n_points; k++) {
        float d[3];
        double L[3], h[3], across[3];
        disc_point(d, lamp, a, b, k, n_points);
        for (int i = 0; i < 3; i++)
            L[i] = (double)d[i] - (double)lamp->inverse_distance_per_m * (double)x_m[i];
        const double length = sheen_normalize(L);
        if (!(sheen_dot(n, L) > 0))
            continue;
        for (int i = 0; i < 3; i++)
            h[i] = L[i] + v[i];
        sheen_normalize(h);
        sheen_cross(across, n, h);
        const double angle = atan2(sheen_norm(across), sheen_dot(n, h)), q = angle * angle / (sigma * sigma);
        const double wide = 1 / (1 + q / 4);
        const double F = 1 + (double)lobe->fresnel * pow(1 - sheen_dot(v, h), 5);
        sum += F * ((1 - tail) * exp(-q / 2) + tail * wide * wide) / (length * length);
    }
    return sum / (double)n_points;
}

void sheen_lamp_responses_ref(double *response, const sheen_lamp *lamps, size_t n,
                              const sheen_lobe_shape *lobe, const float x_m[3], const float n_world[3],
                              const float v_world[3])
{
    double nd[3], vd[3];
    for (int i = 0; i < 3; i++) {
        nd[i] = (double)n_world[i];
        vd[i] = (double)v_world[i];
    }
    const double cos_r = sheen_dot(nd, vd), least = (double)SHEEN_LOBE_MIN_COS;
    for (size_t i = 0; i < n; i++)
        response[i] = cos_r > 0 ? response_ref(&lamps[i], lobe, x_m, nd, vd) / fmax(cos_r, least) : 0;
}

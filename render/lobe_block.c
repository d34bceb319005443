// SPDX-License-Identifier: Apache-2.0
// lobe_block.c - the lobe's sum over many neighbouring samples.
//
// A narrow lobe reaches few lights. Up to 64 samples whose mirror directions lie together share one list of
// them, and a vector holds one light's terms at all of them.
//
// A wide lobe reaches hundreds of lights, but is then smooth over many pixels. For a group of samples about their mean normal n0 and view direction v0,
//
//     S(n, v) = sum_l w_l e^{E_l},  E = -alpha^2 / (2 sigma^2) = -P(x) / (2 sigma^2),  x = 1 - c,  c = n.h,
//
// with P as in lobe_math.h. c is linear in n, and dc/dv = (n - c h) / |l + v|. One pass over the lights sums
// S, its gradients in n (two tangents) and v, and its second derivatives in n. These give the expansion
//
//     ln S = ln S0 + g.d + d'H d / 2,
//
// exact for one light up to the third order of the angles, and for many where they act as one lobe or none.
// Lights that only part of the group has above its horizon are left out and added sample by sample. The result
// is checked against the sum itself at the four samples whose normals lie farthest out; a group that fails, or
// whose normals differ by more than SPREAD_SIGMA sigma, is cut in four.
#include "render/lobe_block.h"

#include <assert.h>
#include <math.h>

#include "render/light_cells.h"
#include "render/lobe_math.h"

// Below so many samples, or so many lights, summing each is cheaper than expanding.
enum {
    LEAST_SAMPLES = 6,
    LEAST_LIGHTS = 96,
    MAX_HORIZON = 256,
    LANES = 16,
    MAX_REACHED = 2048,
    NARROW_GROUP = 4 * LANES
};
#define SPREAD_SIGMA 1.0f
#define RELATIVE_TOLERANCE 1e-3f
#define LOG2_E 1.442695041f
// Lists of a drawing's cells reach further by as many sigma: by the second up to so many radians in all.
#define LEAST_MARGIN_SIGMA 3.0f
#define MOST_MARGIN_SIGMA 9.0f
#define MOST_MARGIN_RAD 0.3f

// The samples [begin, end) of a block, and the expansion about their mean.
typedef struct group {
    int begin, end;
    int extreme[4];                             // samples: the farthest along and against both tangents
    float n0[3], v0[3], across1[3], across2[3]; // the last two span n0's tangent plane
    float spread, spread_v;                     // greatest |n - n0|, |v - v0|
} group;

typedef struct sums {
    float s, g1, g2, vx, vy, vz, h11, h12, h22;
    float horizon; // sum of the terms, left out of the others, whose light some samples may have below them
} sums;

static void mean_of(float out[3], const float *x, const float *y, const float *z, int begin, int end)
{
    float sx = 0, sy = 0, sz = 0;
#pragma omp simd reduction(+ : sx, sy, sz)
    for (int i = begin; i < end; i++) {
        sx += x[i];
        sy += y[i];
        sz += z[i];
    }
    out[0] = sx;
    out[1] = sy;
    out[2] = sz;
    sheen_normalizef(out);
}

// Non-negative floats order like their bits, and gcc 12 makes no branch of integers.
SHEEN_KERNEL_INLINE int32_t bits_of(float x)
{
    int32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

SHEEN_KERNEL_INLINE float root_of_bits(int32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return sqrtf(x);
}

// Greatest distances from n0 and v0.
SHEEN_KERNEL_INLINE void spreads_of(group *g, const sheen_lobe_block *b)
{
    int32_t most_n = 0, most_v = 0;
#pragma omp simd reduction(max : most_n, most_v)
    for (int i = g->begin; i < g->end; i++) {
        const float nx = b->nx[i] - g->n0[0], ny = b->ny[i] - g->n0[1], nz = b->nz[i] - g->n0[2];
        const float vx = b->vx[i] - g->v0[0], vy = b->vy[i] - g->v0[1], vz = b->vz[i] - g->v0[2];
        const int32_t n2 = bits_of(nx * nx + ny * ny + nz * nz), v2 = bits_of(vx * vx + vy * vy + vz * vz);
        most_n = n2 > most_n ? n2 : most_n;
        most_v = v2 > most_v ? v2 : most_v;
    }
    g->spread = root_of_bits(most_n);
    g->spread_v = root_of_bits(most_v);
}

SHEEN_KERNEL_INLINE group group_of(const sheen_lobe_block *b, int begin, int end)
{
    group g = {.begin = begin, .end = end};
    mean_of(g.n0, b->nx, b->ny, b->nz, begin, end);
    mean_of(g.v0, b->vx, b->vy, b->vz, begin, end);
    // Any vector that is not along n0 serves for the tangents.
    const float other[3] = {fabsf(g.n0[0]) < 0.6f ? 1.0f : 0.0f, fabsf(g.n0[0]) < 0.6f ? 0.0f : 1.0f, 0};
    sheen_crossf(g.across1, g.n0, other);
    sheen_normalizef(g.across1);
    sheen_crossf(g.across2, g.n0, g.across1);
    spreads_of(&g, b);
    return g;
}

// The samples that lie farthest along and against both tangents; these are square to n0. A key has a distance of at most 2 to
// 5e-7, and below it, in its last eight bits, whose it is: the greatest key is found without a branch.
SHEEN_KERNEL_INLINE void find_extremes(group *g, const sheen_lobe_block *b)
{
    const float steps = 1 << 21;
    const float ax = steps * g->across1[0], ay = steps * g->across1[1], az = steps * g->across1[2];
    const float cx = steps * g->across2[0], cy = steps * g->across2[1], cz = steps * g->across2[2];
    int32_t along1 = INT32_MIN, against1 = INT32_MIN, along2 = INT32_MIN, against2 = INT32_MIN;
#pragma omp simd reduction(max : along1, against1, along2, against2)
    for (int i = g->begin; i < g->end; i++) {
        const int32_t d1 = (int32_t)(b->nx[i] * ax + b->ny[i] * ay + b->nz[i] * az) * SHEEN_LOBE_BLOCK;
        const int32_t d2 = (int32_t)(b->nx[i] * cx + b->ny[i] * cy + b->nz[i] * cz) * SHEEN_LOBE_BLOCK;
        along1 = d1 + i > along1 ? d1 + i : along1;
        against1 = i - d1 > against1 ? i - d1 : against1;
        along2 = d2 + i > along2 ? d2 + i : along2;
        against2 = i - d2 > against2 ? i - d2 : against2;
    }
    const int32_t keys[4] = {along1, against1, along2, against2};
    for (int k = 0; k < 4; k++)
        g->extreme[k] = keys[k] & (SHEEN_LOBE_BLOCK - 1);
}

// The lights of a list that can count at some sample of a group.
typedef struct reached {
    uint16_t index[MAX_REACHED + LANES];
    size_t count;
} reached;

// A sample's n differs from n0 by spread, and its bisector of v and l from that of v0 and l by at most
// 2 spread_v / |l + v0|: alpha changes by no more than both. A light counts up to 5 sigma, so it does at no
// sample unless |n0 x (l + v0)| = sin(alpha0) |l + v0| is below (5 sigma + spread) |l + v0| + 2 spread_v.
SHEEN_KERNEL_INLINE void find_reached(reached *out, const sheen_lights *list, const group *g, float sigma_rad,
                                      int fused)
{
    const float nx = g->n0[0], ny = g->n0[1], nz = g->n0[2], vx = g->v0[0], vy = g->v0[1], vz = g->v0[2];
    const float reach = SHEEN_LOBE_REACH_SIGMA * sigma_rad + 1.05f * g->spread, by_v = 2 * g->spread_v;
    const float horizon = -1.05f * g->spread;
    size_t n = 0;
    for (size_t begin = 0; begin < list->count; begin += LANES) { // lists are whole vectors
        const float *dx = list->dx + begin, *dy = list->dy + begin, *dz = list->dz + begin,
                    *weight = list->weight + begin;
        uint16_t counts[LANES];
#pragma omp simd
        for (int i = 0; i < LANES; i++) {
            const float n_dot_l = sheen_mad(nx, dx[i], sheen_mad(ny, dy[i], nz * dz[i], fused), fused);
            const float sx = dx[i] + vx, sy = dy[i] + vy, sz = dz[i] + vz;
            const float cx = sheen_mad(ny, sz, -nz * sy, fused), cy = sheen_mad(nz, sx, -nx * sz, fused),
                        cz = sheen_mad(nx, sy, -ny * sx, fused);
            const float across2 = sheen_mad(cx, cx, sheen_mad(cy, cy, cz * cz, fused), fused);
            const float length2 = sheen_mad(sx, sx, sheen_mad(sy, sy, sz * sz, fused), fused);
            const float most = sheen_mad(reach, sqrtf(length2), by_v, fused);
            counts[i] = (across2 <= most * most) & (n_dot_l >= horizon) & (weight[i] > 0);
        }
        for (int i = 0; i < LANES; i++) {
            out->index[n] = (uint16_t)(begin + (size_t)i);
            n += counts[i];
        }
    }
    out->count = n;
}

// Copies of them, for loops over lights.
typedef struct near_lights {
    _Alignas(64) float dx[MAX_REACHED + LANES];
    float dy[MAX_REACHED + LANES], dz[MAX_REACHED + LANES], weight[MAX_REACHED + LANES];
    sheen_lights lights; // the arrays above, or the list itself where it is longer
} near_lights;

SHEEN_KERNEL_INLINE void copy_reached(near_lights *out, const sheen_lights *list, const group *g,
                                      float sigma_rad, int fused)
{
    reached found;
    out->lights = *list;
    if (list->count > MAX_REACHED)
        return;
    find_reached(&found, list, g, sigma_rad, fused);
    const size_t whole = (found.count + LANES - 1) / LANES * LANES;
    for (size_t i = 0; i < whole; i++) { // the last vector is filled up with a light of no weight
        const size_t k = i < found.count ? found.index[i] : 0;
        out->dx[i] = list->dx[k];
        out->dy[i] = list->dy[k];
        out->dz[i] = list->dz[k];
        out->weight[i] = i < found.count ? list->weight[k] : 0;
    }
    out->lights = (sheen_lights){out->dx, out->dy, out->dz, out->weight, whole};
}

// P'(x) and P''(x) of lobe_alpha2; to 1e-5, which is enough for derivatives.
SHEEN_KERNEL_INLINE void slopes_of(float *first, float *second, float x, int fused)
{
    float p = 6.451978477e-2f;
    p = sheen_mad(p, x, -6.35801412e-2f, fused);
    p = sheen_mad(p, x, 1.085629239e-1f, fused);
    p = sheen_mad(p, x, 9.638229544e-2f, fused);
    p = sheen_mad(p, x, 2.690728304e-1f, fused);
    p = sheen_mad(p, x, 6.6656062e-1f, fused);
    *first = sheen_mad(p, x, 2.000000567f, fused);
    float q = 3.871187086e-1f;
    q = sheen_mad(q, x, -3.17900706e-1f, fused);
    q = sheen_mad(q, x, 4.342516956e-1f, fused);
    q = sheen_mad(q, x, 2.891468863e-1f, fused);
    q = sheen_mad(q, x, 5.381456608e-1f, fused);
    *second = sheen_mad(q, x, 6.6656062e-1f, fused);
}

SHEEN_KERNEL_INLINE sums expand(const group *g, const sheen_lights *lights, float sigma_rad, int fused)
{
    const float *restrict dx = lights->dx;
    const float *restrict dy = lights->dy;
    const float *restrict dz = lights->dz;
    const float *restrict weight = lights->weight;
    const float nx = g->n0[0], ny = g->n0[1], nz = g->n0[2], vx = g->v0[0], vy = g->v0[1], vz = g->v0[2];
    const float ax = g->across1[0], ay = g->across1[1], az = g->across1[2];
    const float bx = g->across2[0], by = g->across2[1], bz = g->across2[2];
    const float half = 0.5f / (sigma_rad * sigma_rad), spread = g->spread;
    float s = 0, g1 = 0, g2 = 0, sx = 0, sy = 0, sz = 0, h11 = 0, h12 = 0, h22 = 0, horizon = 0;
#pragma omp simd reduction(+ : s, g1, g2, sx, sy, sz, h11, h12, h22, horizon)
    for (size_t i = 0; i < lights->count; i++) {
        const float lx = dx[i], ly = dy[i], lz = dz[i];
        const float n_dot_l = sheen_mad(nx, lx, sheen_mad(ny, ly, nz * lz, fused), fused);
        float hx = lx + vx, hy = ly + vy, hz = lz + vz;
        const float h2 = sheen_mad(hx, hx, sheen_mad(hy, hy, sheen_mad(hz, hz, 1e-12f, fused), fused), fused);
        const float inv_h = 1.0f / sqrtf(h2);
        hx *= inv_h;
        hy *= inv_h;
        hz *= inv_h;
        const float ex = nx - hx, ey = ny - hy, ez = nz - hz;
        const float x = 0.5f * sheen_mad(ex, ex, sheen_mad(ey, ey, ez * ez, fused), fused), c = 1 - x;
        const float all = weight[i] * sheen_exp2_minus(sheen_alpha2_of(x, fused) * (half * LOG2_E), fused);
        const float above = n_dot_l > spread ? 1.0f : 0.0f, below = n_dot_l < -spread ? 1.0f : 0.0f;
        const float term = above * all;
        float p1, p2;
        slopes_of(&p1, &p2, x, fused);
        const float k = half * p1, m = half * p2, tk = term * k; // dE/dc = k, d2E/dc2 = -m
        const float h1 = sheen_mad(ax, hx, sheen_mad(ay, hy, az * hz, fused), fused);
        const float hb = sheen_mad(bx, hx, sheen_mad(by, hy, bz * hz, fused), fused);
        const float bend = term * (k * k - m);
        s += term;
        g1 += tk * h1;
        g2 += tk * hb;
        const float tv = tk * inv_h;
        sx += tv * sheen_mad(-c, hx, nx, fused);
        sy += tv * sheen_mad(-c, hy, ny, fused);
        sz += tv * sheen_mad(-c, hz, nz, fused);
        // n runs on a sphere: along the tangent plane it also sinks by d^2 / 2, and c by c d^2 / 2.
        h11 += sheen_mad(bend * h1, h1, -tk * c, fused);
        h12 += bend * h1 * hb;
        h22 += sheen_mad(bend * hb, hb, -tk * c, fused);
        horizon += (1 - above - below) * all;
    }
    return (sums){s, g1, g2, sx, sy, sz, h11, h12, h22, horizon};
}

// S at every sample of the group by the expansion. A term depends on how n stands to its light's bisector h, and where the view
// turns by dv, the h of lights near the mirror direction turn by dv / (2 n0.v0): to the second order that counts as n turned back.
SHEEN_KERNEL_INLINE void extrapolate(sheen_lobe_block *b, const group *g, const sums *at, int fused)
{
    const float over = 1 / at->s;
    const float g1 = at->g1 * over, g2 = at->g2 * over;
    const float gx = at->vx * over, gy = at->vy * over, gz = at->vz * over;
    const float h11 = 0.5f * (at->h11 * over - g1 * g1), h12 = at->h12 * over - g1 * g2,
                h22 = 0.5f * (at->h22 * over - g2 * g2);
    const float most = 16; // a sum that grows by more within a group fails the check
    const float cos_r = sheen_dotf(g->n0, g->v0),
                back = 0.5f / (cos_r > SHEEN_LOBE_MIN_COS ? cos_r : SHEEN_LOBE_MIN_COS);
    const float *a = g->across1, *c = g->across2;
    const float scale = at->s * (float)(1 << 16);
#pragma omp simd
    for (int i = g->begin; i < g->end; i++) {
        const float dx = b->nx[i] - g->n0[0], dy = b->ny[i] - g->n0[1], dz = b->nz[i] - g->n0[2];
        const float ux = b->vx[i] - g->v0[0], uy = b->vy[i] - g->v0[1], uz = b->vz[i] - g->v0[2];
        const float d1 = a[0] * dx + a[1] * dy + a[2] * dz, d2 = c[0] * dx + c[1] * dy + c[2] * dz;
        const float e1 = d1 - back * (a[0] * ux + a[1] * uy + a[2] * uz),
                    e2 = d2 - back * (c[0] * ux + c[1] * uy + c[2] * uz);
        const float first = g1 * d1 + g2 * d2 + gx * ux + gy * uy + gz * uz;
        const float exponent = first + e1 * (h11 * e1 + h12 * e2) + h22 * e2 * e2;
        const float below = most - exponent * LOG2_E;
        b->sum[i] = scale * sheen_exp2_minus(below > 0 ? below : 0, fused);
    }
}

SHEEN_KERNEL_INLINE float sum_at(const sheen_lobe_block *b, int i, const sheen_light_cells *cells, int fused)
{
    const float n[3] = {b->nx[i], b->ny[i], b->nz[i]}, v[3] = {b->vx[i], b->vy[i], b->vz[i]};
    float r[3];
    sheen_mirrorf(r, n, v);
    const sheen_lights near = sheen_lights_near(cells, r);
    return near.count ? sheen_lobe_sum_body(&near, n, v, cells->sigma_rad, fused) : 0;
}

SHEEN_KERNEL_INLINE float sum_of(const sheen_lobe_block *b, int i, const sheen_lights *lights,
                                 float sigma_rad, int fused)
{
    const float n[3] = {b->nx[i], b->ny[i], b->nz[i]}, v[3] = {b->vx[i], b->vy[i], b->vz[i]};
    return sheen_lobe_sum_body(lights, n, v, sigma_rad, fused);
}

// Adds the lights which some of the group's normals have below their horizon and some above; 0: too many.
SHEEN_KERNEL_INLINE int add_horizon(sheen_lobe_block *b, const group *g, const sheen_lights *near,
                                    float sigma_rad, int fused)
{
    float dx[MAX_HORIZON], dy[MAX_HORIZON], dz[MAX_HORIZON], weight[MAX_HORIZON];
    sheen_lights some = {dx, dy, dz, weight, 0};
    for (size_t i = 0; i < near->count; i++) {
        const float l[3] = {near->dx[i], near->dy[i], near->dz[i]};
        if (fabsf(sheen_dotf(g->n0, l)) > g->spread)
            continue;
        if (some.count == MAX_HORIZON)
            return 0;
        dx[some.count] = l[0];
        dy[some.count] = l[1];
        dz[some.count] = l[2];
        weight[some.count++] = near->weight[i];
    }
    for (; some.count % LANES; some.count++) { // whole vectors
        dx[some.count] = dy[some.count] = weight[some.count] = 0;
        dz[some.count] = 1;
    }
    for (int i = g->begin; i < g->end; i++) {
        const float n[3] = {b->nx[i], b->ny[i], b->nz[i]}, v[3] = {b->vx[i], b->vy[i], b->vz[i]};
        b->sum[i] += sheen_lobe_sum_body(&some, n, v, sigma_rad, fused);
    }
    return 1;
}

// The expansion, if it holds.
SHEEN_KERNEL_INLINE int by_expansion(sheen_lobe_block *b, group *g, const sheen_lights *near, float sigma_rad,
                                     float tolerance, int fused)
{
    const sums at = expand(g, near, sigma_rad, fused);
    if (at.s > 1e-3f * tolerance)
        extrapolate(b, g, &at, fused);
    else // nothing shines at the middle: the check says whether it does farther out
        memset(b->sum + g->begin, 0, (size_t)(g->end - g->begin) * sizeof *b->sum);
    if (at.horizon > 0.1f * tolerance && !add_horizon(b, g, near, sigma_rad, fused))
        return 0;
    find_extremes(g, b);
    for (int k = 0; k < 4; k++) {
        const float exact = sum_of(b, g->extreme[k], near, sigma_rad, fused);
        if (!(fabsf(b->sum[g->extreme[k]] - exact) <= fmaxf(tolerance, RELATIVE_TOLERANCE * exact)))
            return 0;
    }
    return 1;
}

SHEEN_KERNEL_INLINE void one_by_one(sheen_lobe_block *b, int begin, int end, const sheen_light_cells *cells,
                                    int fused)
{
    for (int i = begin; i < end; i++)
        b->sum[i] = sum_at(b, i, cells, fused);
}

// Whether cutting a group in four, which halves its spread, can still lead to groups worth expanding.
static int worth_cutting(const group *g, float sigma_rad)
{
    float spread = 0.5f * g->spread;
    int count = (g->end - g->begin) / 4;
    for (; count >= LEAST_SAMPLES && spread > SPREAD_SIGMA * sigma_rad; count /= 4)
        spread *= 0.5f;
    return count >= LEAST_SAMPLES;
}

// Whether one list of the cells serves all of a group's samples: a mirror direction turns by at most twice the normal's angle and the
// view's, and a chord is shorter than its arc by 1 % at 30 degrees.
static int shares_list(const group *g, const sheen_light_cells *cells)
{
    const float turn = 2 * g->spread + g->spread_v;
    return !cells->side || (turn <= 0.98f * cells->margin_rad && turn < 0.5f);
}

SHEEN_KERNEL_INLINE void near_of(near_lights *out, const group *g, const sheen_light_cells *cells, int fused)
{
    float r0[3];
    sheen_mirrorf(r0, g->n0, g->v0);
    const sheen_lights list = sheen_lights_near(cells, r0);
    copy_reached(out, &list, g, cells->sigma_rad, fused);
}

// Groups in a list of work, because an inlined function cannot call itself. The lights that a group reaches are
// looked for once, for it and for those that it is cut into, which follow it on the list.
SHEEN_KERNEL_INLINE void sum_wide(sheen_lobe_block *b, const sheen_light_cells *cells, float tolerance,
                                  int fused)
{
    int waiting[64][2] = {{0, b->count}}, n = 1, listed_from = b->count;
    near_lights near;
    near.lights = (sheen_lights){0};
    while (n) {
        const int begin = waiting[n - 1][0], end = waiting[n - 1][1], count = end - begin;
        n--;
        group g = group_of(b, begin, end);
        if (begin < listed_from && shares_list(&g, cells)) {
            near_of(&near, &g, cells, fused);
            listed_from = begin;
        }
        const int listed = begin >= listed_from;
        if (count >= LEAST_SAMPLES && listed && g.spread <= SPREAD_SIGMA * cells->sigma_rad &&
            by_expansion(b, &g, &near.lights, cells->sigma_rad, tolerance, fused))
            continue;
        if (!worth_cutting(&g, cells->sigma_rad)) {
            for (int i = begin; i < end; i++)
                b->sum[i] = listed ? sum_of(b, i, &near.lights, cells->sigma_rad, fused)
                                   : sum_at(b, i, cells, fused);
            continue;
        }
        for (int k = 0; k < 4; k++) {
            waiting[n][0] = begin + count * k / 4;
            waiting[n++][1] = begin + count * (k + 1) / 4;
        }
    }
}

// Adds one light's terms at LANES samples, as sheen_lobe_sum_narrow does those of LANES lights at one.
SHEEN_KERNEL_INLINE void add_light(float sum[LANES], const sheen_lobe_block *b, int begin,
                                   const float n_dot_v[LANES], const float l[3], float weight,
                                   float per_alpha2, int fused)
{
    const float *nx = b->nx + begin, *ny = b->ny + begin, *nz = b->nz + begin;
    const float *vx = b->vx + begin, *vy = b->vy + begin, *vz = b->vz + begin;
#pragma omp simd
    for (int i = 0; i < LANES; i++) {
        const float n_dot_l = sheen_mad(nx[i], l[0], sheen_mad(ny[i], l[1], nz[i] * l[2], fused), fused);
        const float d = n_dot_l + n_dot_v[i];
        const float ux = sheen_mad(-d, nx[i], l[0] + vx[i], fused),
                    uy = sheen_mad(-d, ny[i], l[1] + vy[i], fused),
                    uz = sheen_mad(-d, nz[i], l[2] + vz[i], fused);
        const float u2 = sheen_mad(ux, ux, sheen_mad(uy, uy, uz * uz, fused), fused);
        const float y = u2 / sheen_mad(d, d, u2, fused);
        const float term = sheen_exp2_minus(sheen_sine2_alpha2(y, per_alpha2, fused), fused);
        sum[i] = sheen_mad(sheen_if_positive(n_dot_l, weight), term, sum[i], fused);
    }
}

// The sums at LANES samples.
SHEEN_KERNEL_INLINE void add_lights(sheen_lobe_block *b, int begin, const sheen_lights *list,
                                    const reached *near, float sigma_rad, int fused)
{
    const float per_alpha2 = 0.5f * LOG2_E / (sigma_rad * sigma_rad);
    float sum[LANES] = {0}, n_dot_v[LANES];
    for (int i = 0; i < LANES; i++)
        n_dot_v[i] = b->nx[begin + i] * b->vx[begin + i] + b->ny[begin + i] * b->vy[begin + i] +
                     b->nz[begin + i] * b->vz[begin + i];
    for (size_t i = 0; i < near->count; i++) {
        const size_t k = near->index[i];
        const float l[3] = {list->dx[k], list->dy[k], list->dz[k]};
        add_light(sum, b, begin, n_dot_v, l, list->weight[k], per_alpha2, fused);
    }
    memcpy(b->sum + begin, sum, sizeof sum);
}

// The samples [begin, end), whole vectors, by one list of lights; 0 where their mirror directions lie too far apart.
SHEEN_KERNEL_INLINE int by_lights(sheen_lobe_block *b, int begin, int end, const sheen_light_cells *cells,
                                  int fused)
{
    const int mid = begin + 3 * (end - begin) / 4; // of a square in Morton order: the place after its middle
    group g = {.begin = begin, .end = end, .n0 = {b->nx[mid], b->ny[mid], b->nz[mid]}};
    g.v0[0] = b->vx[mid];
    g.v0[1] = b->vy[mid];
    g.v0[2] = b->vz[mid];
    spreads_of(&g, b);
    if (!shares_list(&g, cells))
        return 0;
    float r0[3];
    sheen_mirrorf(r0, g.n0, g.v0);
    const sheen_lights list = sheen_lights_near(cells, r0);
    reached near;
    if (list.count > MAX_REACHED)
        return 0;
    find_reached(&near, &list, &g, cells->sigma_rad, fused);
    for (int i = begin; i < end; i += LANES)
        add_lights(b, i, &list, &near, cells->sigma_rad, fused);
    return 1;
}

// Fills the last vector up with copies of the last sample.
static void pad(sheen_lobe_block *b)
{
    for (int i = b->count; i % LANES; i++) {
        b->nx[i] = b->nx[b->count - 1];
        b->ny[i] = b->ny[b->count - 1];
        b->nz[i] = b->nz[b->count - 1];
        b->vx[i] = b->vx[b->count - 1];
        b->vy[i] = b->vy[b->count - 1];
        b->vz[i] = b->vz[b->count - 1];
    }
}

// A list serves 8 x 8 samples where it can, else 4 x 4: looking the lights up costs more than the few too many of them.
SHEEN_KERNEL_INLINE void sum_narrow(sheen_lobe_block *b, const sheen_light_cells *cells, int fused)
{
    pad(b);
    const int padded = (b->count + LANES - 1) / LANES * LANES;
    for (int begin = 0, end; begin < padded; begin = end) {
        end = padded - begin < NARROW_GROUP || begin % NARROW_GROUP ? begin + LANES : begin + NARROW_GROUP;
        if (by_lights(b, begin, end, cells, fused))
            continue;
        for (int i = begin; i < end; i += LANES)
            if (end - begin == LANES || !by_lights(b, i, i + LANES, cells, fused))
                one_by_one(b, i, i + LANES < b->count ? i + LANES : b->count, cells, fused);
    }
}

SHEEN_KERNEL_INLINE void sum_block(sheen_lobe_block *b, const sheen_light_cells *cells, float tolerance,
                                   int fused)
{
    if (!b->count)
        return;
    const int mid = b->count / 2;
    const float n_mid[3] = {b->nx[mid], b->ny[mid], b->nz[mid]};
    const float v_mid[3] = {b->vx[mid], b->vy[mid], b->vz[mid]};
    float r_mid[3];
    sheen_mirrorf(r_mid, n_mid, v_mid);
    if (cells->sigma_rad <= SHEEN_LOBE_NARROW_RAD && sheen_lights_near(cells, r_mid).count < LEAST_LIGHTS)
        sum_narrow(b, cells, fused);
    else
        sum_wide(b, cells, tolerance, fused);
#pragma omp simd
    for (int i = 0; i < b->count; i++) {
        const float cos_r = b->nx[i] * b->vx[i] + b->ny[i] * b->vy[i] + b->nz[i] * b->vz[i];
        const float over = cos_r > SHEEN_LOBE_MIN_COS ? cos_r : SHEEN_LOBE_MIN_COS;
        b->sum[i] = sheen_if_positive(cos_r, b->sum[i]) / over;
    }
}

static void sum_baseline(sheen_lobe_block *b, const sheen_light_cells *cells, float tolerance)
{
    sum_block(b, cells, tolerance, 0);
}

#if defined(__x86_64__)
SHEEN_TARGET_AVX2 static void sum_avx2(sheen_lobe_block *b, const sheen_light_cells *cells, float tolerance)
{
    sum_block(b, cells, tolerance, 1);
}

SHEEN_TARGET_AVX512 static void sum_avx512(sheen_lobe_block *b, const sheen_light_cells *cells,
                                           float tolerance)
{
    sum_block(b, cells, tolerance, 1);
}
#endif

sheen_status sheen_lobe_block_cells(sheen_light_cells **out, const sheen_lights *lights, float sigma_rad,
                                    sheen_err *err)
{
    const float most_rad = fminf(MOST_MARGIN_SIGMA * sigma_rad, MOST_MARGIN_RAD);
    return sheen_light_cells_new_wide(out, lights, sigma_rad, fmaxf(LEAST_MARGIN_SIGMA * sigma_rad, most_rad),
                                      err);
}

void sheen_lobe_block_sum_level(sheen_lobe_block *block, const sheen_light_cells *cells, float tolerance,
                                int level)
{
    assert(block->count >= 0 && block->count <= SHEEN_LOBE_BLOCK && tolerance > 0);
#if defined(__x86_64__)
    if (level >= SHEEN_CPU_AVX512) {
        sum_avx512(block, cells, tolerance);
        return;
    }
    if (level == SHEEN_CPU_AVX2) {
        sum_avx2(block, cells, tolerance);
        return;
    }
#endif
    (void)level;
    sum_baseline(block, cells, tolerance);
}

void sheen_lobe_block_sum(sheen_lobe_block *block, const sheen_light_cells *cells, float tolerance)
{
    sheen_lobe_block_sum_level(block, cells, tolerance, sheen_cpu_level());
}

void sheen_lobe_block_sum_ref(sheen_lobe_block *block, const sheen_light_cells *cells)
{
    for (int i = 0; i < block->count; i++) {
        const float n[3] = {block->nx[i], block->ny[i], block->nz[i]};
        const float v[3] = {block->vx[i], block->vy[i], block->vz[i]};
        block->sum[i] = sheen_light_cells_sum(cells, n, v);
    }
}

// SPDX-License-Identifier: Apache-2.0
// raster.c - which triangle each sample of a pinhole's picture sees, by edge functions and a depth buffer.
//
// Rays cost 25 to 50 ns a sample; a triangle of some twenty samples is drawn in less than two of them.
//
//   * An edge function is computed from the edge's ends in the order of their vertex numbers, whichever
//     triangle asks: two neighbours get the same number with opposite signs, so no sample falls between them.
//   * A sample on an edge belongs to both; the nearer, and at the same depth the first, keeps it.
//   * 1/z is linear in the picture. It decides what is nearer, and at the end makes barycentric weights of the
//     picture into those of the triangle (perspective correction).
//   * Most triangles that face away are hidden. They are drawn last, but for those of which every block of samples that
//     they touch is filled with nearer ones. An open mesh, or one turned inside out, looks the same, and takes longer.
//   * The picture is cut into bands of rows. Each lists the triangles that touch it, in the mesh's order, and
//     is drawn by one thread into rows of depths and numbers that stay in its cache, and live no longer.
//
// Samples have whole-numbered places: u = (x + 1/2) n - 1/2 from the window's first, likewise v.
#include "render/raster.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/cpu_level.h"

// Samples that a vector holds; and those of a row that a triangle is drawn over at once: most are narrower than sixteen.
enum { LANES = 16, SPAN = 8, BLOCK = 8 };

// Place in the picture and inverse depth, in one cache line's quarter.
typedef struct vertex {
    float u, v, w, unused;
} vertex;

struct sheen_raster_bands {
    sheen_gbuffer window; // without hits
    const sheen_mesh *mesh;
    vertex *vertices;
    int columns, rows, stride; // samples; stride: columns in whole vectors
    int band_rows, n_bands;
    size_t *
        first; // [2 * n_bands + 1] into listed: a band's triangles that face the camera, then those that face away
    uint32_t *listed; // triangles
    double fxycxy[4];
};

typedef sheen_raster_bands raster;

// The rows [row0, row1) while they are drawn.
typedef struct band {
    int row0, row1;
    float *inverse_z_m; // [row1 - row0][stride]
    uint32_t *triangle; // [row1 - row0][stride]
    float *least; // [rows / BLOCK, rounded up][stride / BLOCK] inverse depths, each the least of a block
} band;

bool sheen_raster_can(const sheen_gbuffer *g, const sheen_camera *cam, const sheen_mesh *mesh,
                      const sheen_projected *at)
{
    if (strcmp(cam->lensmodel, "LENSMODEL_PINHOLE") != 0)
        return false;
    const double reach_px = SHEEN_RASTER_ERROR_PX * (1 << 23) / g->samples_per_side;
    const double x0_px = g->x0_px, y0_px = g->y0_px;
    for (size_t i = 0; i < mesh->n_vertices; i++) // NaN fails
        if (!(fabs(at->q_px[2 * i] - x0_px) < reach_px && fabs(at->q_px[2 * i + 1] - y0_px) < reach_px))
            return false;
    return true;
}

// First and last whole number between the least and the greatest of three, cut to 0..count-1.
SHEEN_KERNEL_INLINE void span_of(int *first, int *last, float a, float b, float c, int count)
{
    const float ab_least = a < b ? a : b, ab_most = a < b ? b : a;
    const float least = ab_least < c ? ab_least : c, most = ab_most > c ? ab_most : c;
    const int cut_least = (int)least, cut_most = (int)most; // towards 0: whole numbers far below 2^31
    const int from = cut_least + ((float)cut_least < least), to = cut_most - ((float)cut_most > most);
    *first = from < 0 ? 0 : from < count ? from : count;
    *last = to < -1 ? -1 : to < count ? to : count - 1;
}

// The lists that a triangle stands in, 2 band + away: the first, and how many (every other one). away: it turns clockwise in the
// picture. In none where it covers no sample's row.
typedef struct places {
    uint32_t list, count;
} places;

static places places_of(const raster *r, size_t triangle)
{
    const uint32_t *corner = r->mesh->triangles + 3 * triangle;
    const vertex *p = r->vertices + corner[0], *q = r->vertices + corner[1], *s = r->vertices + corner[2];
    int first, last;
    span_of(&first, &last, p->v, q->v, s->v, r->rows);
    if (first > last)
        return (places){0};
    const bool away = (q->u - p->u) * (s->v - p->v) - (q->v - p->v) * (s->u - p->u) > 0;
    const int above = first / r->band_rows, count = last / r->band_rows - above + 1;
    return (places){2 * (uint32_t)above + (away ? 1 : 0), (uint32_t)count};
}

// Counts into first[list + 2], sums up, and lists: first[list + 1] runs from the list's begin to its end meanwhile.
static sheen_status list_bands(raster *r, sheen_err *err)
{
    const size_t n = r->mesh->n_triangles;
    const int n_lists = 2 * r->n_bands;
    places *of = malloc((n ? n : 1) * sizeof *of);
    if (!of)
        return sheen_fail_memory(err, 8.0 * (double)n, "a picture's triangles");
    for (size_t t = 0; t < n; t++) {
        of[t] = places_of(r, t);
        for (uint32_t k = 0; k < of[t].count; k++)
            r->first[of[t].list + 2 * k + 2]++;
    }
    for (int l = 2; l <= n_lists + 1; l++)
        r->first[l] += r->first[l - 1];
    const size_t total = r->first[n_lists + 1];
    r->listed = malloc((total ? total : 1) * sizeof *r->listed);
    for (size_t t = 0; r->listed && t < n; t++)
        for (uint32_t k = 0; k < of[t].count; k++)
            r->listed[r->first[of[t].list + 2 * k + 1]++] = (uint32_t)t;
    free(of);
    return r->listed ? SHEEN_OK : sheen_fail_memory(err, 4.0 * (double)total, "a picture's triangles");
}

// e(u, v) = a u + (b v + c): 0 on the line through two vertices, positive on the triangle's side of it.
typedef struct edge {
    float a, b, c;
} edge;

SHEEN_KERNEL_INLINE edge edge_through(const vertex *vertices, uint32_t from, uint32_t to, float side)
{
    const vertex *p = vertices + (from < to ? from : to), *q = vertices + (from < to ? to : from);
    const float sign = from < to ? side : -side;
    const float a = p->v - q->v, b = q->u - p->u;
    return (edge){sign * a, sign * b, sign * -(a * p->u + b * p->v)};
}

// Draws one triangle into a band's depths and numbers.
SHEEN_KERNEL_INLINE void draw_triangle(const raster *r, const band *to, uint32_t triangle)
{
    const uint32_t *corner = r->mesh->triangles + 3 * (size_t)triangle;
    const vertex *p = r->vertices + corner[0], *q = r->vertices + corner[1], *s = r->vertices + corner[2];
    int x0, x1, y0, y1;
    span_of(&x0, &x1, p->u, q->u, s->u, r->columns);
    span_of(&y0, &y1, p->v, q->v, s->v, to->row1);
    y0 = y0 < to->row0 ? to->row0 : y0;
    const float qu = q->u - p->u, qv = q->v - p->v, su = s->u - p->u, sv = s->v - p->v;
    const float area = qu * sv - qv * su;
    if (x0 > x1 || y0 > y1 || area == 0)
        return;
    const float side = area > 0 ? 1.0f : -1.0f;
    const edge e0 = edge_through(r->vertices, corner[0], corner[1], side),
               e1 = edge_through(r->vertices, corner[1], corner[2], side),
               e2 = edge_through(r->vertices, corner[2], corner[0], side);
    // w = p.w + w_u (u - p.u) + w_v (v - p.v) through the three corners.
    const float qw = q->w - p->w, sw = s->w - p->w;
    const float w_u = (qw * sv - sw * qv) / area, w_v = (sw * qu - qw * su) / area;
    const int begin = x0 / SPAN * SPAN;
    for (int y = y0; y <= y1; y++) {
        const float v = (float)y;
        const float c0 = e0.b * v + e0.c, c1 = e1.b * v + e1.c, c2 = e2.b * v + e2.c;
        const float cw = p->w + w_v * (v - p->v);
        const size_t row = (size_t)(y - to->row0) * (size_t)r->stride;
        for (int x = begin; x <= x1; x += SPAN) {
            float *restrict depth = to->inverse_z_m + row + x;
            uint32_t *restrict number = to->triangle + row + x;
#pragma omp simd
            for (int i = 0; i < SPAN; i++) {
                const float u = (float)(x + i);
                const float f0 = e0.a * u + c0, f1 = e1.a * u + c1, f2 = e2.a * u + c2;
                const float w = cw + w_u * (u - p->u);
                const int in = (f0 >= 0) & (f1 >= 0) & (f2 >= 0) & (w > depth[i]);
                depth[i] = in ? w : depth[i];
                number[i] = in ? triangle : number[i];
            }
        }
    }
}

// The least inverse depth of every block of BLOCK x BLOCK samples, and fewer at the band's end.
SHEEN_KERNEL_INLINE void find_least(const raster *r, const band *to)
{
    const int per_row = r->stride / BLOCK;
    for (int y0 = to->row0; y0 < to->row1; y0 += BLOCK) {
        float *least = to->least + (size_t)((y0 - to->row0) / BLOCK) * (size_t)per_row;
        const int y1 = y0 + BLOCK < to->row1 ? y0 + BLOCK : to->row1;
        for (int k = 0; k < per_row; k++) {
            const float *from = to->inverse_z_m + (size_t)(y0 - to->row0) * (size_t)r->stride + k * BLOCK;
            int32_t bits
                [BLOCK]; // non-negative floats order like their bits, and gcc 12 makes no branch of integers
            memcpy(bits, from, sizeof bits);
            for (int y = y0 + 1; y < y1; y++) {
                int32_t next[BLOCK];
                from += r->stride;
                memcpy(next, from, sizeof next);
#pragma omp simd
                for (int i = 0; i < BLOCK; i++)
                    bits[i] = next[i] < bits[i] ? next[i] : bits[i];
            }
            int32_t all = bits[0];
            for (int i = 1; i < BLOCK; i++)
                all = bits[i] < all ? bits[i] : all;
            memcpy(least + k, &all, sizeof all);
        }
    }
}

// Whether every sample that a triangle may cover sees a nearer one than its nearest corner. The margin is for the rounding of what is
// interpolated; in a sliver's plane, where that could be more, a sample would be nearer than all corners by the error alone.
SHEEN_KERNEL_INLINE int is_hidden(const raster *r, const band *to, uint32_t triangle)
{
    const uint32_t *corner = r->mesh->triangles + 3 * (size_t)triangle;
    const vertex *p = r->vertices + corner[0], *q = r->vertices + corner[1], *s = r->vertices + corner[2];
    int x0, x1, y0, y1;
    span_of(&x0, &x1, p->u, q->u, s->u, r->columns);
    span_of(&y0, &y1, p->v, q->v, s->v, to->row1);
    y0 = y0 < to->row0 ? to->row0 : y0;
    const float pq = p->w > q->w ? p->w : q->w, most = (pq > s->w ? pq : s->w) * 1.0001f;
    const int per_row = r->stride / BLOCK;
    for (int y = (y0 - to->row0) / BLOCK; y <= (y1 - to->row0) / BLOCK && y0 <= y1; y++)
        for (int x = x0 / BLOCK; x <= x1 / BLOCK && x0 <= x1; x++)
            if (!(to->least[(size_t)y * (size_t)per_row + (size_t)x] > most))
                return 0;
    return 1;
}

// The rays through a row: (dx, dy, 1) from the camera, dx = dx0 + x dx_step.
typedef struct row_rays {
    float dx0, dx_step, across2; // 1 + dy^2
} row_rays;

static row_rays rays_of(const raster *r, int y)
{
    const sheen_gbuffer *g = &r->window;
    const double step_px = 1.0 / g->samples_per_side, start_px = 0.5 * step_px - 0.5;
    const double dx0 = (g->x0_px + start_px - r->fxycxy[2]) / r->fxycxy[0];
    const double dy = (g->y0_px + start_px + y * step_px - r->fxycxy[3]) / r->fxycxy[1];
    return (row_rays){(float)dx0, (float)(step_px / r->fxycxy[0]), (float)(1 + dy * dy)};
}

// The hits of LANES samples in a row of which at least one sees a triangle; t_m is z times the length of the ray to z = 1.
SHEEN_KERNEL_INLINE void make_hits(const raster *r, sheen_hit *hits, const uint32_t *number,
                                   const row_rays *rays, int x, int y, int count)
{
    vertex p[LANES], q[LANES], s[LANES];
    float b1[LANES], b2[LANES], t_m[LANES];
    for (int i = 0; i < LANES; i++) {
        const size_t triangle = number[i] == SHEEN_NO_HIT ? 0 : number[i];
        const uint32_t *corner = r->mesh->triangles + 3 * triangle;
        p[i] = r->vertices[corner[0]];
        q[i] = r->vertices[corner[1]];
        s[i] = r->vertices[corner[2]];
    }
#pragma omp simd
    for (int i = 0; i < LANES; i++) {
        const float qu = q[i].u - p[i].u, qv = q[i].v - p[i].v;
        const float su = s[i].u - p[i].u, sv = s[i].v - p[i].v;
        const float du = (float)(x + i) - p[i].u, dv = (float)y - p[i].v, over = 1 / (qu * sv - qv * su);
        // Weights in the picture; a rounding error outside the triangle is pulled in.
        const float l1 = (du * sv - dv * su) * over, l2 = (qu * dv - qv * du) * over;
        const float m1 = l1 > 0 ? l1 : 0, m2 = l2 > 0 ? l2 : 0;
        const float scale = m1 + m2 > 1 ? 1 / (m1 + m2) : 1;
        const float w1 = m1 * scale * q[i].w, w2 = m2 * scale * s[i].w;
        const float z_m = 1 / ((1 - (m1 + m2) * scale) * p[i].w + w1 + w2);
        const float dx = rays->dx0 + rays->dx_step * (float)(x + i);
        b1[i] = w1 * z_m;
        b2[i] = w2 * z_m;
        t_m[i] = z_m * sqrtf(rays->across2 + dx * dx);
    }
    for (int i = 0; i < count; i++)
        hits[i] = (sheen_hit){number[i], b1[i], b2[i], t_m[i]};
}

SHEEN_KERNEL_INLINE void make_row(const raster *r, sheen_hit *hits, const uint32_t *number, int y)
{
    const row_rays rays = rays_of(r, y);
    for (int x = 0; x < r->columns; x += LANES) {
        const int count = r->columns - x < LANES ? r->columns - x : LANES;
        uint32_t all = SHEEN_NO_HIT;
        for (int i = 0; i < LANES; i++)
            all &= number[x + i];
        if (all == SHEEN_NO_HIT) {
            for (int i = 0; i < count; i++)
                hits[x + i] = (sheen_hit){.triangle = SHEEN_NO_HIT};
            continue;
        }
        make_hits(r, hits + x, number + x, &rays, x, y, count);
    }
}

SHEEN_KERNEL_INLINE void draw_band(const raster *r, sheen_hit *hits, const band *to, int number)
{
    const size_t n = (size_t)(to->row1 - to->row0) * (size_t)r->stride;
    memset(to->inverse_z_m, 0, n * sizeof *to->inverse_z_m);
    memset(to->triangle, 0xff, n * sizeof *to->triangle); // SHEEN_NO_HIT
    const size_t *first = r->first + 2 * (size_t)number;
    for (size_t i = first[0]; i < first[1]; i++)
        draw_triangle(r, to, r->listed[i]);
    find_least(r, to);
    for (size_t i = first[1]; i < first[2]; i++)
        if (!is_hidden(r, to, r->listed[i]))
            draw_triangle(r, to, r->listed[i]);
    for (int y = to->row0; y < to->row1; y++) {
        const size_t row = (size_t)(y - to->row0);
        make_row(r, hits + row * (size_t)r->columns, to->triangle + row * (size_t)r->stride, y);
    }
}

static void band_baseline(const raster *r, sheen_hit *hits, const band *to, int number)
{
    draw_band(r, hits, to, number);
}

#if defined(__x86_64__)
SHEEN_TARGET_AVX2 static void band_avx2(const raster *r, sheen_hit *hits, const band *to, int number)
{
    draw_band(r, hits, to, number);
}

SHEEN_TARGET_AVX512 static void band_avx512(const raster *r, sheen_hit *hits, const band *to, int number)
{
    draw_band(r, hits, to, number);
}
#endif

sheen_status sheen_raster_bands_hits(const sheen_raster_bands *r, sheen_hit *hits, int number, sheen_err *err)
{
    void (*draw)(const raster *self, sheen_hit *out, const band *rows, int i) = band_baseline;
#if defined(__x86_64__)
    draw = sheen_cpu_level() == SHEEN_CPU_AVX512 ? band_avx512
           : sheen_cpu_level() == SHEEN_CPU_AVX2 ? band_avx2
                                                 : band_baseline;
#endif
    band to = {.row0 = number * r->band_rows};
    to.row1 = to.row0 + r->band_rows < r->rows ? to.row0 + r->band_rows : r->rows;
    const size_t n = (size_t)(to.row1 - to.row0) * (size_t)r->stride;
    sheen_status s = SHEEN_OK;
    to.inverse_z_m = aligned_alloc(
        64, n * sizeof *to.inverse_z_m); // whole vectors: none straddles two cache lines
    to.triangle = aligned_alloc(64, n * sizeof *to.triangle);
    to.least = malloc((n / BLOCK + (size_t)r->stride) * sizeof *to.least);
    if (to.inverse_z_m && to.triangle && to.least)
        draw(r, hits, &to, number);
    else
        s = sheen_fail_memory(err, 8.0 * (double)n, "a picture's depths");
    free(to.least);
    free(to.triangle);
    free(to.inverse_z_m);
    return s;
}

static void place_vertices(raster *r, const sheen_projected *at)
{
    const double n = r->window.samples_per_side;
    for (size_t i = 0; i < r->mesh->n_vertices; i++)
        r->vertices[i] = (vertex){.u = (float)((at->q_px[2 * i] + 0.5 - r->window.x0_px) * n - 0.5),
                                  .v = (float)((at->q_px[2 * i + 1] + 0.5 - r->window.y0_px) * n - 0.5),
                                  .w = (float)at->inverse_z_m[i]};
}

sheen_status sheen_raster_bands_new(sheen_raster_bands **out, const sheen_gbuffer *g, const sheen_mesh *mesh,
                                    const sheen_camera *cam, const sheen_projected *at, int band_rows,
                                    sheen_err *err)
{
    sheen_status s = SHEEN_OK;
    raster *r = calloc(1, sizeof *r);
    if (r) {
        *r = (raster){.window = *g, .mesh = mesh, .band_rows = band_rows};
        memcpy(r->fxycxy, cam->intrinsics, sizeof r->fxycxy);
        r->columns = g->width_px * g->samples_per_side;
        r->rows = g->height_px * g->samples_per_side;
        r->stride = (r->columns + LANES - 1) / LANES * LANES;
        r->n_bands = (r->rows + band_rows - 1) / band_rows;
        r->vertices = malloc(mesh->n_vertices * sizeof *r->vertices);
        r->first = calloc(2 * (size_t)r->n_bands + 2, sizeof *r->first);
    }
    if (!r || !r->vertices || !r->first) {
        s = sheen_fail_memory(err, 16.0 * (double)mesh->n_vertices, "a picture's vertices");
    } else {
        place_vertices(r, at);
        s = list_bands(r, err);
    }
    if (s)
        sheen_raster_bands_free(&r);
    *out = r;
    return s;
}

void sheen_raster_bands_free(sheen_raster_bands **bands)
{
    raster *r = *bands;
    if (!r)
        return;
    free(r->listed);
    free(r->first);
    free(r->vertices);
    free(r);
    *bands = NULL;
}

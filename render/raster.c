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
//   * The picture is cut into bands of rows. Each lists the triangles that touch it, in the mesh's order, and
//     is drawn by one thread into rows of depths and numbers that stay in its cache.
//
// Samples have whole-numbered places: u = (x + 1/2) n - 1/2 from the window's first, likewise v.
#include "render/raster.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/cpu_level.h"
#include "base/parallel.h"

enum { LANES = 16, BAND_ROWS = 32 };

// Place in the picture and inverse depth, in one cache line's quarter.
typedef struct vertex {
    float u, v, w, unused;
} vertex;

typedef struct raster {
    sheen_gbuffer *g;
    const sheen_mesh *mesh;
    vertex *vertices;
    int columns, rows, stride; // samples; stride: columns in whole vectors
    int n_bands;
    size_t *first;      // [n_bands + 1] into listed
    uint32_t *listed;   // triangles, band after band
    float *inverse_z_m; // [rows][stride]
    uint32_t *triangle; // [rows][stride]
    double fxycxy[4];
} raster;

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

// The bands that a triangle's rows are in; false where it covers no sample's row.
static bool bands_of(const raster *r, size_t triangle, int *first, int *last)
{
    const uint32_t *corner = r->mesh->triangles + 3 * triangle;
    const float a = r->vertices[corner[0]].v, b = r->vertices[corner[1]].v, c = r->vertices[corner[2]].v;
    span_of(first, last, a, b, c, r->rows);
    if (*first > *last)
        return false;
    *first /= BAND_ROWS;
    *last /= BAND_ROWS;
    return true;
}

// Counts into first[b + 2], sums up, and lists: first[b + 1] runs from band b's begin to its end meanwhile.
static sheen_status list_bands(raster *r, sheen_err *err)
{
    int first, last;
    for (size_t t = 0; t < r->mesh->n_triangles; t++)
        if (bands_of(r, t, &first, &last))
            for (int b = first; b <= last; b++)
                r->first[b + 2]++;
    for (int b = 2; b <= r->n_bands + 1; b++)
        r->first[b] += r->first[b - 1];
    const size_t total = r->first[r->n_bands + 1];
    r->listed = malloc((total ? total : 1) * sizeof *r->listed);
    if (!r->listed)
        return sheen_fail_memory(err, 4.0 * (double)total, "a picture's triangles");
    for (size_t t = 0; t < r->mesh->n_triangles; t++)
        if (bands_of(r, t, &first, &last))
            for (int b = first; b <= last; b++)
                r->listed[r->first[b + 1]++] = (uint32_t)t;
    return SHEEN_OK;
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

// Draws one triangle into the rows [row0, row1) of depths and numbers.
SHEEN_KERNEL_INLINE void draw_triangle(const raster *r, uint32_t triangle, int row0, int row1)
{
    const uint32_t *corner = r->mesh->triangles + 3 * (size_t)triangle;
    const vertex *p = r->vertices + corner[0], *q = r->vertices + corner[1], *s = r->vertices + corner[2];
    int x0, x1, y0, y1;
    span_of(&x0, &x1, p->u, q->u, s->u, r->columns);
    span_of(&y0, &y1, p->v, q->v, s->v, row1);
    y0 = y0 < row0 ? row0 : y0;
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
    const int begin = x0 / LANES * LANES;
    for (int y = y0; y <= y1; y++) {
        const float v = (float)y;
        const float c0 = e0.b * v + e0.c, c1 = e1.b * v + e1.c, c2 = e2.b * v + e2.c;
        const float cw = p->w + w_v * (v - p->v);
        for (int x = begin; x <= x1; x += LANES) {
            float *restrict depth = r->inverse_z_m + (size_t)y * (size_t)r->stride + (size_t)x;
            uint32_t *restrict number = r->triangle + (size_t)y * (size_t)r->stride + (size_t)x;
#pragma omp simd
            for (int i = 0; i < LANES; i++) {
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

// The hits of LANES samples in a row of which at least one sees a triangle.
SHEEN_KERNEL_INLINE void make_hits(const raster *r, sheen_hit *hits, const uint32_t *number, int x, int y,
                                   int count)
{
    vertex p[LANES], q[LANES], s[LANES];
    float b1[LANES], b2[LANES], z_m[LANES];
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
        z_m[i] = 1 / ((1 - (m1 + m2) * scale) * p[i].w + w1 + w2);
        b1[i] = w1 * z_m[i];
        b2[i] = w2 * z_m[i];
    }
    for (int i = 0; i < count; i++)
        hits[i] = (sheen_hit){number[i], b1[i], b2[i], z_m[i]};
}

// A row's hits; t_m is z times the length of the ray to z = 1.
SHEEN_KERNEL_INLINE void make_row(const raster *r, int y)
{
    const int n = r->g->samples_per_side;
    const double step_px = 1.0 / n, start_px = 0.5 * step_px - 0.5;
    const double dy = (r->g->y0_px + start_px + y * step_px - r->fxycxy[3]) / r->fxycxy[1];
    const float dx0 = (float)((r->g->x0_px + start_px - r->fxycxy[2]) / r->fxycxy[0]),
                dx_step = (float)(step_px / r->fxycxy[0]), across2 = (float)(1 + dy * dy);
    const uint32_t *number = r->triangle + (size_t)y * (size_t)r->stride;
    sheen_hit *hits = r->g->hits + (size_t)y * (size_t)r->columns;
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
        make_hits(r, hits + x, number + x, x, y, count);
        for (int i = 0; i < count; i++) {
            const float dx = dx0 + dx_step * (float)(x + i);
            hits[x + i].t_m *= sqrtf(across2 + dx * dx);
        }
    }
}

SHEEN_KERNEL_INLINE void draw_bands(const raster *r, size_t begin, size_t end)
{
    for (size_t band = begin; band < end; band++) {
        const int row0 = (int)band * BAND_ROWS,
                  row1 = row0 + BAND_ROWS < r->rows ? row0 + BAND_ROWS : r->rows;
        const size_t at = (size_t)row0 * (size_t)r->stride, n = (size_t)(row1 - row0) * (size_t)r->stride;
        memset(r->inverse_z_m + at, 0, n * sizeof *r->inverse_z_m);
        memset(r->triangle + at, 0xff, n * sizeof *r->triangle); // SHEEN_NO_HIT
        for (size_t i = r->first[band]; i < r->first[band + 1]; i++)
            draw_triangle(r, r->listed[i], row0, row1);
        for (int y = row0; y < row1; y++)
            make_row(r, y);
    }
}

static void bands_baseline(void *self, size_t begin, size_t end)
{
    draw_bands(self, begin, end);
}

#if defined(__x86_64__)
SHEEN_TARGET_AVX2 static void bands_avx2(void *self, size_t begin, size_t end)
{
    draw_bands(self, begin, end);
}

SHEEN_TARGET_AVX512 static void bands_avx512(void *self, size_t begin, size_t end)
{
    draw_bands(self, begin, end);
}
#endif

static void place_vertices(raster *r, const sheen_projected *at)
{
    const double n = r->g->samples_per_side;
    for (size_t i = 0; i < r->mesh->n_vertices; i++)
        r->vertices[i] = (vertex){.u = (float)((at->q_px[2 * i] + 0.5 - r->g->x0_px) * n - 0.5),
                                  .v = (float)((at->q_px[2 * i + 1] + 0.5 - r->g->y0_px) * n - 0.5),
                                  .w = (float)at->inverse_z_m[i]};
}

sheen_status sheen_raster_hits(sheen_gbuffer *g, const sheen_mesh *mesh, const sheen_camera *cam,
                               const sheen_projected *at, int n_threads, sheen_err *err)
{
    void (*bands)(void *self, size_t begin, size_t end) = bands_baseline;
#if defined(__x86_64__)
    bands = sheen_cpu_level() == SHEEN_CPU_AVX512 ? bands_avx512
            : sheen_cpu_level() == SHEEN_CPU_AVX2 ? bands_avx2
                                                  : bands_baseline;
#endif
    raster r = {.g = g, .mesh = mesh};
    memcpy(r.fxycxy, cam->intrinsics, sizeof r.fxycxy);
    r.columns = g->width_px * g->samples_per_side;
    r.rows = g->height_px * g->samples_per_side;
    r.stride = (r.columns + LANES - 1) / LANES * LANES;
    r.n_bands = (r.rows + BAND_ROWS - 1) / BAND_ROWS;
    const size_t n_samples = (size_t)r.stride * (size_t)r.rows;
    sheen_status s = SHEEN_OK;
    r.vertices = malloc(mesh->n_vertices * sizeof *r.vertices);
    r.first = calloc((size_t)r.n_bands + 2, sizeof *r.first);
    r.inverse_z_m = malloc(n_samples * sizeof *r.inverse_z_m);
    r.triangle = malloc(n_samples * sizeof *r.triangle);
    if (!r.vertices || !r.first || !r.inverse_z_m || !r.triangle) {
        s = sheen_fail_memory(err, 8.0 * (double)n_samples, "a picture's depths");
        goto done;
    }
    place_vertices(&r, at);
    s = list_bands(&r, err);
    if (!s)
        sheen_parallel_for((size_t)r.n_bands, 1, n_threads, bands, &r);

done:
    free(r.listed);
    free(r.triangle);
    free(r.inverse_z_m);
    free(r.first);
    free(r.vertices);
    return s;
}

// SPDX-License-Identifier: Apache-2.0
// outline.c - draws a mesh's cover, pixel centres inside a projected triangle, and samples its border.
#include "pose/outline.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Room for each sample's p_cam, q_px, dq_dp.
enum { PER_SAMPLE = 3 + 2 + 6 };

// How far beside an edge the picture is looked at, on both sides: one must be covered, the other empty.
static const double BESIDE_PX = 1.5;

void sheen_outline_release(sheen_outline *outline)
{
    free(outline->samples);
    free(outline->sample_room);
    free(outline->cover);
    free(outline->p_cam);
    free(outline->p_board);
    *outline = (sheen_outline){0};
}

static sheen_status make_room(sheen_outline *out, size_t n_vertices, const sheen_outline_canvas *canvas,
                              sheen_err *err)
{
    const size_t n_pixels = (size_t)canvas->width_px * (size_t)canvas->height_px;
    if (n_vertices > out->n_vertices) {
        free(out->p_cam);
        free(out->p_board);
        out->p_cam = malloc(n_vertices * 5 * sizeof *out->p_cam);
        out->p_board = malloc(n_vertices * 3 * sizeof *out->p_board);
        out->n_vertices = out->p_cam && out->p_board ? n_vertices : 0;
        if (!out->n_vertices)
            return sheen_fail_memory(err, (double)n_vertices * 52, "an outline");
        out->q_px = out->p_cam + 3 * n_vertices;
    }
    if (n_pixels > out->cover_capacity) {
        free(out->cover);
        out->cover = calloc(n_pixels, 1);
        out->cover_capacity = out->cover ? n_pixels : 0;
        if (!out->cover)
            return sheen_fail_memory(err, (double)n_pixels, "an outline");
    } else
        memset(out->cover, 0, n_pixels);
    out->width_px = canvas->width_px;
    out->height_px = canvas->height_px;
    return SHEEN_OK;
}

static sheen_status project(sheen_outline *out, const sheen_outline_mesh *mesh,
                            const sheen_placement *placement, const sheen_outline_canvas *canvas,
                            sheen_err *err)
{
    sheen_Rt Rt = placement->Rt_board_obj;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            Rt.R[i][j] *= placement->scale;
    for (size_t i = 0; i < mesh->n_vertices; i++) {
        double p[3];
        for (size_t c = 0; c < 3; c++)
            p[c] = (double)mesh->p_obj[3 * i + c];
        sheen_Rt_point(p, &Rt, p);
        for (size_t c = 0; c < 3; c++)
            out->p_board[3 * i + c] = (float)p[c];
        sheen_Rt_point(out->p_cam + 3 * i, &canvas->Rt_cam_board, p);
    }
    const sheen_status s = sheen_camera_project(canvas->camera, out->q_px, NULL, out->p_cam, mesh->n_vertices,
                                                err);
    for (size_t i = 0; i < 2 * mesh->n_vertices && !s; i++)
        out->q_px[i] = canvas->factor * (out->q_px[i] + 0.5) - 0.5;
    return s;
}

// Without the care for NaN of fmin and fmax, which are calls.
static inline double lower(double a, double b)
{
    return a < b ? a : b;
}

static inline double higher(double a, double b)
{
    return a > b ? a : b;
}

static inline double clamp(double x, double low, double high)
{
    return x < low ? low : x > high ? high : x;
}

// Marks the pixels whose centre lies in the triangle a b c.
static void fill(sheen_outline *out, const double *a, const double *b, const double *c)
{
    const double top = lower(a[1], lower(b[1], c[1])), bottom = higher(a[1], higher(b[1], c[1]));
    if (!(bottom - top < 1e6) || !(bottom >= 0 && top <= out->height_px - 1))
        return; // not a number, or not in the picture
    const double *corner[4] = {a, b, c, a};
    const int y1 = (int)lower(bottom, out->height_px - 1);
    int y = (int)higher(top, 0);
    y += y < top; // the first row of centres at or below the top
    for (; y <= y1; y++) {
        double left = INFINITY, right = -INFINITY;
        for (int k = 0; k < 3; k++) {
            const double *p = corner[k], *q = corner[k + 1];
            if (!((p[1] <= y && q[1] >= y) || (q[1] <= y && p[1] >= y)))
                continue;
            const double x = p[1] == q[1] ? q[0] : p[0] + (q[0] - p[0]) * (y - p[1]) / (q[1] - p[1]);
            left = lower(left, p[1] == q[1] ? lower(p[0], x) : x);
            right = higher(right, p[1] == q[1] ? higher(p[0], x) : x);
        }
        if (!(right >= 0 && left <= out->width_px - 1))
            continue;
        const int x1 = (int)lower(right, out->width_px - 1);
        int x = (int)higher(left, 0);
        x += x < left;
        for (uint8_t *pixel = out->cover + (size_t)y * (size_t)out->width_px; x <= x1; x++)
            pixel[x] = 1;
    }
}

static void draw(sheen_outline *out, const sheen_outline_mesh *mesh)
{
    double box[4] = {INFINITY, INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < mesh->n_triangles; i++) {
        const uint32_t *t = mesh->triangles + 3 * i;
        fill(out, out->q_px + 2 * (size_t)t[0], out->q_px + 2 * (size_t)t[1], out->q_px + 2 * (size_t)t[2]);
    }
    for (size_t i = 0; i < mesh->n_vertices; i++)
        for (int k = 0; k < 2; k++) {
            box[k] = lower(box[k], out->q_px[2 * i + (size_t)k]);
            box[2 + k] = higher(box[2 + k], out->q_px[2 * i + (size_t)k]);
        }
    const int size[2] = {out->width_px, out->height_px};
    for (int k = 0; k < 2; k++) {
        out->box_px[k] = (int)floor(clamp(box[k], 0, size[k]));
        out->box_px[2 + k] = (int)ceil(clamp(box[2 + k] + 1, 0, size[k]));
    }
}

static int covered(const sheen_outline *o, double x, double y)
{
    const long i = lrint(clamp(x, -2, o->width_px + 1)), j = lrint(clamp(y, -2, o->height_px + 1));
    return i >= 0 && j >= 0 && i < o->width_px && j < o->height_px &&
           o->cover[(size_t)j * (size_t)o->width_px + (size_t)i];
}

static int in_picture(const sheen_outline *o, const double q[2])
{
    return q[0] >= 2 && q[1] >= 2 && q[0] <= o->width_px - 3 && q[1] <= o->height_px - 3;
}

// True for an edge between a front and a back (or at a rim) of the mesh as projected.
static bool turns_away(const sheen_outline *o, const sheen_outline_mesh *mesh, const uint32_t *edge)
{
    double area[2];
    for (int k = 0; k < 2; k++) {
        if (edge[2 + k] == UINT32_MAX)
            return true;
        const uint32_t *t = mesh->triangles + 3 * (size_t)edge[2 + k];
        const double *a = o->q_px + 2 * (size_t)t[0], *b = o->q_px + 2 * (size_t)t[1],
                     *c = o->q_px + 2 * (size_t)t[2];
        area[k] = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    }
    return (area[0] > 0) != (area[1] > 0);
}

static sheen_status add_sample(sheen_outline *out, const uint32_t *edge, double share, const double n_px[2],
                               sheen_err *err)
{
    if (out->n_samples == out->sample_capacity) {
        const size_t capacity = 2 * out->sample_capacity + 256;
        sheen_outline_sample *grown = realloc(out->samples, capacity * sizeof *grown);
        if (!grown)
            return sheen_fail_memory(err, (double)capacity * sizeof *grown, "an outline");
        out->samples = grown;
        out->sample_capacity = capacity;
        free(out->sample_room);
        out->sample_room = malloc(capacity * PER_SAMPLE * sizeof *out->sample_room);
        if (!out->sample_room)
            return sheen_fail_memory(err, (double)(capacity * PER_SAMPLE) * sizeof *out->sample_room,
                                     "an outline");
    }
    sheen_outline_sample *s = &out->samples[out->n_samples++];
    const size_t a = edge[0], b = edge[1];
    for (size_t k = 0; k < 2; k++) {
        s->q_px[k] = (1 - share) * out->q_px[2 * a + k] + share * out->q_px[2 * b + k];
        s->n_px[k] = n_px[k];
    }
    for (size_t c = 0; c < 3; c++)
        s->p_board[c] = (1 - share) * (double)out->p_board[3 * a + c] +
                        share * (double)out->p_board[3 * b + c];
    return SHEEN_OK;
}

// How the samples follow their points: of samples alone, since vertices are many times as many.
static sheen_status follow(sheen_outline *out, const sheen_outline_canvas *canvas, sheen_err *err)
{
    const size_t n = out->n_samples;
    double *p_cam = out->sample_room, *q_px = p_cam + 3 * n, *dq_dp = p_cam + 5 * n;
    for (size_t i = 0; i < n; i++)
        sheen_Rt_point(p_cam + 3 * i, &canvas->Rt_cam_board, out->samples[i].p_board);
    const sheen_status st = n ? sheen_camera_project(canvas->camera, q_px, dq_dp, p_cam, n, err) : SHEEN_OK;
    for (size_t i = 0; i < n && !st; i++)
        for (size_t k = 0; k < 2; k++)
            for (size_t c = 0; c < 3; c++) {
                double sum = 0;
                for (size_t j = 0; j < 3; j++)
                    sum += dq_dp[6 * i + 3 * k + j] * canvas->Rt_cam_board.R[j][c];
                out->samples[i].dq_dboard[3 * k + c] = canvas->factor * sum;
            }
    return st;
}

// Samples of one edge; *carry is the length since the last sample, over all edges.
static sheen_status sample_edge(sheen_outline *out, const uint32_t *edge, double spacing_px, double *carry,
                                sheen_err *err)
{
    const double *a = out->q_px + 2 * (size_t)edge[0], *b = out->q_px + 2 * (size_t)edge[1];
    const double dx = b[0] - a[0], dy = b[1] - a[1], length = hypot(dx, dy);
    if (!(length > 1e-9) || !(length < 1e5))
        return SHEEN_OK;
    const int n_here = (int)((*carry + length) / spacing_px);
    for (int i = 1; i <= n_here; i++) {
        const double at = lower(i * spacing_px - *carry, length);
        const double q[2] = {a[0] + dx * at / length, a[1] + dy * at / length};
        double n[2] = {dy / length, -dx / length};
        const int left = covered(out, q[0] + BESIDE_PX * n[0], q[1] + BESIDE_PX * n[1]),
                  right = covered(out, q[0] - BESIDE_PX * n[0], q[1] - BESIDE_PX * n[1]);
        if (left == right || !in_picture(out, q))
            continue;
        if (left) {
            n[0] = -n[0];
            n[1] = -n[1];
        }
        const sheen_status s = add_sample(out, edge, at / length, n, err);
        if (s)
            return s;
        out->samples[out->n_samples - 1].length_px = spacing_px;
    }
    *carry = fmod(*carry + length, spacing_px);
    return SHEEN_OK;
}

sheen_status sheen_outline_draw(sheen_outline *out, const sheen_outline_mesh *mesh,
                                const sheen_placement *placement, const sheen_outline_canvas *canvas,
                                double spacing_px, sheen_err *err)
{
    double carry = 0;
    out->n_samples = 0;
    sheen_status s = make_room(out, mesh->n_vertices, canvas, err);
    if (!s)
        s = project(out, mesh, placement, canvas, err);
    if (s)
        return s;
    draw(out, mesh);
    for (size_t i = 0; i < mesh->n_edges && !s; i++)
        if (turns_away(out, mesh, mesh->edges + 4 * i))
            s = sample_edge(out, mesh->edges + 4 * i, spacing_px, &carry, err);
    return s ? s : follow(out, canvas, err);
}

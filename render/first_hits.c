// SPDX-License-Identifier: Apache-2.0
// first_hits.c - what a camera sees of a mesh, through the full lens model, band of rows by band of rows.
//
// A pinhole's picture is drawn triangle by triangle (raster.c); any other lens, and a mesh that reaches behind
// the camera, takes one ray a sample. Only a window round the projected vertices is looked at. Rays go to the
// tracer in tiles of 4 x 4 samples, which stay together in its structure better than rows do.
#include "render/first_hits.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/pose3.h"
#include "base/vec.h"

enum { TILE = 4, BAND_COLUMNS = 64, PROJECT_AT_ONCE = 512, MAX_SAMPLES_PER_SIDE = 16 };

// Box of projected points.
typedef struct box {
    double min[2], max[2];
    bool any_before, any_behind; // of the camera
} box;

static sheen_status project_vertices(sheen_projected *at, const sheen_mesh *mesh, const sheen_camera *cam,
                                     const double rt_cam_obj[6], sheen_err *err)
{
    sheen_Rt Rt_cam_obj;
    sheen_Rt_from_rt(&Rt_cam_obj, rt_cam_obj);
    double p_cam[PROJECT_AT_ONCE][3];
    for (size_t begin = 0; begin < mesh->n_vertices; begin += PROJECT_AT_ONCE) {
        const size_t n = mesh->n_vertices - begin < PROJECT_AT_ONCE ? mesh->n_vertices - begin
                                                                    : PROJECT_AT_ONCE;
        for (size_t i = 0; i < n; i++) {
            const float *p = mesh->p_obj + 3 * (begin + i);
            const double p_obj[3] = {(double)p[0], (double)p[1], (double)p[2]};
            sheen_Rt_point(p_cam[i], &Rt_cam_obj, p_obj);
            at->inverse_z_m[begin + i] = 1 / p_cam[i][2];
        }
        const sheen_status s = sheen_camera_project(cam, at->q_px + 2 * begin, NULL, p_cam[0], n, err);
        if (s)
            return s;
    }
    return SHEEN_OK;
}

// Box of the triangles' corners, grown by what a triangle's side may bulge out of it: nothing through a
// pinhole, else at most a quarter of the longest side (an arc over a chord bends out no further unless it
// turns by over 100 degrees).
static box box_of(const double *q_px, const sheen_mesh *mesh, bool pinhole)
{
    box b = {.min = {HUGE_VAL, HUGE_VAL}, .max = {-HUGE_VAL, -HUGE_VAL}};
    double longest2 = 0;
    for (size_t t = 0; t < mesh->n_triangles; t++)
        for (int c = 0; c < 3; c++) {
            const double *q = q_px + 2 * (size_t)mesh->triangles[3 * t + (size_t)c];
            const double *next = q_px + 2 * (size_t)mesh->triangles[3 * t + (size_t)((c + 1) % 3)];
            if (!isfinite(q[0] + q[1])) {
                b.any_behind = true;
                continue;
            }
            b.any_before = true;
            for (int k = 0; k < 2; k++) {
                b.min[k] = q[k] < b.min[k] ? q[k] : b.min[k];
                b.max[k] = q[k] > b.max[k] ? q[k] : b.max[k];
            }
            const double dx = next[0] - q[0], dy = next[1] - q[1], length2 = dx * dx + dy * dy;
            longest2 = length2 > longest2 ? length2 : longest2; // NaN has no part in it
        }
    const double margin_px = pinhole ? 1 : 1 + sqrt(longest2) / 4;
    for (int k = 0; k < 2; k++) {
        b.min[k] -= margin_px;
        b.max[k] += margin_px;
    }
    return b;
}

// First pixel and number of pixels of [min, max], clipped to 0..side.
static void clip(int *first, int *count, double min, double max, int side)
{
    const double low = fmin(fmax(floor(min), 0), side), high = fmin(fmax(ceil(max) + 1, 0), side);
    *first = (int)low;
    *count = high > low ? (int)(high - low) : 0;
}

static void set_window(sheen_gbuffer *g, const sheen_mesh *mesh, const sheen_camera *cam,
                       const sheen_projected *at)
{
    const box b = box_of(at->q_px, mesh, !strcmp(cam->lensmodel, "LENSMODEL_PINHOLE"));
    if (b.any_before && b.any_behind) { // a triangle through the camera's plane may be seen anywhere
        g->width_px = cam->width_px;
        g->height_px = cam->height_px;
    } else if (b.any_before) {
        clip(&g->x0_px, &g->width_px, b.min[0], b.max[0], cam->width_px);
        clip(&g->y0_px, &g->height_px, b.min[1], b.max[1], cam->height_px);
    }
    if (!g->width_px || !g->height_px)
        g->width_px = g->height_px = 0;
}

// Traces the samples [x, x + width) x [y, y + height) of the window, at most BAND_COLUMNS x TILE of them, into hits, whose
// first is that of (x, y), and whose rows stand `stride` apart.
static void trace_block(const sheen_first_hits *f, sheen_hit *hits, size_t stride, int x, int y, int width,
                        int height)
{
    const sheen_gbuffer *g = &f->window;
    const double step_px = 1.0 / g->samples_per_side, start_px = 0.5 * step_px - 0.5;
    const float origin_obj[3] = {(float)g->p_camera_obj[0], (float)g->p_camera_obj[1],
                                 (float)g->p_camera_obj[2]};
    float rows[TILE][BAND_COLUMNS][3], v_obj[TILE * BAND_COLUMNS][3];
    sheen_hit traced[TILE * BAND_COLUMNS];
    for (int r = 0; r < height; r++)
        sheen_pixel_rays_row(&f->rays, rows[r][0], g->x0_px + start_px + x * step_px,
                             g->y0_px + start_px + (y + r) * step_px, step_px, width);
    size_t n = 0;
    for (int tile = 0; tile < width; tile += TILE)
        for (int r = 0; r < height; r++)
            for (int c = tile; c < tile + TILE && c < width; c++)
                memcpy(v_obj[n++], rows[r][c], sizeof rows[r][c]);
    sheen_scene_first_hits(f->scene, traced, origin_obj, 1, v_obj[0], n);
    n = 0;
    for (int tile = 0; tile < width; tile += TILE)
        for (int r = 0; r < height; r++)
            for (int c = tile; c < tile + TILE && c < width; c++)
                hits[(size_t)r * stride + (size_t)c] = traced[n++];
}

static void trace_band(const sheen_first_hits *f, sheen_hit *hits, int row0, int row1)
{
    const int columns = f->window.width_px * f->window.samples_per_side;
    for (int y = row0; y < row1; y += TILE)
        for (int x = 0; x < columns; x += BAND_COLUMNS)
            trace_block(f, hits + (size_t)(y - row0) * (size_t)columns + (size_t)x, (size_t)columns, x, y,
                        columns - x < BAND_COLUMNS ? columns - x : BAND_COLUMNS,
                        row1 - y < TILE ? row1 - y : TILE);
}

static sheen_status check(const double rt_cam_obj[6], int samples_per_side, sheen_err *err)
{
    if (samples_per_side < 1 || samples_per_side > MAX_SAMPLES_PER_SIDE)
        return sheen_fail(err, SHEEN_EARG, "%d samples a pixel's side are out of range (1 to %d)",
                          samples_per_side, MAX_SAMPLES_PER_SIDE);
    for (int i = 0; i < 6; i++)
        if (!isfinite(rt_cam_obj[i]))
            return sheen_fail(err, SHEEN_EARG, "the view's pose is not finite");
    return SHEEN_OK;
}

// Chooses how, and prepares it.
static sheen_status prepare(sheen_first_hits *f, const sheen_first_hits_view *v, const sheen_projected *at,
                            sheen_err *err)
{
    const sheen_gbuffer *w = &f->window;
    const int window_px[4] = {w->x0_px, w->y0_px, w->width_px, w->height_px};
    f->n_bands = (size_t)((w->height_px + f->band_px - 1) / f->band_px);
    if (!w->width_px)
        return SHEEN_OK;
    if (!v->only_rays && sheen_raster_can(w, v->cam, v->mesh, at))
        return sheen_raster_bands_new(&f->raster, w, v->mesh, v->cam, at, f->band_px * w->samples_per_side,
                                      err);
    return sheen_pixel_rays_init(&f->rays, v->cam, v->rt_cam_obj, window_px, v->n_threads, err);
}

static sheen_status look(sheen_first_hits *f, const sheen_first_hits_view *v, sheen_err *err)
{
    const sheen_mesh *mesh = v->mesh;
    sheen_projected at = {.q_px = malloc(mesh->n_vertices * 2 * sizeof *at.q_px),
                          .inverse_z_m = malloc(mesh->n_vertices * sizeof *at.inverse_z_m)};
    sheen_status s = SHEEN_OK;
    if (!at.q_px || !at.inverse_z_m)
        s = sheen_fail_memory(err, 24.0 * (double)mesh->n_vertices, "the mesh's projection");
    if (!s)
        s = project_vertices(&at, mesh, v->cam, v->rt_cam_obj, err);
    if (!s) {
        set_window(&f->window, mesh, v->cam, &at);
        s = prepare(f, v, &at, err);
    }
    free(at.inverse_z_m);
    free(at.q_px);
    return s;
}

sheen_status sheen_first_hits_init(sheen_first_hits *f, const sheen_first_hits_view *v, int band_px,
                                   sheen_err *err)
{
    *f = (sheen_first_hits){.scene = v->scene, .band_px = band_px};
    f->window.samples_per_side = v->samples_per_side;
    sheen_status s = check(v->rt_cam_obj, v->samples_per_side, err);
    if (s)
        return s;
    double rt_obj_cam[6];
    sheen_rt_invert(rt_obj_cam, v->rt_cam_obj);
    memcpy(f->window.p_camera_obj, rt_obj_cam + 3, sizeof f->window.p_camera_obj);
    s = look(f, v, err);
    if (s)
        sheen_first_hits_release(f);
    return s;
}

void sheen_first_hits_release(sheen_first_hits *f)
{
    sheen_raster_bands_free(&f->raster);
    sheen_pixel_rays_release(&f->rays);
    *f = (sheen_first_hits){0};
}

sheen_gbuffer sheen_first_hits_band(const sheen_first_hits *f, size_t band)
{
    sheen_gbuffer g = f->window;
    const int first = (int)band * f->band_px, left = g.height_px - first;
    g.y0_px += first;
    g.height_px = left < f->band_px ? left : f->band_px;
    return g;
}

sheen_status sheen_first_hits_find(const sheen_first_hits *f, sheen_hit *hits, size_t band, sheen_err *err)
{
    const sheen_gbuffer g = sheen_first_hits_band(f, band);
    if (f->raster)
        return sheen_raster_bands_hits(f->raster, hits, (int)band, err);
    const int row0 = (int)band * f->band_px * g.samples_per_side;
    trace_band(f, hits, row0, row0 + g.height_px * g.samples_per_side);
    return SHEEN_OK;
}

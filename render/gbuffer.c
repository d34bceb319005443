// SPDX-License-Identifier: Apache-2.0
// gbuffer.c - what a camera sees of a mesh, through the full lens model.
//
// A pinhole's picture is drawn triangle by triangle (raster.c); any other lens, and a mesh that reaches behind
// the camera, takes one ray a sample. Only a window round the projected vertices is looked at. Rays go to the
// tracer in tiles of 4 x 4 samples, which stay together in its structure better than rows do.
#include "render/gbuffer.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/pose3.h"
#include "base/vec.h"
#include "render/pixel_rays.h"
#include "render/raster.h"

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
    double longest = 0;
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
            if (!pinhole)
                longest = fmax(longest, hypot(next[0] - q[0], next[1] - q[1]));
        }
    const double margin_px = 1 + longest / 4;
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

typedef struct job {
    sheen_gbuffer *g;
    const sheen_scene *scene;
    const sheen_pixel_rays *rays;
    float origin_obj[3];
} job;

// Traces the samples [x, x + width) x [y, y + height), at most BAND_COLUMNS x TILE of them.
static void trace_block(const job *j, int x, int y, int width, int height)
{
    const sheen_gbuffer *g = j->g;
    const double step_px = 1.0 / g->samples_per_side, start_px = 0.5 * step_px - 0.5;
    float rows[TILE][BAND_COLUMNS][3], v_obj[TILE * BAND_COLUMNS][3];
    sheen_hit hits[TILE * BAND_COLUMNS];
    for (int r = 0; r < height; r++)
        sheen_pixel_rays_row(j->rays, rows[r][0], g->x0_px + start_px + x * step_px,
                             g->y0_px + start_px + (y + r) * step_px, step_px, width);
    size_t n = 0;
    for (int tile = 0; tile < width; tile += TILE)
        for (int r = 0; r < height; r++)
            for (int c = tile; c < tile + TILE && c < width; c++)
                memcpy(v_obj[n++], rows[r][c], sizeof rows[r][c]);
    sheen_scene_first_hits(j->scene, hits, j->origin_obj, 1, v_obj[0], n);
    n = 0;
    const size_t stride = (size_t)g->width_px * (size_t)g->samples_per_side;
    for (int tile = 0; tile < width; tile += TILE)
        for (int r = 0; r < height; r++)
            for (int c = tile; c < tile + TILE && c < width; c++)
                g->hits[(size_t)(y + r) * stride + (size_t)(x + c)] = hits[n++];
}

static void trace_bands(void *self, size_t begin, size_t end)
{
    const job *j = self;
    const int n = j->g->samples_per_side, columns = j->g->width_px * n, rows = j->g->height_px * n;
    for (size_t band = begin; band < end; band++) {
        const int y = (int)band * TILE, height = rows - y < TILE ? rows - y : TILE;
        for (int x = 0; x < columns; x += BAND_COLUMNS)
            trace_block(j, x, y, columns - x < BAND_COLUMNS ? columns - x : BAND_COLUMNS, height);
    }
}

// One ray a sample.
static sheen_status trace(sheen_gbuffer *g, const sheen_scene *scene, const sheen_camera *cam,
                          const double rt_cam_obj[6], int n_threads, sheen_err *err)
{
    sheen_pixel_rays rays;
    const int window_px[4] = {g->x0_px, g->y0_px, g->width_px, g->height_px};
    const sheen_status s = sheen_pixel_rays_init(&rays, cam, rt_cam_obj, window_px, n_threads, err);
    if (s)
        return s;
    job j = {.g = g, .scene = scene, .rays = &rays};
    for (int k = 0; k < 3; k++)
        j.origin_obj[k] = (float)g->p_camera_obj[k];
    const size_t n_bands = ((size_t)g->height_px * (size_t)g->samples_per_side + TILE - 1) / TILE;
    sheen_parallel_for(n_bands, 4, n_threads, trace_bands, &j);
    sheen_pixel_rays_release(&rays);
    return SHEEN_OK;
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

typedef struct view {
    const sheen_scene *scene;
    const sheen_mesh *mesh;
    const sheen_camera *cam;
    const double *rt_cam_obj;
    int n_threads;
    bool only_rays;
} view;

static sheen_status fill(sheen_gbuffer *out, const view *v, sheen_err *err)
{
    const sheen_mesh *mesh = v->mesh;
    sheen_projected at = {.q_px = malloc(mesh->n_vertices * 2 * sizeof *at.q_px),
                          .inverse_z_m = malloc(mesh->n_vertices * sizeof *at.inverse_z_m)};
    sheen_status s = SHEEN_OK;
    if (!at.q_px || !at.inverse_z_m)
        s = sheen_fail_memory(err, 24.0 * (double)mesh->n_vertices, "the mesh's projection");
    else
        s = project_vertices(&at, mesh, v->cam, v->rt_cam_obj, err);
    if (s)
        goto done;
    set_window(out, mesh, v->cam, &at);
    if (!out->width_px)
        goto done;
    const size_t n = (size_t)out->samples_per_side * (size_t)out->samples_per_side;
    const size_t count = (size_t)out->width_px * (size_t)out->height_px * n;
    out->hits = malloc(count * sizeof *out->hits);
    if (!out->hits)
        s = sheen_fail_memory(err, 16.0 * (double)count, "a view's samples");
    else if (!v->only_rays && sheen_raster_can(out, v->cam, mesh, &at))
        s = sheen_raster_hits(out, mesh, v->cam, &at, v->n_threads, err);
    else
        s = trace(out, v->scene, v->cam, v->rt_cam_obj, v->n_threads, err);

done:
    free(at.inverse_z_m);
    free(at.q_px);
    return s;
}

static sheen_status make(sheen_gbuffer *out, const view *v, int samples_per_side, sheen_err *err)
{
    *out = (sheen_gbuffer){.samples_per_side = samples_per_side};
    sheen_status s = check(v->rt_cam_obj, samples_per_side, err);
    if (s)
        return s;
    double rt_obj_cam[6];
    sheen_rt_invert(rt_obj_cam, v->rt_cam_obj);
    memcpy(out->p_camera_obj, rt_obj_cam + 3, sizeof out->p_camera_obj);
    s = fill(out, v, err);
    if (s)
        sheen_gbuffer_release(out);
    return s;
}

sheen_status sheen_gbuffer_make(sheen_gbuffer *out, const sheen_scene *scene, const sheen_mesh *mesh,
                                const sheen_camera *cam, const double rt_cam_obj[6], int samples_per_side,
                                int n_threads, sheen_err *err)
{
    const view v = {scene, mesh, cam, rt_cam_obj, n_threads, false};
    return make(out, &v, samples_per_side, err);
}

sheen_status sheen_gbuffer_make_ref(sheen_gbuffer *out, const sheen_scene *scene, const sheen_mesh *mesh,
                                    const sheen_camera *cam, const double rt_cam_obj[6], int samples_per_side,
                                    int n_threads, sheen_err *err)
{
    const view v = {scene, mesh, cam, rt_cam_obj, n_threads, true};
    return make(out, &v, samples_per_side, err);
}

void sheen_gbuffer_release(sheen_gbuffer *g)
{
    free(g->hits);
    *g = (sheen_gbuffer){0};
}

void sheen_hit_surface(const sheen_mesh *mesh, const sheen_hit *hit, const double p_camera_obj[3],
                       float p_obj[3], float n_obj[3], float v_obj[3])
{
    const uint32_t *corner = mesh->triangles + 3 * (size_t)hit->triangle;
    const float b[3] = {1 - hit->b1 - hit->b2, hit->b1, hit->b2};
    float p[3] = {0, 0, 0}, n[3] = {0, 0, 0};
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 3; k++) {
            p[k] += b[c] * mesh->p_obj[3 * (size_t)corner[c] + (size_t)k];
            n[k] += b[c] * mesh->n_obj[3 * (size_t)corner[c] + (size_t)k];
        }
    if (p_obj)
        memcpy(p_obj, p, sizeof p);
    if (n_obj) {
        sheen_normalizef(n);
        memcpy(n_obj, n, sizeof n);
    }
    if (v_obj) {
        for (int k = 0; k < 3; k++)
            v_obj[k] = (float)(p_camera_obj[k] - (double)p[k]);
        sheen_normalizef(v_obj);
    }
}

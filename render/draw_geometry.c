// SPDX-License-Identifier: Apache-2.0
// draw_geometry.c - depth, normals and mask of a view, from the same first hits as its picture.
#include "render/draw_geometry.h"

#include "base/parallel.h"
#include "base/pose3.h"
#include "base/vec.h"
#include "render/draw_private.h"
#include "render/gbuffer.h"

typedef struct job {
    const sheen_gbuffer *g;
    const sheen_model *model;
    sheen_Rt Rt_cam_obj;
    sheen_geometry *out;
} job;

static void fill_pixel(const job *j, const sheen_hit *hit, int x, int y)
{
    float p[3], n[3];
    double p_cam[3], n_cam[3];
    sheen_normal_map_surface(&j->model->mesh, &j->model->normals, hit, j->g->p_camera_obj, p, n, NULL);
    const double p_obj[3] = {(double)p[0], (double)p[1], (double)p[2]};
    const double n_obj[3] = {(double)n[0], (double)n[1], (double)n[2]};
    sheen_Rt_point(p_cam, &j->Rt_cam_obj, p_obj);
    sheen_Rt_direction(n_cam, &j->Rt_cam_obj, n_obj);
    *sheen_image_at(&j->out->depth_m, x, y) = (float)p_cam[2];
    *sheen_image_at(&j->out->mask, x, y) = 1;
    for (int k = 0; k < 3; k++)
        sheen_image_at(&j->out->n_cam, x, y)[k] = (float)n_cam[k];
}

static void fill_rows(void *self, size_t begin, size_t end)
{
    const job *j = self;
    const sheen_gbuffer *g = j->g;
    for (size_t row = begin; row < end; row++)
        for (int x = 0; x < g->width_px; x++) {
            const sheen_hit *hit = g->hits + row * (size_t)g->width_px + (size_t)x;
            if (hit->triangle != SHEEN_NO_HIT)
                fill_pixel(j, hit, g->x0_px + x, g->y0_px + (int)row);
        }
}

sheen_status sheen_draw_geometry(sheen_geometry *out, const sheen_drawing *d, const sheen_camera *cam,
                                 const double rt_cam_obj[6], int n_threads, sheen_err *err)
{
    *out = (sheen_geometry){0};
    sheen_gbuffer g;
    sheen_status s = sheen_gbuffer_make(&g, d->scene, &d->model->mesh, cam, rt_cam_obj, 1, n_threads, err);
    if (s)
        return s;
    s = sheen_image_init(&out->depth_m, cam->width_px, cam->height_px, 1, err);
    if (!s)
        s = sheen_image_init(&out->n_cam, cam->width_px, cam->height_px, 3, err);
    if (!s)
        s = sheen_image_init(&out->mask, cam->width_px, cam->height_px, 1, err);
    if (!s) {
        job j = {.g = &g, .model = d->model, .out = out};
        sheen_Rt_from_rt(&j.Rt_cam_obj, rt_cam_obj);
        sheen_parallel_for((size_t)g.height_px, 16, n_threads, fill_rows, &j);
    } else {
        sheen_geometry_release(out);
    }
    sheen_gbuffer_release(&g);
    return s;
}

void sheen_geometry_release(sheen_geometry *g)
{
    sheen_image_release(&g->depth_m);
    sheen_image_release(&g->n_cam);
    sheen_image_release(&g->mask);
    *g = (sheen_geometry){0};
}

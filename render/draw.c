// SPDX-License-Identifier: Apache-2.0
// draw.c - pictures of a model by section 5: texture, plus specular reflection by eq. (7), added at each
// sample.
//
// Interpolated normals turn away from the camera near outlines, where eq. (7) has no answer: there a normal
// is bent towards the camera until its cosine is MIN_FACING, so that highlights run on to the outline instead
// of breaking off in black speckles. A triangle seen from behind (the inside of an open mesh) has no specular
// part.
#include "render/draw.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/pose3.h"
#include "base/vec.h"
#include "render/gbuffer.h"
#include "render/shade.h"

#define MIN_FACING 0.01f

enum { DEFAULT_SAMPLES_PER_SIDE = 2 };

struct sheen_drawing {
    const sheen_model *model;
    sheen_scene *scene;
    sheen_light_cells *cells;
};

void sheen_layers_release(sheen_layers *l)
{
    sheen_image_release(&l->diffuse);
    sheen_image_release(&l->specular);
    sheen_image_release(&l->composite);
    sheen_image_release(&l->coverage);
    sheen_image_release(&l->holes);
    *l = (sheen_layers){0};
}

sheen_status sheen_drawing_new(sheen_drawing **out, const sheen_model *model, sheen_err *err)
{
    *out = NULL;
    if (!model->mesh.n_triangles || model->texture.n_triangles != model->mesh.n_triangles)
        return sheen_fail(err, SHEEN_EARG,
                          "cannot draw a model whose texture has %zu triangles and whose mesh has %zu",
                          model->texture.n_triangles, model->mesh.n_triangles);
    if (!(model->sigma_rad > 0))
        return sheen_fail(err, SHEEN_EARG, "cannot draw a model of roughness %g", model->sigma_rad);
    sheen_drawing *d = calloc(1, sizeof *d);
    if (!d)
        return sheen_fail_memory(err, (double)sizeof *d, "a drawing");
    d->model = model;
    sheen_status s = sheen_scene_new(&d->scene, &model->mesh, err);
    if (!s)
        s = sheen_light_cells_new(&d->cells, &model->lights, (float)model->sigma_rad, err);
    if (s)
        sheen_drawing_free(&d);
    *out = d;
    return s;
}

void sheen_drawing_free(sheen_drawing **d)
{
    if (!*d)
        return;
    sheen_scene_free(&(*d)->scene);
    sheen_light_cells_free(&(*d)->cells);
    free(*d);
    *d = NULL;
}

typedef struct job {
    const sheen_drawing *drawing;
    const sheen_gbuffer *g;
    const sheen_draw_options *options;
    sheen_layers *out;
    sheen_shading shading;
} job;

// Sums over a pixel's samples.
typedef struct sums {
    float diffuse[3], specular[3], coverage, holes;
} sums;

static bool seen_from_behind(const sheen_mesh *mesh, uint32_t triangle, const float v_obj[3])
{
    const uint32_t *corner = mesh->triangles + 3 * (size_t)triangle;
    const float *p = mesh->p_obj + 3 * (size_t)corner[0];
    float a[3], b[3], n[3];
    sheen_subf(a, mesh->p_obj + 3 * (size_t)corner[1], p);
    sheen_subf(b, mesh->p_obj + 3 * (size_t)corner[2], p);
    sheen_crossf(n, a, b);
    return sheen_dotf(n, v_obj) < 0;
}

static void add_specular(float sum[3], const job *j, const sheen_hit *hit)
{
    const sheen_mesh *mesh = &j->drawing->model->mesh;
    float p_obj[3], n_obj[3], v_obj[3], rgb[3];
    sheen_hit_surface(mesh, hit, j->g->p_camera_obj, p_obj, n_obj, v_obj);
    const float facing = sheen_dotf(n_obj, v_obj);
    if (facing < MIN_FACING) {
        if (seen_from_behind(mesh, hit->triangle, v_obj))
            return;
        // The nearest direction to n whose cosine with v is MIN_FACING: its part across v stays, its length
        // is made up.
        float across[3];
        for (int k = 0; k < 3; k++)
            across[k] = n_obj[k] - facing * v_obj[k];
        if (!(sheen_normalizef(across) > 0))
            return;
        const float side = sqrtf(1 - MIN_FACING * MIN_FACING);
        for (int k = 0; k < 3; k++)
            n_obj[k] = side * across[k] + MIN_FACING * v_obj[k];
    }
    sheen_shade(rgb, &j->shading, p_obj, n_obj, v_obj);
    for (int c = 0; c < 3; c++)
        sum[c] += rgb[c];
}

static void add_sample(sums *s, const job *j, const sheen_hit *hit)
{
    if (hit->triangle == SHEEN_NO_HIT)
        return;
    float rgb[3];
    s->coverage += 1;
    if (!(sheen_texture_sample(&j->drawing->model->texture, hit, rgb) > 0)) {
        s->holes += 1;
        if (j->options->mark_holes)
            memcpy(rgb, j->options->hole_rgb, sizeof rgb);
    }
    for (int c = 0; c < 3; c++)
        s->diffuse[c] += rgb[c];
    add_specular(s->specular, j, hit);
}

static void draw_rows(void *self, size_t begin, size_t end)
{
    const job *j = self;
    const sheen_gbuffer *g = j->g;
    const int n = g->samples_per_side;
    const size_t stride = (size_t)g->width_px * (size_t)n;
    const float share = 1.0f / (float)(n * n);
    for (size_t row = begin; row < end; row++)
        for (int x = 0; x < g->width_px; x++) {
            sums s = {0};
            for (int sy = 0; sy < n; sy++)
                for (int sx = 0; sx < n; sx++)
                    add_sample(&s, j,
                               g->hits + (row * (size_t)n + (size_t)sy) * stride + (size_t)(x * n + sx));
            if (!(s.coverage > 0))
                continue;
            const int at_x = g->x0_px + x, at_y = g->y0_px + (int)row;
            float *diffuse = sheen_image_at(&j->out->diffuse, at_x, at_y);
            float *specular = sheen_image_at(&j->out->specular, at_x, at_y);
            float *composite = sheen_image_at(&j->out->composite, at_x, at_y);
            const float coverage = s.coverage * share;
            for (int c = 0; c < 3; c++) {
                diffuse[c] = s.diffuse[c] * share;
                specular[c] = s.specular[c] * share;
                composite[c] = diffuse[c] + specular[c] + (1 - coverage) * j->options->background_rgb[c];
            }
            *sheen_image_at(&j->out->coverage, at_x, at_y) = coverage;
            *sheen_image_at(&j->out->holes, at_x, at_y) = s.holes * share;
        }
}

static sheen_status make_layers(sheen_layers *out, const sheen_camera *cam, const float background_rgb[3],
                                sheen_err *err)
{
    *out = (sheen_layers){0};
    sheen_status s = sheen_image_init(&out->diffuse, cam->width_px, cam->height_px, 3, err);
    if (!s)
        s = sheen_image_init(&out->specular, cam->width_px, cam->height_px, 3, err);
    if (!s)
        s = sheen_image_init(&out->composite, cam->width_px, cam->height_px, 3, err);
    if (!s)
        s = sheen_image_init(&out->coverage, cam->width_px, cam->height_px, 1, err);
    if (!s)
        s = sheen_image_init(&out->holes, cam->width_px, cam->height_px, 1, err);
    if (s)
        return s;
    const size_t n = (size_t)cam->width_px * (size_t)cam->height_px;
    for (size_t i = 0; i < n; i++)
        memcpy(out->composite.data + 3 * i, background_rgb, 3 * sizeof *background_rgb);
    return SHEEN_OK;
}

sheen_status sheen_draw(sheen_layers *out, const sheen_drawing *d, const sheen_camera *cam,
                        const double rt_cam_obj[6], const double *rt_world_obj,
                        const sheen_draw_options *options, sheen_err *err)
{
    static const sheen_draw_options defaults = {0};
    const sheen_draw_options *o = options ? options : &defaults;
    const int samples = o->samples_per_side ? o->samples_per_side : DEFAULT_SAMPLES_PER_SIDE;
    *out = (sheen_layers){0};
    if (!rt_world_obj)
        rt_world_obj = d->model->rt_world_obj;
    for (int i = 0; i < 6; i++)
        if (!isfinite(rt_world_obj[i]))
            return sheen_fail(err, SHEEN_EARG, "the object's pose under the lights is not finite");
    sheen_gbuffer g;
    sheen_status s = sheen_gbuffer_make(&g, d->scene, &d->model->mesh, cam, rt_cam_obj, samples, o->n_threads,
                                        err);
    if (s)
        return s;
    s = make_layers(out, cam, o->background_rgb, err);
    if (!s) {
        job j = {.drawing = d, .g = &g, .options = o, .out = out};
        sheen_shading_init(&j.shading, d->model, d->scene, d->cells, rt_world_obj);
        sheen_parallel_for((size_t)g.height_px, 4, o->n_threads, draw_rows, &j);
    } else {
        sheen_layers_release(out);
    }
    sheen_gbuffer_release(&g);
    return s;
}

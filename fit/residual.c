// SPDX-License-Identifier: Apache-2.0
// residual.c - subtracts the texture-mapped image from the photograph.
#include "fit/residual.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/pose3.h"
#include "base/vec.h"
#include "fit/depth_edges.h"
#include "fit/texel_view.h"
#include "render/normal_map.h"

static const float clipped_lin = 0.97f;

// The least number of photographs that saw any of the lattice points about a hit.
static int least_views(const sheen_texture *t, const sheen_hit *h)
{
    const int last = t->texels_per_edge - 1;
    const float u = h->b1 * (float)last, v = h->b2 * (float)last;
    const int i0 = (int)fmaxf(0, floorf(u)), j0 = (int)fmaxf(0, floorf(v));
    const uint8_t *n = t->n_views + h->triangle * sheen_texels_per_triangle(t->texels_per_edge);
    int least = 255;
    for (int j = j0; j <= j0 + 1 && j <= last; j++)
        for (int i = i0; i <= i0 + 1 && i + j <= last; i++) {
            const int views = n[sheen_texel_index(t->texels_per_edge, i, j)];
            if (views < least)
                least = views;
        }
    return least;
}

typedef struct residual_view {
    const sheen_mesh *mesh;
    const sheen_texture *texture, *normals;
    const sheen_gbuffer *g;
    const sheen_photo *photo;
    sheen_Rt Rt_world_obj;
    float footprint_per_m;
} residual_view;

static void turn(float out[3], const sheen_Rt *Rt, const float in[3])
{
    const double v[3] = {(double)in[0], (double)in[1], (double)in[2]};
    double r[3];
    sheen_Rt_direction(r, Rt, v);
    for (int i = 0; i < 3; i++)
        out[i] = (float)r[i];
}

// False where the pixel does not count.
static bool make_pixel(sheen_residual_pixel *out, const residual_view *view, int x, int y)
{
    const sheen_gbuffer *g = view->g;
    const sheen_hit *h = &g->hits[(size_t)y * (size_t)g->width_px + (size_t)x];
    if (h->triangle == SHEEN_NO_HIT || least_views(view->texture, h) < 2)
        return false;
    float n_obj[3], v_obj[3], diffuse[3];
    sheen_normal_map_surface(view->mesh, view->normals, h, g->p_camera_obj, out->p_obj, n_obj, v_obj);
    const float cosine = sheen_dotf(n_obj, v_obj);
    out->x_px = x + g->x0_px;
    out->y_px = y + g->y0_px;
    if (cosine < SHEEN_SEEN_MIN_COS ||
        !sheen_clear_of_depth_edges(g, out->x_px, out->y_px, h->t_m, cosine, view->footprint_per_m))
        return false;
    const sheen_image *mask = &view->photo->mask;
    if (mask->data && *sheen_image_at(mask, out->x_px, out->y_px) < 0.99f)
        return false;
    sheen_texture_sample(view->texture, h, diffuse);
    const float *photo = sheen_image_at(&view->photo->image, out->x_px, out->y_px);
    sheen_subf(out->rgb, photo, diffuse);
    out->clipped = photo[0] >= clipped_lin || photo[1] >= clipped_lin || photo[2] >= clipped_lin;
    for (int c = 0; c < 3; c++)
        out->texture_root[c] = (uint8_t)(255 * sqrtf(fminf(1, fmaxf(0, diffuse[c]))) + 0.5f);
    turn(out->n_world, &view->Rt_world_obj, n_obj);
    turn(out->v_world, &view->Rt_world_obj, v_obj);
    return true;
}

typedef struct rows_job {
    const residual_view *view;
    sheen_residual_pixel *pixels; // [height][width]
    size_t *count;                // [height]
} rows_job;

static void make_rows(void *self, size_t begin, size_t end)
{
    const rows_job *j = self;
    const size_t width = (size_t)j->view->g->width_px;
    for (size_t y = begin; y < end; y++)
        for (int x = 0; x < (int)width; x++)
            j->count[y] += make_pixel(&j->pixels[y * width + j->count[y]], j->view, x, (int)y);
}

// Every row has its own room; then they are pushed together.
static sheen_status make_pixels(sheen_residual *out, const residual_view *view, int n_threads, sheen_err *err)
{
    const size_t width = (size_t)view->g->width_px, height = (size_t)view->g->height_px;
    rows_job j = {view, malloc((width * height + 1) * sizeof *out->pixels),
                  calloc(height + 1, sizeof *j.count)};
    out->pixels = j.pixels;
    if (!j.pixels || !j.count) {
        free(j.count);
        sheen_residual_release(out);
        return sheen_fail_memory(err, (double)(width * height * sizeof *out->pixels), "a residual image");
    }
    sheen_parallel_for(height, 8, n_threads, make_rows, &j);
    for (size_t y = 0; y < height; y++) {
        memmove(out->pixels + out->count, out->pixels + y * width, j.count[y] * sizeof *out->pixels);
        out->count += j.count[y];
    }
    free(j.count);
    sheen_residual_pixel *fitted = realloc(out->pixels, (out->count + 1) * sizeof *fitted);
    if (fitted)
        out->pixels = fitted;
    return SHEEN_OK;
}

sheen_status sheen_residual_make(sheen_residual *out, const sheen_mesh *mesh, const sheen_model *model,
                                 const sheen_gbuffer *g, const sheen_camera *cam, const sheen_photo *photo,
                                 int n_threads, sheen_err *err)
{
    *out = (sheen_residual){0};
    residual_view view = {mesh, &model->texture, &model->normals,
                          g,    photo,           .footprint_per_m = 1.0f / (float)cam->intrinsics[0]};
    sheen_Rt_from_rt(&view.Rt_world_obj, photo->rt_world_obj);
    return make_pixels(out, &view, n_threads, err);
}

void sheen_residual_release(sheen_residual *r)
{
    free(r->pixels);
    *r = (sheen_residual){0};
}

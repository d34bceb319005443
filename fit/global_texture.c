// SPDX-License-Identifier: Apache-2.0
// global_texture.c - running minimum over the photographs, one at a time, so that memory does not grow with them.
#include "fit/global_texture.h"

#include <string.h>

#include "base/parallel.h"

typedef struct merge_job {
    sheen_texture *texture;
    const sheen_texel_view *view;
} merge_job;

static void merge(void *self, size_t begin, size_t end)
{
    const merge_job *j = self;
    for (size_t i = begin; i < end; i++) {
        if (!j->view->seen[i])
            continue;
        float *kept = j->texture->rgb + 3 * i;
        const float *rgb = j->view->rgb + 3 * i;
        if (!j->texture->n_views[i] || sheen_luminance(rgb) < sheen_luminance(kept))
            memcpy(kept, rgb, 3 * sizeof *rgb);
        if (j->texture->n_views[i] < 255)
            j->texture->n_views[i]++;
    }
}

static bool sees_anything(const sheen_texture *t, size_t n_texels)
{
    for (size_t i = 0; i < n_texels; i++)
        if (t->n_views[i])
            return true;
    return false;
}

sheen_status sheen_global_texture_minimum(sheen_texture *out, const sheen_mesh *mesh,
                                          const sheen_scene *scene, const sheen_photos *photos,
                                          const sheen_gbuffer *gbuffers,
                                          const sheen_global_texture_options *o, sheen_err *err)
{
    *out = (sheen_texture){0};
    sheen_texel_view own = {0};
    sheen_status s = sheen_texture_init(out, mesh->n_triangles, o->texels_per_edge, err);
    for (size_t i = 0; i < photos->count && !s; i++) {
        sheen_texel_view *view = o->keep ? &o->keep[i] : &own;
        if ((s = sheen_progress_step(o->progress, "global texture", (int)i, (int)photos->count, err)) ||
            (!view->seen && (s = sheen_texel_view_init(view, mesh->n_triangles, o->texels_per_edge, err))))
            break;
        sheen_texel_view_fill(view, mesh, scene, &gbuffers[i], &photos->cam, &photos->photos[i],
                              o->texels_per_edge, o->n_threads);
        merge_job j = {out, view};
        sheen_parallel_for(view->n_texels, 16384, o->n_threads, merge, &j);
    }
    const size_t n_texels = mesh->n_triangles * sheen_texels_per_triangle(o->texels_per_edge);
    if (!s && !sees_anything(out, n_texels))
        s = sheen_fail(err, SHEEN_EDATA,
                       "no photograph sees any part of the mesh: check that mesh, poses and camera "
                       "belong together and that the mesh is in metres");
    sheen_texel_view_release(&own);
    if (s)
        sheen_texture_release(out);
    return s;
}

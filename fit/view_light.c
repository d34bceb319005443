// SPDX-License-Identifier: Apache-2.0
// view_light.c - shades every texel that a photograph sees.
#include "fit/view_light.h"

#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/vec.h"

sheen_status sheen_view_light_init(sheen_view_light *l, size_t n_texels, sheen_err *err)
{
    l->n_texels = n_texels;
    l->lights_rgb = malloc((3 * n_texels + 1) * sizeof(float));
    l->mirrored_rgb = malloc((3 * n_texels + 1) * sizeof(float));
    l->above_world = malloc((3 * n_texels + 1) * sizeof(float));
    l->cosine = malloc((n_texels + 1) * sizeof(float));
    if (!l->lights_rgb || !l->mirrored_rgb || !l->above_world || !l->cosine) {
        sheen_view_light_release(l);
        return sheen_fail_memory(err, 40.0 * (double)n_texels, "the light of one photograph");
    }
    return SHEEN_OK;
}

void sheen_view_light_release(sheen_view_light *l)
{
    free(l->lights_rgb);
    free(l->mirrored_rgb);
    free(l->above_world);
    free(l->cosine);
    *l = (sheen_view_light){0};
}

typedef struct job {
    sheen_view_light *out;
    const sheen_shading *shading;
    const sheen_texel_view *seen;
    float camera_obj[3];
} job;

static void shade_texel(const job *j, size_t texel, const float p_obj[3], const float n_obj[3])
{
    float v_obj[3];
    sheen_subf(v_obj, j->camera_obj, p_obj);
    sheen_normalizef(v_obj);
    j->out->cosine[texel] = sheen_dotf(n_obj, v_obj);
    sheen_shade_lights(j->out->lights_rgb + 3 * texel, j->shading, p_obj, n_obj, v_obj);
    sheen_shade_split(j->out->mirrored_rgb + 3 * texel, j->out->above_world + 3 * texel, j->shading, p_obj,
                      n_obj, v_obj);
}

static void shade_triangles(void *self, size_t begin, size_t end)
{
    const job *j = self;
    const sheen_mesh *mesh = &j->shading->model->mesh;
    const int edge = j->shading->model->texture.texels_per_edge;
    const size_t per_triangle = sheen_texels_per_triangle(edge);
    float p_obj[3 * SHEEN_TEXTURE_MAX_EDGE * (SHEEN_TEXTURE_MAX_EDGE + 1) / 2];
    float n_obj[3 * SHEEN_TEXTURE_MAX_EDGE * (SHEEN_TEXTURE_MAX_EDGE + 1) / 2];
    for (size_t f = begin; f < end; f++) {
        const uint8_t *seen = j->seen->seen + f * per_triangle;
        if (!memchr(seen, 1, per_triangle))
            continue;
        sheen_texture_lattice(mesh, f, edge, p_obj, n_obj);
        for (size_t k = 0; k < per_triangle; k++)
            if (seen[k])
                shade_texel(j, f * per_triangle + k, p_obj + 3 * k, n_obj + 3 * k);
    }
}

void sheen_view_light_fill(sheen_view_light *l, const sheen_shading *shading, const sheen_texel_view *seen,
                           const double p_camera_obj[3], int n_threads)
{
    job j = {.out = l, .shading = shading, .seen = seen};
    for (int i = 0; i < 3; i++)
        j.camera_obj[i] = (float)p_camera_obj[i];
    sheen_parallel_for(shading->model->mesh.n_triangles, 64, n_threads, shade_triangles, &j);
}

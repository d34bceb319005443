// SPDX-License-Identifier: Apache-2.0
// view_light.c - shades every texel that a photograph sees.
#include "fit/view_light.h"

#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/vec.h"

sheen_status sheen_view_light_init(sheen_view_light *l, size_t n_texels, sheen_err *err)
{
    *l = (sheen_view_light){.n_texels = n_texels};
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

enum { MAX_TEXELS = SHEEN_TEXTURE_MAX_EDGE * (SHEEN_TEXTURE_MAX_EDGE + 1) / 2 };

typedef struct job {
    sheen_view_light *out;
    const sheen_shading *shading;
    const sheen_texel_view *seen;
    float camera_obj[3];
    int with_mirrored;
} job;

// The seen texels of one triangle, side by side.
typedef struct patch {
    size_t texel[MAX_TEXELS], n;
    float p_obj[3 * MAX_TEXELS], n_obj[3 * MAX_TEXELS], v_obj[3 * MAX_TEXELS];
} patch;

static void gather_patch(patch *q, const job *j, size_t triangle, int edge)
{
    const size_t per_triangle = sheen_texels_per_triangle(edge);
    const uint8_t *seen = j->seen->seen + triangle * per_triangle;
    q->n = 0;
    if (!memchr(seen, 1, per_triangle))
        return;
    sheen_normal_map_lattice(&j->shading->model->mesh, &j->shading->model->normals, triangle, edge, q->p_obj,
                             q->n_obj);
    for (size_t k = 0; k < per_triangle; k++) {
        if (!seen[k])
            continue;
        const size_t to = q->n++;
        q->texel[to] = triangle * per_triangle + k;
        memmove(q->p_obj + 3 * to, q->p_obj + 3 * k, 3 * sizeof(float));
        memmove(q->n_obj + 3 * to, q->n_obj + 3 * k, 3 * sizeof(float));
        sheen_subf(q->v_obj + 3 * to, j->camera_obj, q->p_obj + 3 * to);
        sheen_normalizef(q->v_obj + 3 * to);
    }
}

static void shade_triangles(void *self, size_t begin, size_t end)
{
    const job *j = self;
    const int edge = j->shading->model->texture.texels_per_edge;
    for (size_t f = begin; f < end; f++) {
        patch q;
        float rgb[3 * MAX_TEXELS], above_world[3 * MAX_TEXELS];
        gather_patch(&q, j, f, edge);
        if (j->with_mirrored)
            sheen_shade_split(rgb, above_world, j->shading, q.p_obj, q.n_obj, q.v_obj, q.n);
        const int shines = sheen_shade_may_shine(j->shading, q.p_obj, q.n_obj, q.v_obj, q.n);
        for (size_t k = 0; k < q.n; k++) {
            const size_t texel = q.texel[k];
            j->out->cosine[texel] = sheen_dotf(q.n_obj + 3 * k, q.v_obj + 3 * k);
            memset(j->out->lights_rgb + 3 * texel, 0, 3 * sizeof *rgb);
            if (shines)
                sheen_shade_lights(j->out->lights_rgb + 3 * texel, j->shading, q.p_obj + 3 * k,
                                   q.n_obj + 3 * k, q.v_obj + 3 * k);
            for (int c = 0; c < 3 && j->out->gloss; c++)
                j->out->lights_rgb[3 * texel + (size_t)c] *= j->out->gloss[texel];
            if (!j->with_mirrored)
                continue;
            memcpy(j->out->mirrored_rgb + 3 * texel, rgb + 3 * k, 3 * sizeof *rgb);
            memcpy(j->out->above_world + 3 * texel, above_world + 3 * k, 3 * sizeof *above_world);
        }
    }
}

void sheen_view_light_fill(sheen_view_light *l, const sheen_shading *shading, const sheen_texel_view *seen,
                           const double p_camera_obj[3], int with_mirrored, int n_threads)
{
    job j = {.out = l, .shading = shading, .seen = seen, .with_mirrored = with_mirrored};
    for (int i = 0; i < 3; i++)
        j.camera_obj[i] = (float)p_camera_obj[i];
    sheen_parallel_for(shading->model->mesh.n_triangles, 128, n_threads, shade_triangles, &j);
}

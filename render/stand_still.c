// SPDX-License-Identifier: Apache-2.0
// stand_still.c - multiplies the texture by the light on it.
#include "render/stand_still.h"

#include "base/parallel.h"
#include "render/shade.h"

typedef struct job {
    sheen_model *m;
    const sheen_shading *shading;
} job;

static void light_triangles(void *self, size_t begin, size_t end)
{
    const job *j = self;
    sheen_texture *t = &j->m->texture;
    const size_t per_triangle = sheen_texels_per_triangle(t->texels_per_edge);
    float p_obj[3 * SHEEN_TEXTURE_MAX_EDGE * (SHEEN_TEXTURE_MAX_EDGE + 1) / 2];
    float n_obj[3 * SHEEN_TEXTURE_MAX_EDGE * (SHEEN_TEXTURE_MAX_EDGE + 1) / 2];
    for (size_t f = begin; f < end; f++) {
        sheen_normal_map_lattice(&j->m->mesh, &j->m->normals, f, t->texels_per_edge, p_obj, n_obj);
        for (size_t k = 0; k < per_triangle; k++) {
            float light[3];
            sheen_shade_irradiance(light, j->shading, p_obj + 3 * k, n_obj + 3 * k);
            for (size_t c = 0; c < 3; c++)
                t->rgb[3 * (f * per_triangle + k) + c] *= light[c];
        }
    }
}

sheen_status sheen_model_stand_still(sheen_model *m, int n_threads, sheen_err *err)
{
    sheen_scene *scene = NULL;
    sheen_shading shading;
    if (m->moving != SHEEN_MOVING_OBJECT)
        return SHEEN_OK;
    if (m->irradiance.present) {
        const sheen_status s = sheen_scene_new(&scene, &m->mesh, err);
        if (s)
            return s;
        sheen_shading_init(&shading, m, scene, NULL, NULL, m->rt_world_obj);
        job j = {m, &shading};
        sheen_parallel_for(m->mesh.n_triangles, 64, n_threads, light_triangles, &j);
        sheen_scene_free(&scene);
    }
    m->irradiance.present = 0;
    m->moving = SHEEN_MOVING_CAMERA;
    return SHEEN_OK;
}

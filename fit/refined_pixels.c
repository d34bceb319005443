// SPDX-License-Identifier: Apache-2.0
// refined_pixels.c - how the normal changes across a sample's pixel, by central differences over the gbuffer.
#include "base/vec.h"
#include "fit/refined_state.h"

// False where the view shows no surface there.
static int normal_at(float n_world[3], const sheen_refined_state *r, const sheen_lamp_sample *s, int x_px,
                     int y_px)
{
    const sheen_gbuffer *g = &r->f->gbuffers[s->view];
    const int x = x_px - g->x0_px, y = y_px - g->y0_px;
    if (x < 0 || y < 0 || x >= g->width_px || y >= g->height_px)
        return 0;
    const sheen_hit *hit = &g->hits[(size_t)y * (size_t)g->width_px + (size_t)x];
    float p_obj[3], n_obj[3], v_obj[3];
    if (hit->triangle == SHEEN_NO_HIT)
        return 0;
    sheen_normal_map_surface(r->mesh, &r->f->model.normals, hit, g->p_camera_obj, p_obj, n_obj, v_obj);
    for (int i = 0; i < 3; i++)
        n_world[i] = sheen_dotf(r->shading[s->view].R_world_obj[i], n_obj);
    return 1;
}

void sheen_refined_normal_steps(sheen_lamp_samples *samples, const sheen_refined_state *r)
{
    for (size_t i = 0; i < samples->count; i++) {
        sheen_lamp_sample *s = &samples->at[i];
        for (int k = 0; k < 2; k++) {
            float before[3], after[3];
            if (!normal_at(before, r, s, s->x_px - !k, s->y_px - k) ||
                !normal_at(after, r, s, s->x_px + !k, s->y_px + k))
                continue;
            for (int c = 0; c < 3; c++)
                s->n_step[k][c] = 0.5f * (after[c] - before[c]);
        }
    }
}

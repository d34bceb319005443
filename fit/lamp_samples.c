// SPDX-License-Identifier: Apache-2.0
// lamp_samples.c - picks residual pixels, lit and dark, on checkerboards.
#include "fit/lamp_samples.h"

#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"

static int is_lit(const sheen_residual_pixel *p, float threshold_lin)
{
    return p->clipped || sheen_luminance(p->rgb) > threshold_lin;
}

static void to_world(float out[3], const sheen_Rt *Rt, const float p_obj[3])
{
    const double p[3] = {(double)p_obj[0], (double)p_obj[1], (double)p_obj[2]};
    double q[3];
    sheen_Rt_point(q, Rt, p);
    for (int i = 0; i < 3; i++)
        out[i] = (float)q[i];
}

static void add(sheen_lamp_samples *out, const sheen_residual_pixel *p, const sheen_Rt *Rt_world_obj,
                size_t view, int lit, const sheen_gloss *gloss)
{
    sheen_lamp_sample *s = &out->at[out->count++];
    *s = (sheen_lamp_sample){.view = (uint32_t)view, .clipped = p->clipped, .lit = (uint8_t)lit};
    to_world(s->x_m, Rt_world_obj, p->p_obj);
    for (int i = 0; i < 3; i++)
        s->x_m[i] -= out->origin_world[i];
    memcpy(s->n_world, p->n_world, sizeof s->n_world);
    memcpy(s->v_world, p->v_world, sizeof s->v_world);
    memcpy(s->p_obj, p->p_obj, sizeof s->p_obj);
    memcpy(s->rgb, p->rgb, sizeof s->rgb);
    s->Y = sheen_luminance(p->rgb);
    for (int c = 0; c < 3; c++)
        s->texture_root[c] = (float)p->texture_root[c] / 255;
    s->gloss = gloss ? sheen_gloss_at_root(gloss, s->texture_root) : 1;
    out->n_lit += (size_t)lit;
}

sheen_status sheen_lamp_samples_take(sheen_lamp_samples *out, const sheen_residual *residuals,
                                     const sheen_photos *photos, const float centre_obj[3], float radius_m,
                                     const sheen_lamp_samples_options *o, sheen_err *err)
{
    *out = (sheen_lamp_samples){.n_views = photos->count, .radius_m = radius_m};
    size_t n[2] = {0, 0}, i_of[2] = {0, 0};
    for (size_t v = 0; v < photos->count; v++)
        for (size_t i = 0; i < residuals[v].count; i++)
            n[is_lit(&residuals[v].pixels[i], o->threshold_lin)]++;
    const size_t most[2] = {o->max_dark ? o->max_dark : 1, o->max_lit ? o->max_lit : 1};
    size_t step[2];
    for (int k = 0; k < 2; k++)
        step[k] = n[k] > most[k] ? (n[k] + most[k] - 1) / most[k] : 1;
    const size_t room = n[0] / step[0] + n[1] / step[1] + 2;
    out->at = malloc(room * sizeof *out->at);
    if (!out->at)
        return sheen_fail_memory(err, (double)(room * sizeof *out->at), "samples of the residual images");
    for (size_t v = 0; v < photos->count; v++) {
        sheen_Rt Rt_world_obj;
        sheen_Rt_from_rt(&Rt_world_obj, photos->photos[v].rt_world_obj);
        if (!v)
            to_world(out->origin_world, &Rt_world_obj, centre_obj);
        for (size_t i = 0; i < residuals[v].count; i++) {
            const sheen_residual_pixel *p = &residuals[v].pixels[i];
            const int lit = is_lit(p, o->threshold_lin);
            if (i_of[lit]++ % step[lit] == 0)
                add(out, p, &Rt_world_obj, v, lit, o->gloss);
        }
    }
    return SHEEN_OK;
}

void sheen_lamp_samples_release(sheen_lamp_samples *s)
{
    free(s->at);
    *s = (sheen_lamp_samples){0};
}

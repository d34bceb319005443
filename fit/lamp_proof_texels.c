// SPDX-License-Identifier: Apache-2.0
// lamp_proof_texels.c - takes the samples by which lamps are judged from the photographs' texels.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "base/vec.h"
#include "fit/diffuse.h"
#include "fit/refined_state.h"

enum {
    MOST_TEXELS = 20000,
    MOST_SAMPLES = 8 * MOST_TEXELS,
    MAX_TEXELS = SHEEN_TEXTURE_MAX_EDGE * (SHEEN_TEXTURE_MAX_EDGE + 1) / 2
};

static const float clipped_lin = 0.97f;
static const float interpolated_pixels =
    1.7f; // sqrt(3): variance 1/12 of a pixel, and 1/6, the mean of f (1 - f), of interpolation

static void to_world(float out[3], const sheen_shading *s, const float v_obj[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = sheen_dotf(s->R_world_obj[i], v_obj);
}

static void take(sheen_lamp_sample *out, const sheen_refined_state *r, size_t view, size_t texel,
                 const float p_obj[3], const float n_obj[3], const float origin_world[3])
{
    const sheen_model *m = &r->f->model;
    const sheen_shading *shading = &r->shading[view];
    float v_obj[3], E[3];
    double rgb[3];
    *out = (sheen_lamp_sample){.view = (uint32_t)view};
    for (int i = 0; i < 3; i++)
        v_obj[i] = (float)r->f->gbuffers[view].p_camera_obj[i] - p_obj[i];
    sheen_normalizef(v_obj);
    to_world(out->x_m, shading, p_obj);
    for (int i = 0; i < 3; i++)
        out->x_m[i] += shading->t_world_obj[i] - origin_world[i];
    to_world(out->n_world, shading, n_obj);
    to_world(out->v_world, shading, v_obj);
    memcpy(out->p_obj, p_obj, sizeof out->p_obj);
    sheen_diffuse_and_lights(rgb, &m->surroundings, &r->views[view], &r->lights[view], texel);
    sheen_shade_irradiance(E, shading, p_obj, n_obj);
    for (int c = 0; c < 3; c++) {
        // Of an object that turned, less what the turn itself changes
        out->rgb[c] = (float)rgb[c] - m->texture.rgb[3 * texel + (size_t)c] * (E[c] - 1);
        out->clipped |= r->views[view].rgb[3 * texel + (size_t)c] >= clipped_lin;
    }
    out->Y = sheen_luminance(out->rgb);
    for (size_t c = 0; c < 3; c++)
        out->texture_root[c] = sqrtf(fmaxf(0, m->texture.rgb[3 * texel + c]));
    out->gloss = sheen_gloss_at_root(&m->gloss, out->texture_root);
    out->weight = r->lights[view].cosine[texel];
}

// Pixel that a texel is seen at; its neighbours tell how the normal changes there.
static void place_in_picture(sheen_lamp_sample *s, const sheen_refined_state *r)
{
    sheen_Rt Rt_cam_obj;
    double p_cam[3], q_px[2];
    const double p_obj[3] = {(double)s->p_obj[0], (double)s->p_obj[1], (double)s->p_obj[2]};
    sheen_Rt_from_rt(&Rt_cam_obj, r->photos->photos[s->view].rt_cam_obj);
    sheen_Rt_point(p_cam, &Rt_cam_obj, p_obj);
    s->x_px = s->y_px = -1;
    if (!sheen_camera_project(&r->photos->cam, q_px, NULL, p_cam, 1, NULL) && fabs(q_px[0]) < 1e6 &&
        fabs(q_px[1]) < 1e6) {
        s->x_px = (int)lround(q_px[0]);
        s->y_px = (int)lround(q_px[1]);
    }
}

// A texel's colour is interpolated between pixels, each a mean over its own surface.
static void spread(sheen_lamp_samples *samples, const sheen_refined_state *r)
{
    for (size_t i = 0; i < samples->count; i++)
        place_in_picture(&samples->at[i], r);
    sheen_refined_normal_steps(samples, r);
    for (size_t i = 0; i < samples->count; i++)
        for (int k = 0; k < 2; k++)
            for (int c = 0; c < 3; c++)
                samples->at[i].n_step[k][c] *= interpolated_pixels;
}

static size_t times_seen(const sheen_refined_state *r, size_t texel)
{
    size_t n = 0;
    for (size_t v = 0; v < r->f->n_views; v++)
        n += r->views[v].seen[texel];
    return n;
}

// Texels from a choice of every step-th.
static void fill(sheen_lamp_proof *out, const sheen_refined_state *r, const float origin_world[3],
                 size_t step)
{
    const sheen_texture *t = &r->f->model.texture;
    const size_t per_triangle = sheen_texels_per_triangle(t->texels_per_edge);
    float p_obj[3 * MAX_TEXELS], n_obj[3 * MAX_TEXELS];
    size_t i_seen = 0;
    out->first[0] = 0;
    for (size_t f = 0; f < t->n_triangles; f++) {
        int placed = 0;
        for (size_t k = 0; k < per_triangle; k++) {
            const size_t texel = f * per_triangle + k;
            if (times_seen(r, texel) < 2 || i_seen++ % step)
                continue;
            if (!placed)
                sheen_normal_map_lattice(r->mesh, &r->f->model.normals, f, t->texels_per_edge, p_obj, n_obj);
            placed = 1;
            for (size_t v = 0; v < r->f->n_views; v++)
                if (r->views[v].seen[texel])
                    take(&out->samples.at[out->samples.count++], r, v, texel, p_obj + 3 * k, n_obj + 3 * k,
                         origin_world);
            out->first[++out->n_texels] = out->samples.count;
        }
    }
}

sheen_status sheen_lamp_proof_take(sheen_lamp_proof *out, const sheen_refined_state *r,
                                   const sheen_lamp_samples *like, sheen_err *err)
{
    size_t n_seen = 0, n_samples = 0, room = 1, i_seen = 0;
    *out = (sheen_lamp_proof){.samples = {.n_views = r->f->n_views, .radius_m = like->radius_m}};
    memcpy(out->samples.origin_world, like->origin_world, sizeof like->origin_world);
    for (size_t i = 0; i < r->views[0].n_texels; i++) {
        const size_t n = times_seen(r, i);
        n_seen += n > 1;
        n_samples += n > 1 ? n : 0;
    }
    const size_t by_texels = n_seen / MOST_TEXELS, by_samples = n_samples / MOST_SAMPLES;
    const size_t step = 1 + (by_texels > by_samples ? by_texels : by_samples);
    for (size_t i = 0; i < r->views[0].n_texels; i++) {
        const size_t n = times_seen(r, i);
        room += n > 1 && i_seen++ % step == 0 ? n : 0;
    }
    out->first = malloc((n_seen / step + 2) * sizeof *out->first);
    out->samples.at = calloc(room + 1, sizeof *out->samples.at);
    if (!out->first || !out->samples.at) {
        sheen_lamp_proof_release(out);
        return sheen_fail_memory(err, (double)(room * sizeof *out->samples.at), "samples of texels");
    }
    fill(out, r, like->origin_world, step);
    spread(&out->samples, r);
    return SHEEN_OK;
}

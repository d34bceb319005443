// SPDX-License-Identifier: Apache-2.0
// lamp_samples.c - picks residual pixels by strata.
//
// Lit pixels are few and tell most, dark ones many; and a highlight's foot, which noise hides in the single pixel but not in the mean over
// its surroundings, bounds the lobe. Each stratum is thinned evenly, and its samples count for what was left out (inverse of the rate):
// were lit and dark pixels mixed at any other rate, pixels that noise or misplaced paint made bright would outweigh those that it made
// dark, and a wide, faint lamp would explain the difference.
#include "fit/lamp_samples.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"

enum { DARK, BESIDE, LIT, STRATA };
enum { REACH_PX = 2 };

static const float beside_share = 0.125f; // of the threshold, for the mean over (2 REACH_PX + 1)^2 pixels

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

static sheen_lamp_sample *take(sheen_lamp_samples *out, const sheen_residual_pixel *p,
                               const sheen_Rt *Rt_world_obj, const sheen_gloss *gloss)
{
    sheen_lamp_sample *s = &out->at[out->count++];
    *s = (sheen_lamp_sample){.clipped = p->clipped, .x_px = p->x_px, .y_px = p->y_px};
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
    return s;
}

// A residual image by running sums over its pixels' window: luminance and count.
typedef struct sums {
    int x0_px, y0_px;
    size_t width, height; // one more than the window's
    double *at;           // [height][width][2]
} sums;

static sheen_status sums_make(sums *out, const sheen_residual *r, sheen_err *err)
{
    int x0 = INT32_MAX, x1 = 0, y0 = INT32_MAX, y1 = 0;
    for (size_t i = 0; i < r->count; i++) {
        const sheen_residual_pixel *p = &r->pixels[i];
        x0 = p->x_px < x0 ? p->x_px : x0;
        x1 = p->x_px > x1 ? p->x_px : x1;
        y0 = p->y_px < y0 ? p->y_px : y0;
        y1 = p->y_px > y1 ? p->y_px : y1;
    }
    if (!r->count)
        x0 = y0 = 0;
    const size_t width = (size_t)x1 + 2 - (size_t)x0, height = (size_t)y1 + 2 - (size_t)y0;
    *out = (sums){x0, y0, width, height, calloc(2 * width * height, sizeof *out->at)};
    if (!out->at)
        return sheen_fail_memory(err, 16.0 * (double)(width * height), "a residual image");
    for (size_t i = 0; i < r->count; i++) {
        const sheen_residual_pixel *p = &r->pixels[i];
        double *at = out->at + 2 * ((size_t)(p->y_px - y0 + 1) * width + (size_t)(p->x_px - x0 + 1));
        at[0] = (double)sheen_luminance(p->rgb);
        at[1] = 1;
    }
    for (size_t y = 1; y < height; y++)
        for (size_t x = 1; x < width; x++)
            for (size_t k = 0; k < 2; k++) {
                const double *left = out->at + 2 * (y * width + x - 1), *above = left - 2 * (width - 1);
                out->at[2 * (y * width + x) + k] += left[k] + above[k] - above[k - 2];
            }
    return SHEEN_OK;
}

static size_t held(int at, size_t most)
{
    return at < 0 ? 0 : (size_t)at < most ? (size_t)at : most;
}

// Mean luminance of the residual about a pixel.
static double mean_about(const sums *s, int x_px, int y_px)
{
    const size_t left = held(x_px - s->x0_px - REACH_PX, s->width - 1),
                 right = held(x_px - s->x0_px + REACH_PX + 1, s->width - 1),
                 top = held(y_px - s->y0_px - REACH_PX, s->height - 1),
                 bottom = held(y_px - s->y0_px + REACH_PX + 1, s->height - 1);
    const double *corner[4] = {s->at + 2 * (bottom * s->width + right), s->at + 2 * (top * s->width + right),
                               s->at + 2 * (bottom * s->width + left), s->at + 2 * (top * s->width + left)};
    double sum[2];
    for (int k = 0; k < 2; k++)
        sum[k] = corner[0][k] - corner[1][k] - corner[2][k] + corner[3][k];
    return sum[0] / sum[1];
}

// Which stratum each pixel of a view belongs to.
static sheen_status classify(uint8_t *stratum, const sheen_residual *r, float threshold_lin, sheen_err *err)
{
    sums s;
    if (!r->count)
        return SHEEN_OK;
    if (sums_make(&s, r, err))
        return SHEEN_ENOMEM;
    for (size_t i = 0; i < r->count; i++) {
        const sheen_residual_pixel *p = &r->pixels[i];
        stratum[i] = is_lit(p, threshold_lin)                                                    ? LIT
                     : mean_about(&s, p->x_px, p->y_px) > (double)(beside_share * threshold_lin) ? BESIDE
                                                                                                 : DARK;
    }
    free(s.at);
    return SHEEN_OK;
}

// strata: of the pixels of all views, one after the other. step: every step-th pixel of a stratum is taken.
static void pick(sheen_lamp_samples *out, const sheen_residual *residuals, const sheen_photos *photos,
                 const uint8_t *strata, const size_t step[STRATA], const float centre_obj[3],
                 const sheen_gloss *gloss)
{
    size_t i_of[STRATA] = {0};
    for (size_t v = 0; v < photos->count; v++) {
        sheen_Rt Rt_world_obj;
        sheen_Rt_from_rt(&Rt_world_obj, photos->photos[v].rt_world_obj);
        if (!v)
            to_world(out->origin_world, &Rt_world_obj, centre_obj);
        for (size_t i = 0; i < residuals[v].count; i++) {
            const int k = *strata++;
            if (i_of[k]++ % step[k])
                continue;
            sheen_lamp_sample *s = take(out, &residuals[v].pixels[i], &Rt_world_obj, gloss);
            s->view = (uint32_t)v;
            s->lit = k == LIT;
            s->weight = (float)step[k] / (float)step[LIT];
            out->n_lit += s->lit;
        }
    }
}

sheen_status sheen_lamp_samples_take(sheen_lamp_samples *out, const sheen_residual *residuals,
                                     const sheen_photos *photos, const float centre_obj[3], float radius_m,
                                     const sheen_lamp_samples_options *o, sheen_err *err)
{
    *out = (sheen_lamp_samples){.n_views = photos->count, .radius_m = radius_m};
    size_t n[STRATA] = {0}, step[STRATA], total = 0, room = 1, at = 0;
    for (size_t v = 0; v < photos->count; v++)
        total += residuals[v].count;
    uint8_t *strata = malloc(total + 1);
    if (!strata)
        return sheen_fail_memory(err, (double)total, "samples of the residual images");
    sheen_status s = SHEEN_OK;
    for (size_t v = 0; v < photos->count && !s; at += residuals[v++].count)
        s = classify(strata + at, &residuals[v], o->threshold_lin, err);
    for (size_t i = 0; i < total && !s; i++)
        n[strata[i]]++;
    for (int k = 0; k < STRATA; k++) {
        const size_t asked = k == LIT ? o->max_lit : o->max_dark, most = asked ? asked : 1;
        step[k] = n[k] > most ? (n[k] + most - 1) / most : 1;
        room += n[k] / step[k] + 1;
    }
    if (!s && !(out->at = malloc(room * sizeof *out->at)))
        s = sheen_fail_memory(err, (double)(room * sizeof *out->at), "samples of the residual images");
    if (!s)
        pick(out, residuals, photos, strata, step, centre_obj, o->gloss);
    free(strata);
    return s;
}

void sheen_lamp_samples_release(sheen_lamp_samples *s)
{
    free(s->at);
    *s = (sheen_lamp_samples){0};
}

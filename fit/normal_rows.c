// SPDX-License-Identifier: Apache-2.0
// normal_rows.c - takes samples where highlights are or the shading changes, and makes normal equations of two unknowns a texel of them.
#include "fit/normal_rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/image.h"
#include "base/parallel.h"
#include "base/vec.h"
#include "fit/diffuse.h"
#include "render/gbuffer.h"

enum { PIECE = 256, MOST_TEXELS = 150000 };

static const float lit_lin = 0.01f;   // a highlight at least this bright says something of the normal
static const float noise_lin = 0.01f; // of a photograph's sample, resampling included
static const float doubt = 0.05f; // share by which a predicted highlight may be wrong, or a change of shading
static const float least_albedo = 0.001f; // below, a colour says nothing of how light is weighed
static const float off_rad = 0.03f;       // by which a normal may be wrong: what that explains is no outlier
static const float outlier_lin = 0.02f;

typedef struct job {
    const sheen_refined_state *r;
    sheen_normal_samples *out;
    const sheen_texture *normals;
    float step_rad; // of differences
} job;

static size_t gather_views(uint8_t view[SHEEN_REFINED_MAX_VIEWS], const sheen_refined_state *r, size_t texel)
{
    size_t n = 0;
    int lit = r->f->model.irradiance.present;
    for (size_t v = 0; v < r->f->n_views; v++) {
        if (!r->views[v].seen[texel])
            continue;
        view[n++] = (uint8_t)v;
        lit = lit || sheen_luminance(r->lights[v].lights_rgb + 3 * texel) > lit_lin;
    }
    return lit && n > 1 ? n : 0;
}

typedef struct census {
    size_t n_lit, n_samples;
} census;

// Of every step-th lit texel; where out is not NULL, they are written there.
static census list_texels(sheen_normal_samples *out, const sheen_refined_state *r, size_t step)
{
    uint8_t view[SHEEN_REFINED_MAX_VIEWS];
    census c = {0, 0};
    for (size_t t = 0; t < r->views[0].n_texels; t++) {
        const size_t n = gather_views(view, r, t);
        if (!n || c.n_lit++ % step)
            continue;
        if (out)
            out->texels[out->n_texels++] = (sheen_normal_texel){.texel = (uint32_t)t,
                                                                .first = (uint32_t)c.n_samples};
        for (size_t i = 0; i < n && out; i++)
            out->samples[c.n_samples + i] = (sheen_normal_sample){.view = view[i]};
        c.n_samples += n;
    }
    return c;
}

static sheen_status make_room(sheen_normal_samples *out, const sheen_refined_state *r, sheen_err *err)
{
    census c = list_texels(NULL, r, 1);
    const size_t step = 1 + c.n_lit / MOST_TEXELS;
    if (step > 1)
        c = list_texels(NULL, r, step);
    if (c.n_samples > UINT32_MAX || r->views[0].n_texels > UINT32_MAX)
        return sheen_fail(err, SHEEN_EUNSUP, "%zu samples of highlights are too many", c.n_samples);
    out->texels = malloc((c.n_lit / step + 2) * sizeof *out->texels);
    out->samples = malloc((c.n_samples + 1) * sizeof *out->samples);
    if (!out->texels || !out->samples)
        return sheen_fail_memory(err, (double)(c.n_samples * sizeof *out->samples), "samples of highlights");
    list_texels(out, r, step);
    out->texels[out->n_texels].first = (uint32_t)c.n_samples;
    return SHEEN_OK;
}

// Where a texel is, the mesh's normal there, and which normal the model has.
typedef struct place {
    float p_obj[3], m_obj[3], n_obj[3];
    size_t texel;
} place;

static void find_place(place *at, const sheen_refined_state *r, const sheen_texture *normals, size_t texel)
{
    const sheen_hit hit = sheen_texel_hit(r->f->model.texture.texels_per_edge, texel);
    at->texel = texel;
    static const double nowhere[3] = {0, 0, 0};
    sheen_hit_surface(r->mesh, &hit, nowhere, at->p_obj, at->m_obj, NULL);
    memcpy(at->n_obj, at->m_obj, sizeof at->n_obj);
    sheen_normal_map_bend(at->n_obj, normals, &hit);
}

static float highlight(const sheen_refined_state *r, const sheen_normal_sample *s, const place *at,
                       const float n_obj[3])
{
    float v_obj[3], rgb[3];
    for (int k = 0; k < 3; k++)
        v_obj[k] = (float)r->f->gbuffers[s->view].p_camera_obj[k] - at->p_obj[k];
    sheen_normalizef(v_obj);
    sheen_shade_lights(rgb, &r->shading[s->view], at->p_obj, n_obj, v_obj);
    const float *gloss = r->lights[s->view].gloss;
    return (gloss ? gloss[at->texel] : 1) * sheen_luminance(rgb);
}

// E, in the luminance of the texture's colour.
static float shading(const sheen_refined_state *r, const sheen_normal_sample *s, const place *at,
                     const float n_obj[3])
{
    const float *a = r->f->model.texture.rgb + 3 * at->texel, D = sheen_luminance(a);
    float rgb[3];
    if (!r->f->model.irradiance.present)
        return 1;
    sheen_shade_irradiance(rgb, &r->shading[s->view], at->p_obj, n_obj);
    const float lit[3] = {a[0] * rgb[0], a[1] * rgb[1], a[2] * rgb[2]};
    return D > least_albedo ? sheen_luminance(lit) / D : sheen_luminance(rgb);
}

// D E + S beside the model's normal, D the present one.
static float light_beside(const sheen_refined_state *r, const sheen_normal_sample *s, const place *at,
                          const float along[3], float by)
{
    const float D = sheen_luminance(r->f->model.texture.rgb + 3 * at->texel);
    float n[3];
    for (int k = 0; k < 3; k++)
        n[k] = at->n_obj[k] + by * along[k];
    sheen_normalizef(n);
    return highlight(r, s, at, n) + D * (shading(r, s, at, n) - s->E);
}

static float mirrored(const sheen_refined_state *r, const sheen_normal_sample *s, size_t texel)
{
    const sheen_surroundings *e = &r->f->model.surroundings;
    const sheen_view_light *l = &r->lights[s->view];
    const float *above = l->above_world + 3 * texel;
    float rgb[3];
    if (!e->present)
        return 0;
    memcpy(rgb, l->mirrored_rgb + 3 * texel, sizeof rgb);
    if (above[2] > 0) {
        static const float anywhere[3] = {0, 0, 0};
        sheen_surroundings_radiance(rgb, e, anywhere, above);
    }
    return sheen_fresnel(e->f0, l->cosine[texel]) * sheen_luminance(rgb);
}

static void fill_pieces(void *self, size_t begin, size_t end)
{
    const job *j = self;
    for (size_t t = begin * PIECE; t < end * PIECE && t < j->out->n_texels; t++) {
        sheen_normal_texel *texel = &j->out->texels[t];
        place at;
        find_place(&at, j->r, j->normals, texel->texel);
        sheen_axes_aboutf(texel->a, texel->b, at.m_obj);
        for (size_t i = texel->first; i < texel[1].first; i++) {
            sheen_normal_sample *s = &j->out->samples[i];
            const size_t at_view = 3 * (size_t)texel->texel;
            s->S = sheen_luminance(j->r->lights[s->view].lights_rgb + at_view);
            s->E = shading(j->r, s, &at, at.n_obj);
            s->changing = s->S + fabsf(sheen_luminance(j->r->f->model.texture.rgb + at_view) * (s->E - 1));
            s->cosine = j->r->lights[s->view].cosine[texel->texel];
            s->r = sheen_luminance(j->r->views[s->view].rgb + at_view) - s->S -
                   mirrored(j->r, s, texel->texel);
            const float *along[2] = {texel->a, texel->b};
            for (int k = 0; k < 2; k++)
                s->g[k] = (light_beside(j->r, s, &at, along[k], j->step_rad) - s->S) / j->step_rad;
        }
    }
}

sheen_status sheen_normal_samples_take(sheen_normal_samples *out, const sheen_refined_state *r,
                                       sheen_err *err)
{
    *out = (sheen_normal_samples){0};
    const sheen_status s = make_room(out, r, err);
    if (s) {
        sheen_normal_samples_release(out);
        return s;
    }
    job j = {r, out, &r->f->model.normals, 0.1f * (float)r->f->model.sigma_rad};
    sheen_parallel_for((out->n_texels + PIECE - 1) / PIECE, 1, r->o.n_threads, fill_pieces, &j);
    return SHEEN_OK;
}

void sheen_normal_samples_release(sheen_normal_samples *s)
{
    free(s->texels);
    free(s->samples);
    *s = (sheen_normal_samples){0};
}

static int is_out(const sheen_normal_sample *s, int fold_out, int n_folds)
{
    return fold_out != SHEEN_NORMAL_NONE_OUT && s->view % n_folds == fold_out;
}

// Weight of a sample whose residual is r about D.
static double weight_of(const sheen_normal_sample *s, double r)
{
    const double shade = (double)(doubt * s->changing),
                 noise2 = (double)(noise_lin * noise_lin) + shade * shade;
    const double slope2 = (double)(s->g[0] * s->g[0] + s->g[1] * s->g[1]);
    const double usual2 = (double)(outlier_lin * outlier_lin) + noise2 + slope2 * (double)(off_rad * off_rad);
    return (double)s->cosine / (noise2 * (1 + 0.5 * r * r / usual2));
}

// D of the samples that are not left out, robustly. False: fewer than n_least of them.
static int find_diffuse(double *D, const sheen_normal_sample *s, size_t n, size_t n_least, int fold_out,
                        int n_folds)
{
    *D = 0;
    size_t n_in = 0;
    for (int round = 0; round < 4; round++) {
        double sum = 0, total = 0;
        n_in = 0;
        for (size_t i = 0; i < n; i++) {
            if (is_out(&s[i], fold_out, n_folds))
                continue;
            // At first by what is predicted of highlights alone
            const double E = (double)s[i].E, w = weight_of(&s[i], round ? (double)s[i].r - *D * E : 0);
            sum += w * E * (double)s[i].r;
            total += w * E * E;
            n_in++;
        }
        if (n_in < n_least || !(total > 0))
            return 0;
        *D = sum / total;
    }
    return 1;
}

// False: nothing is said.
static int make_row(sheen_normal_row *row, const sheen_normal_texel *texel, const sheen_normal_sample *s,
                    size_t n, int fold_out, int n_folds)
{
    double D, total = 0, mean_g[2] = {0, 0}, mean_r = 0, H[3] = {0, 0, 0}, b[2] = {0, 0};
    if (!find_diffuse(&D, s, n, 2, fold_out, n_folds))
        return 0;
    for (int pass = 0; pass < 2; pass++)
        for (size_t i = 0; i < n; i++) {
            if (is_out(&s[i], fold_out, n_folds))
                continue;
            const double E = (double)s[i].E, w = weight_of(&s[i], (double)s[i].r - D * E);
            const double g[2] = {(double)s[i].g[0], (double)s[i].g[1]}, r = (double)s[i].r;
            if (!pass) {
                total += w * E * E;
                mean_r += w * E * r;
                for (int k = 0; k < 2; k++)
                    mean_g[k] += w * E * g[k];
                continue;
            }
            const double x = g[0] - E * mean_g[0] / total, y = g[1] - E * mean_g[1] / total,
                         z = r - E * mean_r / total;
            H[0] += w * x * x;
            H[1] += w * x * y;
            H[2] += w * y * y;
            b[0] += w * x * z;
            b[1] += w * y * z;
        }
    static const int first[6] = {0, 0, 1, 0, 1, 2}, second[6] = {0, 1, 1, 2, 2, 2};
    for (int k = 0; k < 6; k++) {
        const int i = first[k], m = second[k];
        const double ai = (double)texel->a[i], am = (double)texel->a[m], bi = (double)texel->b[i],
                     bm = (double)texel->b[m];
        row->H[k] = (float)(H[0] * ai * am + H[1] * (ai * bm + bi * am) + H[2] * bi * bm);
    }
    for (int k = 0; k < 3; k++)
        row->b[k] = (float)(b[0] * (double)texel->a[k] + b[1] * (double)texel->b[k]);
    return H[0] + H[2] > 0;
}

typedef struct rows_job {
    sheen_normal_row *rows; // of each texel; without weight where it says nothing
    const sheen_normal_samples *s;
    const sheen_normal_grid *grid;
    int texture_texels_per_edge, fold_out, n_folds;
} rows_job;

static void make_rows(void *self, size_t begin, size_t end)
{
    const rows_job *j = self;
    const sheen_texture lattice = {.texels_per_edge = j->grid->texels_per_edge,
                                   .n_triangles = j->grid->n_triangles};
    for (size_t t = begin; t < end; t++) {
        const sheen_normal_texel *texel = &j->s->texels[t];
        sheen_normal_row *row = &j->rows[t];
        memset(row->weight, 0, sizeof row->weight);
        if (!make_row(row, texel, j->s->samples + texel->first, texel[1].first - texel->first, j->fold_out,
                      j->n_folds))
            continue;
        const sheen_hit hit = sheen_texel_hit(j->texture_texels_per_edge, texel->texel);
        size_t corner[3];
        sheen_texture_cell(corner, row->weight, &lattice, &hit);
        for (int k = 0; k < 3; k++)
            row->node[k] = j->grid->node[corner[k]];
    }
}

size_t sheen_normal_rows_make(sheen_normal_row *rows, const sheen_normal_samples *s,
                              const sheen_normal_grid *grid, int texture_texels_per_edge, int fold_out,
                              int n_folds, int n_threads)
{
    size_t n = 0;
    rows_job j = {rows, s, grid, texture_texels_per_edge, fold_out, n_folds};
    sheen_parallel_for(s->n_texels, PIECE, n_threads, make_rows, &j);
    for (size_t t = 0; t < s->n_texels; t++)
        if (rows[t].weight[0] + rows[t].weight[1] + rows[t].weight[2] > 0)
            rows[n++] = rows[t];
    return n;
}

typedef struct prediction_job {
    const sheen_normal_samples *s;
    const sheen_refined_state *r;
    const sheen_texture *normals;
    size_t step;
    int fold_out, n_folds;
    double *cost; // of each piece
} prediction_job;

static void predict_texel(double *cost, const prediction_job *j, const sheen_normal_texel *texel)
{
    sheen_normal_sample s[SHEEN_REFINED_MAX_VIEWS];
    const size_t n = texel[1].first - texel->first;
    place at;
    double D;
    find_place(&at, j->r, j->normals, texel->texel);
    memcpy(s, j->s->samples + texel->first, n * sizeof *s);
    for (size_t i = 0; i < n; i++) {
        const float S = highlight(j->r, &s[i], &at, at.n_obj);
        s[i].r += s[i].S - S;
        s[i].E = shading(j->r, &s[i], &at, at.n_obj);
        s[i].g[0] = s[i].g[1] = 0;
    }
    if (!find_diffuse(&D, s, n, 2, j->fold_out, j->n_folds))
        return;
    for (size_t i = 0; i < n; i++) {
        if (!is_out(&s[i], j->fold_out, j->n_folds))
            continue;
        const double z = ((double)s[i].r - D * (double)s[i].E) / (double)outlier_lin;
        *cost += (double)s[i].cosine * log1p(0.5 * z * z);
    }
}

static void predict_pieces(void *self, size_t begin, size_t end)
{
    const prediction_job *j = self;
    for (size_t piece = begin; piece < end; piece++)
        for (size_t k = piece * PIECE; k < (piece + 1) * PIECE && k * j->step < j->s->n_texels; k++)
            predict_texel(&j->cost[piece], j, &j->s->texels[k * j->step]);
}

sheen_status sheen_normal_prediction(double *cost, const sheen_normal_samples *s,
                                     const sheen_refined_state *r, const sheen_texture *normals, int fold_out,
                                     int n_folds, sheen_err *err)
{
    enum { MOST = 40000 };
    prediction_job j = {s, r, normals, 1 + s->n_texels / MOST, fold_out, n_folds, NULL};
    const size_t n_pieces = 1 + s->n_texels / j.step / PIECE;
    j.cost = calloc(n_pieces, sizeof *j.cost);
    if (!j.cost)
        return sheen_fail_memory(err, 8.0 * (double)n_pieces, "predictions");
    sheen_parallel_for(n_pieces, 1, r->o.n_threads, predict_pieces, &j);
    *cost = 0;
    for (size_t i = 0; i < n_pieces; i++)
        *cost += j.cost[i];
    free(j.cost);
    return SHEEN_OK;
}

// SPDX-License-Identifier: Apache-2.0
// turning.c - gathers the texels of all views with their normals as they were turned, and applies irradiance_fit.h.
#include "fit/turning.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/vec.h"
#include "fit/irradiance_fit.h"

enum { MAX_VIEWS = 64, FITTED_TEXELS = 12000, ROUNDS = 10 };

static const float together_cos = 0.985f;                  // 10 degrees: the lights of one lamp
static const double noise_lin = 0.01, lights_doubt = 0.15; // as fit/diffuse.c has them
static const float least_share = 0.01f;                    // of all light, that a lamp must give

// One of the model's lights, node or lamp.
typedef struct source {
    float l_world[3], per_m, weight;
    bool taken;
} source;

static source source_at(const sheen_model *m, size_t i)
{
    if (i < m->lights.count)
        return (source){.l_world = {m->lights.dx[i], m->lights.dy[i], m->lights.dz[i]},
                        .weight = (float)m->k_s * m->lights.weight[i]};
    const sheen_lamp *lamp = &m->lamps[i - m->lights.count];
    source l = {.per_m = lamp->inverse_distance_per_m, .weight = sheen_luminance(lamp->rgb)};
    memcpy(l.l_world, lamp->direction_world, sizeof l.l_world);
    return l;
}

// Takes the brightest light and all about it, until little is left.
void sheen_turning_lamps(sheen_irradiance *e, const sheen_model *m)
{
    const size_t count = m->lights.count + m->n_lamps;
    source *lights = calloc(count + 1, sizeof *lights);
    float total = 0;
    e->n_lamps = 0;
    for (size_t i = 0; i < count && lights; i++) {
        lights[i] = source_at(m, i);
        total += lights[i].weight;
    }
    while (lights && e->n_lamps < SHEEN_IRRADIANCE_MAX_LAMPS) {
        const source *brightest = NULL;
        source sum = {.weight = 0};
        for (size_t i = 0; i < count; i++)
            if (!lights[i].taken && (!brightest || lights[i].weight > brightest->weight))
                brightest = &lights[i];
        if (!brightest)
            break;
        const source first = *brightest;
        for (size_t i = 0; i < count; i++) {
            source *l = &lights[i];
            if (l->taken || sheen_dotf(first.l_world, l->l_world) < together_cos)
                continue;
            l->taken = true;
            sum.weight += l->weight;
            sum.per_m += l->weight * l->per_m;
            for (int k = 0; k < 3; k++)
                sum.l_world[k] += l->weight * l->l_world[k];
        }
        if (sum.weight < least_share * total || !(sheen_normalizef(sum.l_world) > 0))
            continue;
        sheen_irradiance_lamp *lamp = &e->lamps[e->n_lamps++];
        *lamp = (sheen_irradiance_lamp){.inverse_distance_per_m = sum.per_m / sum.weight};
        memcpy(lamp->l_world, sum.l_world, sizeof lamp->l_world);
    }
    free(lights);
}

// What a view shows of a texel, less all that is not diffuse.
static void observe(sheen_lit_sample *s, const sheen_refined_state *r, size_t v, size_t texel,
                    const float p_obj[3], const float n_obj[3])
{
    const sheen_shading *sh = &r->shading[v];
    const sheen_surroundings *e = &r->f->model.surroundings;
    const sheen_view_light *l = &r->lights[v];
    const sheen_irradiance *light = &r->f->model.irradiance;
    const float *above = l->above_world + 3 * texel;
    float mirrored[3];
    memcpy(mirrored, l->mirrored_rgb + 3 * texel, sizeof mirrored);
    if (e->present && above[2] > 0)
        sheen_surroundings_radiance(mirrored, e, p_obj, above);
    const float F = e->present ? (l->gloss ? l->gloss[texel] : 1) * sheen_fresnel(e->f0, l->cosine[texel])
                               : 0;
    for (size_t c = 0; c < 3; c++)
        s->rgb[c] = r->views[v].rgb[3 * texel + c] - l->lights_rgb[3 * texel + c] - F * mirrored[c];
    for (int i = 0; i < 3; i++) {
        s->n_world[i] = sheen_dotf(sh->R_world_obj[i], n_obj);
        s->x_m[i] = sheen_dotf(sh->R_world_obj[i], p_obj) + sh->t_world_obj[i] -
                    (float)r->f->model.lamp_origin_world[i];
    }
    const double doubt = lights_doubt * (double)sheen_luminance(l->lights_rgb + 3 * texel);
    s->weight = (float)((double)l->cosine[texel] / (1 + doubt * doubt / (noise_lin * noise_lin)));
    s->view = (int)v;
    s->lit = 0;
    for (int j = 0; j < light->n_lamps; j++) {
        float l_world[3];
        if (sheen_irradiance_lamp_cosine(l_world, &light->lamps[j], s->x_m, s->n_world) > 0 &&
            !sheen_shade_hidden(sh, p_obj, s->n_world, l_world))
            s->lit |= (uint32_t)1 << j;
    }
}

static size_t observe_texel(sheen_lit_sample out[MAX_VIEWS], const sheen_refined_state *r, size_t texel,
                            const float p_obj[3], const float n_obj[3])
{
    size_t n = 0;
    for (size_t v = 0; v < r->f->n_views && n < MAX_VIEWS; v++)
        if (r->views[v].seen[texel])
            observe(&out[n++], r, v, texel, p_obj, n_obj);
    return n;
}

typedef struct lattice {
    float p_obj[3 * SHEEN_TEXTURE_MAX_EDGE * (SHEEN_TEXTURE_MAX_EDGE + 1) / 2];
    float n_obj[3 * SHEEN_TEXTURE_MAX_EDGE * (SHEEN_TEXTURE_MAX_EDGE + 1) / 2];
} lattice;

// Samples of every k-th texel.
static sheen_status gather(sheen_lit_texels *out, const sheen_refined_state *r, sheen_err *err)
{
    const int edge = r->f->model.texture.texels_per_edge;
    const size_t per_triangle = sheen_texels_per_triangle(edge), n_all = r->mesh->n_triangles * per_triangle;
    const size_t step = 1 + n_all / (2 * FITTED_TEXELS), most = n_all / step + 1;
    lattice at;
    *out = (sheen_lit_texels){.samples = malloc(most * r->f->n_views * sizeof *out->samples),
                              .first = calloc(most + 1, sizeof *out->first)};
    if (!out->samples || !out->first) {
        sheen_lit_texels_release(out);
        return sheen_fail_memory(err, (double)(most * r->f->n_views * sizeof *out->samples),
                                 "texels under light");
    }
    for (size_t texel = 0; texel < n_all && out->n_texels < most; texel += step) {
        const size_t k = texel % per_triangle, start = out->first[out->n_texels];
        sheen_normal_map_lattice(r->mesh, &r->f->model.normals, texel / per_triangle, edge, at.p_obj,
                                 at.n_obj);
        sheen_lit_sample found[MAX_VIEWS];
        const size_t n = observe_texel(found, r, texel, at.p_obj + 3 * k, at.n_obj + 3 * k);
        if (n < 2)
            continue;
        memcpy(out->samples + start, found, n * sizeof *found);
        out->first[++out->n_texels] = start + n;
    }
    return SHEEN_OK;
}

typedef struct job {
    sheen_refined_state *r;
    float sign;
} job;

static void fit_triangles(void *self, size_t begin, size_t end)
{
    const job *j = self;
    sheen_texture *texture = &j->r->f->model.texture;
    const int edge = texture->texels_per_edge;
    const size_t per_triangle = sheen_texels_per_triangle(edge);
    lattice at;
    for (size_t f = begin; f < end; f++) {
        sheen_normal_map_lattice(j->r->mesh, &j->r->f->model.normals, f, edge, at.p_obj, at.n_obj);
        for (size_t k = 0; k < per_triangle; k++) {
            const size_t texel = f * per_triangle + k;
            sheen_lit_sample samples[MAX_VIEWS];
            double albedo[3];
            const size_t n = observe_texel(samples, j->r, texel, at.p_obj + 3 * k, at.n_obj + 3 * k);
            if (!n)
                continue;
            sheen_lit_albedo(albedo, &j->r->f->model.irradiance, samples, n);
            for (size_t c = 0; c < 3; c++)
                texture->rgb[3 * texel + c] = (float)albedo[c];
        }
    }
}

sheen_status sheen_turning_diffuse(sheen_refined_state *r, sheen_err *err)
{
    sheen_irradiance *e = &r->f->model.irradiance;
    sheen_lit_texels texels;
    const bool before = e->n_lamps > 0;
    sheen_turning_lamps(e, &r->f->model);
    e->present = 0; // with other lamps, from the start
    if (!e->n_lamps)
        e->degree = 2;
    sheen_status s = gather(&texels, r, err);
    if (s)
        return s;
    if (e->n_lamps && !before)
        s = sheen_irradiance_choose_degree(&e->degree, e, &texels, err);
    if (!s)
        s = sheen_irradiance_fit(e, &texels, SHEEN_NO_FOLD, ROUNDS, err);
    sheen_lit_texels_release(&texels);
    if (s)
        return s;
    job j = {.r = r};
    sheen_parallel_for(r->mesh->n_triangles, 64, r->o.n_threads, fit_triangles, &j);
    return SHEEN_OK;
}

static void shift_triangles(void *self, size_t begin, size_t end)
{
    const job *j = self;
    const sheen_texture *texture = &j->r->f->model.texture;
    const int edge = texture->texels_per_edge;
    const size_t per_triangle = sheen_texels_per_triangle(edge);
    lattice at;
    for (size_t f = begin; f < end; f++) {
        sheen_normal_map_lattice(j->r->mesh, &j->r->f->model.normals, f, edge, at.p_obj, at.n_obj);
        for (size_t i = 0; i < per_triangle * j->r->f->n_views; i++) {
            const size_t v = i / per_triangle, k = i % per_triangle, texel = f * per_triangle + k;
            float light[3];
            if (!j->r->views[v].seen[texel])
                continue;
            sheen_shade_irradiance(light, &j->r->shading[v], at.p_obj + 3 * k, at.n_obj + 3 * k);
            for (size_t c = 0; c < 3; c++)
                j->r->lights[v].lights_rgb[3 * texel + c] += j->sign * texture->rgb[3 * texel + c] *
                                                             (light[c] - 1);
        }
    }
}

void sheen_turning_shift(sheen_refined_state *r, float sign)
{
    job j = {r, sign};
    sheen_parallel_for(r->mesh->n_triangles, 64, r->o.n_threads, shift_triangles, &j);
}

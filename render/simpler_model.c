// SPDX-License-Identifier: Apache-2.0
// simpler_model.c - each texel of the simpler mesh looks for the original surface along its normal, from outside.
//
// Texels on an edge have the same place and normal for both of its triangles, and so find the same: no seam opens.
#include "render/simpler_model.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"
#include "render/simplify.h"

enum { LEAST_NORMALS = 3, MAX_TEXELS = SHEEN_TEXTURE_MAX_EDGE * (SHEEN_TEXTURE_MAX_EDGE + 1) / 2 };

typedef struct transfer {
    const sheen_model *from;
    sheen_model *to;
    sheen_scene *scene; // of `from`
    float reach_m;
} transfer;

void sheen_simpler_model_release(sheen_model *simpler)
{
    sheen_mesh_release(&simpler->mesh);
    sheen_texture_release(&simpler->texture);
    sheen_texture_release(&simpler->normals);
}

// As many texels an edge as keep their size on average, and more: triangles are of unlike size now, and what was linear between texels
// is not where the new ones are.
static int texels_of(const sheen_texture *t, size_t n_triangles)
{
    static const double finer = 1.6;
    const double edge =
        finer * (t->texels_per_edge - 1) * sqrt((double)t->n_triangles / (double)n_triangles) + 1;
    return (int)fmin(SHEEN_TEXTURE_MAX_EDGE, fmax(SHEEN_TEXTURE_MIN_EDGE, round(edge)));
}

// The original surface at a triangle's texels.
static void look(sheen_hit *hits, float *n_obj, const transfer *t, size_t triangle, int texels_per_edge)
{
    const size_t n = sheen_texels_per_triangle(texels_per_edge);
    float p[3 * MAX_TEXELS], inwards[3 * MAX_TEXELS];
    sheen_texture_lattice(&t->to->mesh, triangle, texels_per_edge, p, n_obj);
    for (size_t i = 0; i < 3 * n; i++) {
        p[i] += t->reach_m * n_obj[i];
        inwards[i] = -n_obj[i];
    }
    sheen_scene_first_hits(t->scene, hits, p, 0, inwards, n);
    for (size_t i = 0; i < n; i++)
        if (hits[i].triangle != SHEEN_NO_HIT && hits[i].t_m > 2 * t->reach_m)
            hits[i].triangle = SHEEN_NO_HIT;
}

static void transfer_colours(transfer *t, size_t triangle)
{
    sheen_texture *to = &t->to->texture;
    const sheen_texture *from = &t->from->texture;
    const size_t n = sheen_texels_per_triangle(to->texels_per_edge), first = triangle * n;
    sheen_hit hits[MAX_TEXELS];
    float n_obj[3 * MAX_TEXELS], weight[3];
    look(hits, n_obj, t, triangle, to->texels_per_edge);
    for (size_t i = 0; i < n; i++) {
        size_t texel[3], nearest = 0;
        if (hits[i].triangle == SHEEN_NO_HIT)
            continue;
        const float seen = sheen_texture_sample(from, &hits[i], to->rgb + 3 * (first + i));
        sheen_texture_cell(texel, weight, from, &hits[i]);
        for (size_t k = 1; k < 3; k++)
            nearest = weight[k] > weight[nearest] ? k : nearest;
        to->n_views[first + i] = seen > 0.5f && from->n_views[texel[nearest]] ? from->n_views[texel[nearest]]
                                 : seen > 0.5f                                ? 1
                                                                              : 0;
    }
}

static void transfer_normals(transfer *t, size_t triangle)
{
    static const double nowhere[3] = {0, 0, 0};
    sheen_texture *to = &t->to->normals;
    const size_t n = sheen_texels_per_triangle(to->texels_per_edge), first = triangle * n;
    sheen_hit hits[MAX_TEXELS];
    float m[3 * MAX_TEXELS];
    look(hits, m, t, triangle, to->texels_per_edge);
    for (size_t i = 0; i < n; i++) {
        float *d = to->rgb + 3 * (first + i), p[3], bent[3], v[3];
        if (hits[i].triangle == SHEEN_NO_HIT)
            continue;
        sheen_normal_map_surface(&t->from->mesh, &t->from->normals, &hits[i], nowhere, p, bent, v);
        // m + d along the bent normal, d square to m
        const float along = fmaxf(sheen_dotf(bent, m + 3 * i), 0.70710678f);
        for (int k = 0; k < 3; k++)
            d[k] = bent[k] / along - m[3 * i + (size_t)k];
        const float rest = sheen_dotf(d, m + 3 * i);
        for (int k = 0; k < 3; k++)
            d[k] -= rest * m[3 * i + (size_t)k];
    }
}

sheen_status sheen_simpler_model_make(sheen_model *out, const sheen_model *m, size_t max_triangles,
                                      double *moved_m, sheen_err *err)
{
    transfer t = {.from = m, .to = out};
    float centre[3], radius_m;
    *out = *m;
    out->texture = out->normals = (sheen_texture){0};
    sheen_status s = sheen_mesh_simplify(&out->mesh, &m->mesh, max_triangles, moved_m, err);
    if (s)
        return s;
    const size_t n = out->mesh.n_triangles;
    sheen_mesh_sphere(&m->mesh, centre, &radius_m);
    t.reach_m = fmaxf(4 * (float)*moved_m, 5e-3f * radius_m);
    s = sheen_scene_new(&t.scene, &m->mesh, err);
    if (!s)
        s = sheen_texture_init(&out->texture, n, texels_of(&m->texture, n), err);
    const int normals_edge = m->normals.n_triangles ? texels_of(&m->normals, n) : LEAST_NORMALS;
    if (!s)
        s = sheen_normal_map_init(&out->normals, n,
                                  normals_edge > LEAST_NORMALS ? normals_edge : LEAST_NORMALS, err);
    for (size_t f = 0; !s && f < n; f++) {
        transfer_colours(&t, f);
        transfer_normals(&t, f);
    }
    sheen_scene_free(&t.scene);
    if (s)
        sheen_simpler_model_release(out);
    return s;
}

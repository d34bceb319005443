// SPDX-License-Identifier: Apache-2.0
// normals.c - Gauss-Newton steps for offsets of the normals under a membrane, whose stiffness is chosen by views left out.
#include "fit/normals.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "fit/normal_rows.h"

enum {
    FOLDS = 3,
    STIFFNESSES = 4,
    STEPS = 2,
    MAX_TEXELS = SHEEN_TEXTURE_MAX_EDGE * (SHEEN_TEXTURE_MAX_EDGE + 1) / 2
};

// By how much the normal may differ between neighbouring nodes (standard deviation), the stiffest first.
static const double change_rad[STIFFNESSES] = {0.0005, 0.003, 0.015, 0.07};
static const double reach_nodes = 40;
// Thousands of numbers take up some of whatever else is wrong: a map has to predict clearly better. (A lamp too many under
// a sharp lobe makes 3 % of gain and a worse picture; normals that are wrong make 6 % and more.)
static const double worth_keeping = 0.95;
static const float most_offset = 0.7f; // of a normal

typedef struct solver {
    sheen_refined_state *r;
    sheen_normal_grid grid;
    sheen_normal_samples samples;
    sheen_normal_row *rows;
    float *d;          // [n_nodes][3]
    sheen_texture map; // d as a map
} solver;

static sheen_normal_prior prior_of(double change)
{
    return (sheen_normal_prior){1 / (change * change), reach_nodes};
}

// The map's texels take their nodes' offsets, square to the mesh's normal and not too large.
static void map_from_nodes(sheen_texture *map, const solver *s)
{
    const sheen_mesh *mesh = s->r->mesh;
    const int T = map->texels_per_edge;
    const size_t per_triangle = sheen_texels_per_triangle(T);
    float p[3 * MAX_TEXELS], m[3 * MAX_TEXELS];
    for (size_t f = 0; f < map->n_triangles; f++) {
        sheen_texture_lattice(mesh, f, T, p, m);
        for (size_t k = 0; k < per_triangle; k++) {
            const size_t texel = f * per_triangle + k;
            float *to = map->rgb + 3 * texel;
            memcpy(to, s->d + 3 * (size_t)s->grid.node[texel], 3 * sizeof *to);
            const float along = sheen_dotf(to, m + 3 * k);
            for (size_t c = 0; c < 3; c++)
                to[c] -= along * m[3 * k + c];
            const float length = sqrtf(sheen_dotf(to, to));
            for (size_t c = 0; c < 3 && length > most_offset; c++)
                to[c] *= most_offset / length;
        }
    }
}

static void nodes_from_map(solver *s, const sheen_texture *map)
{
    memset(s->d, 0, 3 * s->grid.n_nodes * sizeof *s->d);
    const size_t n = map->n_triangles * sheen_texels_per_triangle(s->grid.texels_per_edge);
    for (size_t i = 0; i < n; i++)
        memcpy(s->d + 3 * (size_t)s->grid.node[i], map->rgb + 3 * i, 3 * sizeof *s->d);
}

static sheen_status solve(solver *s, double change, int fold_out, sheen_err *err)
{
    const sheen_normal_prior prior = prior_of(change);
    nodes_from_map(s, &s->r->f->model.normals);
    const size_t n_rows = sheen_normal_rows_make(s->rows, &s->samples, &s->grid,
                                                 s->r->f->model.texture.texels_per_edge, fold_out, FOLDS);
    const sheen_status status = sheen_normal_grid_solve(s->d, &s->grid, s->rows, n_rows, &prior, err);
    if (!status)
        map_from_nodes(&s->map, s);
    return status;
}

static sheen_status predict(double *cost, solver *s, double change, sheen_err *err)
{
    double sum = 0, total = 0;
    sheen_status status = SHEEN_OK;
    for (int fold = 0; fold < FOLDS && !status; fold++) {
        if (change > 0)
            status = solve(s, change, fold, err);
        if (!status)
            status = sheen_normal_prediction(&sum, &total, &s->samples, s->r, change > 0 ? &s->map : NULL,
                                             fold, FOLDS, err);
    }
    *cost = total > 0 ? sum / total : 0;
    return status;
}

// r->normal_change: the best of those that predict better than none; 0: none does.
static sheen_status choose(solver *s, sheen_err *err)
{
    double best;
    sheen_status status = predict(&best, s, 0, err);
    best *= worth_keeping;
    s->r->normal_change_rad = 0;
    for (int k = 0; k < STIFFNESSES && !status; k++) {
        double cost;
        if ((status = sheen_progress_step(&s->r->o.progress, "normals", k, STIFFNESSES, err)) ||
            (status = predict(&cost, s, change_rad[k], err)))
            break;
        if (!(cost < best)) {
            if (s->r->normal_change_rad > 0)
                break; // past the best
            continue;
        }
        best = cost;
        s->r->normal_change_rad = change_rad[k];
    }
    return status;
}

static sheen_status open_solver(solver *s, sheen_refined_state *r, sheen_err *err)
{
    sheen_model *m = &r->f->model;
    *s = (solver){.r = r};
    const int T = (m->texture.texels_per_edge + 2) / 2; // some two texels of the texture apart
    sheen_status status = sheen_normal_grid_init(&s->grid, r->mesh, T, err);
    if (!status)
        status = sheen_normal_map_init(&s->map, r->mesh->n_triangles, T, err);
    if (!status && !m->normals.n_triangles)
        status = sheen_normal_map_init(&m->normals, r->mesh->n_triangles, T, err);
    if (status)
        return status;
    s->d = malloc(3 * s->grid.n_nodes * sizeof *s->d);
    return s->d ? SHEEN_OK : sheen_fail_memory(err, 12.0 * (double)s->grid.n_nodes, "a normal map");
}

static sheen_status take_samples(solver *s, sheen_err *err)
{
    sheen_normal_samples_release(&s->samples);
    free(s->rows);
    s->rows = NULL;
    const sheen_status status = sheen_normal_samples_take(&s->samples, s->r, err);
    if (status)
        return status;
    s->rows = malloc((s->samples.n_texels + 1) * sizeof *s->rows);
    return s->rows ? SHEEN_OK
                   : sheen_fail_memory(err, (double)(s->samples.n_texels * sizeof *s->rows), "a normal map");
}

static sheen_status improve(solver *s, int *changed, sheen_err *err)
{
    sheen_refined_state *r = s->r;
    sheen_status status = take_samples(s, err);
    if (!status && !r->normals_chosen)
        status = choose(s, err);
    r->normals_chosen = 1;
    for (int step = 0; step < STEPS && !status && r->normal_change_rad > 0; step++) {
        if (step && ((status = sheen_refined_light_views(r, err)) || (status = take_samples(s, err))))
            break;
        if ((status = solve(s, r->normal_change_rad, SHEEN_NORMAL_NONE_OUT, err)))
            break;
        const sheen_texture before = r->f->model.normals;
        r->f->model.normals = s->map;
        s->map = before;
        *changed = 1;
    }
    return status;
}

sheen_status sheen_refined_normals(sheen_refined_state *r, int *changed, sheen_err *err)
{
    solver s = {0};
    *changed = 0;
    if (r->normals_chosen && !(r->normal_change_rad > 0))
        return SHEEN_OK;
    sheen_status status = open_solver(&s, r, err);
    if (!status)
        status = improve(&s, changed, err);
    if (!(r->normal_change_rad > 0))
        sheen_texture_release(&r->f->model.normals);
    sheen_normal_grid_release(&s.grid);
    sheen_normal_samples_release(&s.samples);
    sheen_texture_release(&s.map);
    free(s.rows);
    free(s.d);
    return status;
}

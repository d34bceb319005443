// SPDX-License-Identifier: Apache-2.0
// normals.c - Gauss-Newton steps for offsets of the normals under a membrane, whose stiffness is chosen by views left out.
#include "fit/normals.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
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
static const double worth_trying = 0.98; // the same of the first views left out
static const float most_offset = 0.7f;   // of a normal

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
static void fill_map(void *self, size_t begin, size_t end)
{
    solver *s = self;
    const int T = s->map.texels_per_edge;
    const size_t per_triangle = sheen_texels_per_triangle(T);
    float p[3 * MAX_TEXELS], m[3 * MAX_TEXELS];
    for (size_t f = begin; f < end; f++) {
        sheen_texture_lattice(s->r->mesh, f, T, p, m);
        for (size_t k = 0; k < per_triangle; k++) {
            const size_t texel = f * per_triangle + k;
            float *to = s->map.rgb + 3 * texel;
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
                                                 s->r->f->model.texture.texels_per_edge, fold_out, FOLDS,
                                                 s->r->o.n_threads);
    const sheen_status status = sheen_normal_grid_solve(s->d, &s->grid, s->rows, n_rows, &prior,
                                                        s->r->o.n_threads, err);
    if (!status)
        sheen_parallel_for(s->map.n_triangles, 512, s->r->o.n_threads, fill_map, s);
    return status;
}

// What the views of one fold are wrong by, predicted by the others with normals that change so freely; 0: the mesh's.
static sheen_status predict(double *cost, solver *s, double change, int fold, sheen_err *err)
{
    const sheen_status status = change > 0 ? solve(s, change, fold, err) : SHEEN_OK;
    return status ? status
                  : sheen_normal_prediction(cost, &s->samples, s->r, change > 0 ? &s->map : NULL, fold, FOLDS,
                                            err);
}

// The one that predicts the first fold best; 0: none is worth trying on the others. *cost: of that fold.
static sheen_status choose_by_first(double *change, double *cost, solver *s, double without, sheen_err *err)
{
    *cost = worth_trying * without;
    *change = 0;
    for (int k = 0; k < STIFFNESSES; k++) {
        double with;
        sheen_status status = sheen_progress_step(&s->r->o.progress, "normals", k, STIFFNESSES, err);
        if (status || (status = predict(&with, s, change_rad[k], 0, err)))
            return status;
        if (with < *cost) {
            *cost = with;
            *change = change_rad[k];
        } else if (*change > 0) {
            break; // past the best
        }
    }
    return SHEEN_OK;
}

// r->normal_change_rad: the one that predicts the first fold best, where it predicts all of them clearly better than none; else 0.
static sheen_status choose(solver *s, sheen_err *err)
{
    double without, with, change, fold_without, fold_with;
    sheen_status status = predict(&without, s, 0, 0, err);
    if (status || (status = choose_by_first(&change, &with, s, without, err)))
        return status;
    for (int fold = 1; fold < FOLDS && change > 0; fold++) {
        if ((status = predict(&fold_without, s, 0, fold, err)) ||
            (status = predict(&fold_with, s, change, fold, err)))
            return status;
        without += fold_without;
        with += fold_with;
    }
    s->r->normal_change_rad = with < worth_keeping * without ? change : 0;
    return SHEEN_OK;
}

static sheen_status open_solver(solver *s, sheen_refined_state *r, int T, sheen_err *err)
{
    *s = (solver){.r = r};
    sheen_status status = sheen_normal_grid_init(&s->grid, r->mesh, T, err);
    if (!status)
        status = sheen_normal_map_init(&s->map, r->mesh->n_triangles, T, err);
    if (status)
        return status;
    s->d = malloc((3 * s->grid.n_nodes + 1) * sizeof *s->d);
    return s->d ? SHEEN_OK : sheen_fail_memory(err, 12.0 * (double)s->grid.n_nodes, "a normal map");
}

static void close_solver(solver *s)
{
    sheen_normal_grid_release(&s->grid);
    sheen_normal_samples_release(&s->samples);
    sheen_texture_release(&s->map);
    free(s->rows);
    free(s->d);
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

// On a lattice twice as coarse as the map's: the membrane's energy does not depend on the pitch, the time does.
static sheen_status choose_stiffness(sheen_refined_state *r, int T, sheen_err *err)
{
    solver s;
    sheen_status status = open_solver(&s, r, 1 + T / 2, err);
    if (!status && !(status = take_samples(&s, err)))
        status = choose(&s, err);
    close_solver(&s);
    r->normals_chosen = 1;
    return status;
}

static sheen_status improve(solver *s, int *changed, sheen_err *err)
{
    sheen_refined_state *r = s->r;
    sheen_status status = SHEEN_OK;
    for (int step = 0; step < STEPS; step++) {
        if ((step && (status = sheen_refined_light_views(r, err))) || (status = take_samples(s, err)) ||
            (status = solve(s, r->normal_change_rad, SHEEN_NORMAL_NONE_OUT, err)))
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
    sheen_texture *normals = &r->f->model.normals;
    const int T = (r->f->model.texture.texels_per_edge + 2) / 2; // some two texels of the texture apart
    *changed = 0;
    sheen_status status = r->normals_chosen ? SHEEN_OK : choose_stiffness(r, T, err);
    if (status || !(r->normal_change_rad > 0))
        return status;
    if (!normals->n_triangles)
        status = sheen_normal_map_init(normals, r->mesh->n_triangles, T, err);
    if (!status && !(status = open_solver(&s, r, T, err)))
        status = improve(&s, changed, err);
    close_solver(&s);
    return status;
}

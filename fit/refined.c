// SPDX-License-Identifier: Apache-2.0
// refined.c - alternates between surroundings, texture and lights, each given the others; the same for a camera that moved and
// for an object that turned, with the lights in the one frame in which they stand still.
#include "fit/refined.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "fit/board_picture.h"
#include "fit/diffuse.h"
#include "fit/fill_holes.h"
#include "fit/normals.h"
#include "fit/refined_state.h"
#include "fit/turning.h"

// An extension stays where what it predicts is wrong by this share at most of what is without it.
static const double worth_keeping = 0.99;

static int has(const sheen_refined_state *r, sheen_extension e)
{
    return sheen_extension_in(r->o.without, e);
}

static int turned(const sheen_refined_state *r)
{
    return r->f->model.moving == SHEEN_MOVING_OBJECT;
}

// Kept where photographs are predicted better by the others with them than without.
static void fit_surroundings(sheen_refined_state *r)
{
    sheen_surroundings *e = &r->f->model.surroundings;
    const size_t n = r->f->n_views;
    if (turned(r)) // what the turn itself changes is no mirror image
        sheen_turning_shift(r, 1);
    e->present = 1;
    sheen_surroundings_fit(e, has(r, SHEEN_EXTENSION_AMBIENT), r->views, r->lights, n, r->o.n_threads);
    const double with = sheen_diffuse_cost(e, r->views, r->lights, n, r->o.n_threads);
    e->present = 0;
    const double without = sheen_diffuse_cost(e, r->views, r->lights, n, r->o.n_threads);
    e->present = with < worth_keeping * without;
    if (turned(r))
        sheen_turning_shift(r, -1);
}

// The texture, given the lights and what is mirrored: one colour a texel, or an albedo and the light that it turned under.
static sheen_status fit_diffuse(sheen_refined_state *r, sheen_err *err)
{
    sheen_model *m = &r->f->model;
    if (turned(r))
        return sheen_turning_diffuse(r, err);
    sheen_diffuse_fit(&m->texture, r->f->texel_deviation, &m->surroundings, r->views, r->lights,
                      r->f->n_views, r->o.n_threads);
    return SHEEN_OK;
}

// What is mirrored, before any of it is known.
static sheen_status start_surroundings(sheen_refined_state *r, sheen_err *err)
{
    sheen_surroundings *e = &r->f->model.surroundings;
    sheen_stopwatch watch = sheen_stopwatch_now();
    if (has(r, SHEEN_EXTENSION_BOARD)) {
        const sheen_status s = sheen_board_picture_make(e, r->photos, r->mesh, r->scene, r->o.n_threads, err);
        if (s)
            return s;
    }
    e->present = has(r, SHEEN_EXTENSION_BOARD) || has(r, SHEEN_EXTENSION_AMBIENT);
    e->f0 = 0.04;
    sheen_progress_timed(&r->o.progress, "picture of the board", &watch);
    return SHEEN_OK;
}

static sheen_status estimate_lights(sheen_refined_state *r, sheen_err *err)
{
    return has(r, SHEEN_EXTENSION_LAMPS) ? sheen_refined_lamps(r, err) : sheen_refined_nodes(r, 0.7f, err);
}

// And the texture under the highlights that they move.
static sheen_status bend_normals(sheen_refined_state *r, sheen_err *err)
{
    int changed;
    sheen_status s = sheen_refined_normals(r, &changed, err);
    if (s || !changed)
        return s;
    r->keep_mirrored = 0;
    s = sheen_refined_light_views(r, err);
    return s ? s : fit_diffuse(r, err);
}

// Where the texture and its residuals start. The minimum of an object that turned is its shaded side: there, from an albedo under
// a light that nothing is known of yet.
static sheen_status start_texture(sheen_refined_state *r, sheen_err *err)
{
    sheen_status s = sheen_refined_light_views(r, err); // no lamps yet: what is mirrored
    if (s || !turned(r))
        return s;
    r->keep_mirrored = 0; // the object's own mirror images have its light
    return (s = fit_diffuse(r, err)) ? s : sheen_refined_residuals(r, err);
}

static sheen_status improve_once(sheen_refined_state *r, sheen_stopwatch *watch, sheen_err *err)
{
    sheen_status s;
    // The first residuals are those of the start: of the minimum, which holds what all views mirror
    if ((r->round && (s = sheen_refined_residuals(r, err))) || (s = estimate_lights(r, err)))
        return s;
    sheen_progress_timed(&r->o.progress, "lights and roughness", watch);
    if (r->round == 1 || turned(r)) // by now the object's own mirror images show its texture
        r->keep_mirrored = 0;
    if ((s = sheen_refined_light_views(r, err)))
        return s;
    if (has(r, SHEEN_EXTENSION_BOARD) || has(r, SHEEN_EXTENSION_AMBIENT))
        fit_surroundings(r);
    if ((s = fit_diffuse(r, err)))
        return s;
    sheen_progress_timed(&r->o.progress, "texture and surroundings", watch);
    if (r->round > 0 && has(r, SHEEN_EXTENSION_NORMALS) && (s = bend_normals(r, err)))
        return s;
    sheen_progress_timed(&r->o.progress, "normals", watch);
    return SHEEN_OK;
}

static sheen_status improve(sheen_refined_state *r, sheen_err *err)
{
    sheen_model *m = &r->f->model;
    sheen_status s = start_surroundings(r, err);
    if (s)
        return s;
    if (!turned(r)) {
        r->f->texel_deviation = malloc((r->views[0].n_texels + 1) * sizeof(float));
        if (!r->f->texel_deviation)
            return sheen_fail_memory(err, 4.0 * (double)r->views[0].n_texels, "texels");
    }
    sheen_stopwatch watch = sheen_stopwatch_now();
    m->shadows = has(r, SHEEN_EXTENSION_SHADOWS);
    m->sigma_rad = turned(r) ? 0.05 : 0.03; // until lamps are found
    m->frequency = r->f->geodesic.frequency;
    m->n_hemisphere = r->f->geodesic.n_nodes;
    if ((s = start_texture(r, err)))
        return s;
    for (r->round = 0; r->round < SHEEN_REFINED_ROUNDS; r->round++)
        if ((s = improve_once(r, &watch, err)))
            return s;
    if ((s = sheen_refined_prove(r, err)))
        return s;
    return sheen_fill_holes(&m->texture, r->mesh, err);
}

sheen_status sheen_refined_fit(sheen_paper_fit *f, const sheen_mesh *mesh, sheen_photos *photos,
                               const sheen_paper_options *options, sheen_err *err)
{
    sheen_refined_state r = {.f = f, .mesh = mesh, .photos = photos, .o = *options};
    const sheen_mesh own = f->model.mesh;
    f->model.mesh = *mesh; // lent for the time of the fit
    sheen_status s = sheen_refined_state_init(&r, err);
    if (!s)
        s = improve(&r, err);
    f->model.mesh = own;
    sheen_refined_state_release(&r);
    if (!s)
        snprintf(f->model.method, sizeof f->model.method, "refined");
    return s;
}

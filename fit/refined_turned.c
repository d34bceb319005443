// SPDX-License-Identifier: Apache-2.0
// refined_turned.c - the refined method's rounds for an object that turned: albedo under a light that stood still, and
// highlights from nodes of the hemisphere, refined as the paper does (one camera on a turntable cannot tell a lamp's extent
// from the lobe's width).
#include "fit/diffuse.h"
#include "fit/refined_state.h"
#include "fit/turning.h"

static const double start_sigma_rad = 0.05; // while there are no lights

// The diffuse part and the surroundings, given the lights.
static sheen_status fit_diffuse(sheen_refined_state *r, sheen_err *err)
{
    sheen_model *m = &r->f->model;
    if (r->round > 0) {
        sheen_turning_shift(r, 1);
        sheen_surroundings_fit(&m->surroundings, sheen_extension_in(r->o.without, SHEEN_EXTENSION_AMBIENT),
                               r->views, r->lights, r->f->n_views, r->o.n_threads);
        sheen_turning_shift(r, -1);
        sheen_turning_lamps(&m->irradiance, &m->lights);
        m->irradiance.present = 0; // with other lamps, from the start
    }
    m->irradiance.degree = r->round ? m->irradiance.degree : 2;
    return sheen_turning_diffuse(r, r->round == 1, err);
}

sheen_status sheen_refined_turned(sheen_refined_state *r, int rounds, sheen_stopwatch *watch, sheen_err *err)
{
    sheen_status s;
    r->f->model.sigma_rad = start_sigma_rad;
    for (r->round = 0;; r->round++) { // the first round has no lights
        r->keep_mirrored = 0;
        if ((s = sheen_refined_light_views(r, err)) || (s = fit_diffuse(r, err)))
            return s;
        sheen_progress_timed(&r->o.progress, "texture and surroundings", watch);
        if (r->round == rounds)
            return SHEEN_OK;
        if ((s = sheen_refined_residuals(r, err)) || (s = sheen_refined_nodes(r, 0.7f, err)))
            return s;
        sheen_progress_timed(&r->o.progress, "lights and roughness", watch);
    }
}

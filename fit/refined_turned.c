// SPDX-License-Identifier: Apache-2.0
// refined_turned.c - the refined method's rounds for an object that turned: albedo under a light that stood still, and
// highlights from nodes of the hemisphere, refined as the paper does (one camera on a turntable cannot tell a lamp's extent
// from the lobe's width).
#include "fit/diffuse.h"
#include "fit/refined_state.h"
#include "fit/turning.h"

static const double start_sigma_rad = 0.05; // while there are no lights

static int is_hidden(void *self, size_t i_sample, const float l_world[3])
{
    const sheen_refined_state *r = self;
    const sheen_shading *sh = &r->shading[r->node_samples.view[i_sample]];
    return sheen_shade_hidden(sh, r->node_samples.p_obj + 3 * i_sample,
                              r->node_samples.n_world + 3 * i_sample, l_world);
}

static sheen_status estimate_lights(sheen_refined_state *r, sheen_err *err)
{
    sheen_hemisphere_release(&r->f->combined);
    sheen_status s = sheen_hemisphere_combine(&r->f->combined, r->f->partials, r->f->n_views,
                                              (float)r->f->threshold_lin, 0.7f, err);
    if (s)
        return s;
    if (!r->f->combined.n_assigned)
        return sheen_fail(err, SHEEN_EDATA, "no highlight is left once the surroundings are accounted for");
    // From above again: the first fit stops short on either side. Where there was none, from the hemisphere.
    r->o.sigma0_rad = r->f->model.lights.count ? 2 * r->f->model.sigma_rad : 0;
    s = sheen_paper_lights(r->f, &r->node_samples, &r->o, is_hidden, r, err);
    sheen_samples_release(&r->node_samples);
    return s;
}

// The diffuse part and the surroundings, given the lights.
static sheen_status fit_diffuse(sheen_refined_state *r, sheen_err *err)
{
    sheen_model *m = &r->f->model;
    if (r->round > 0) {
        sheen_turning_shift(r, 1);
        sheen_surroundings_fit(&m->surroundings, r->views, r->lights, r->f->n_views);
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
        if ((s = sheen_refined_residuals(r, err)) || (s = estimate_lights(r, err)))
            return s;
        sheen_progress_timed(&r->o.progress, "lights and roughness", watch);
    }
}

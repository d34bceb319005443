// SPDX-License-Identifier: Apache-2.0
// refined.c - alternates between surroundings, texture and lights, each given the others.
#include "fit/refined.h"

#include <math.h>
#include <stdio.h>

#include "fit/board_picture.h"
#include "fit/diffuse.h"
#include "fit/refined_state.h"
#include "fit/turning.h"

enum { ROUNDS = 3 };

static const double start_sigma_rad = 0.05; // while there are no lights

static int is_hidden(void *self, size_t i_sample, const float l_world[3])
{
    const sheen_refined_state *r = self;
    const sheen_shading *sh = &r->shading[r->samples.view[i_sample]];
    return sheen_shade_hidden(sh, r->samples.p_obj + 3 * i_sample, r->samples.n_world + 3 * i_sample,
                              l_world);
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
    s = sheen_paper_lights(r->f, &r->samples, &r->o, is_hidden, r, err);
    sheen_samples_release(&r->samples);
    return s;
}

// The diffuse part and the surroundings, given the lights.
static sheen_status fit_diffuse(sheen_refined_state *r, sheen_err *err)
{
    sheen_model *m = &r->f->model;
    if (m->moving == SHEEN_MOVING_CAMERA) {
        sheen_surroundings_fit(&m->surroundings, r->views, r->lights, r->f->n_views);
        sheen_diffuse_fit(&m->texture, &m->surroundings, r->views, r->lights, r->f->n_views, r->o.n_threads);
        return SHEEN_OK;
    }
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

static sheen_status improve(sheen_refined_state *r, sheen_err *err)
{
    sheen_model *m = &r->f->model;
    sheen_stopwatch watch = sheen_stopwatch_now();
    sheen_status s = sheen_board_picture_make(&m->surroundings, r->photos, r->mesh, r->scene, r->o.n_threads,
                                              err);
    if (s)
        return s;
    m->surroundings.present = 1;
    m->surroundings.f0 = 0.04;
    m->shadows = 1;
    const int rounds = m->moving == SHEEN_MOVING_OBJECT ? ROUNDS + 1 : ROUNDS; // the first one has no lights
    if (m->moving == SHEEN_MOVING_OBJECT)
        m->sigma_rad = start_sigma_rad;
    sheen_progress_timed(&r->o.progress, "picture of the board", &watch);
    for (r->round = 0; r->round < rounds; r->round++) {
        if ((s = sheen_refined_light_views(r, err)))
            return s;
        if ((s = fit_diffuse(r, err)))
            return s;
        sheen_progress_timed(&r->o.progress, "texture and surroundings", &watch);
        if (r->round == rounds - 1)
            break;
        if ((s = sheen_refined_residuals(r, err)) || (s = estimate_lights(r, err)))
            return s;
        sheen_progress_timed(&r->o.progress, "lights and roughness", &watch);
    }
    return SHEEN_OK;
}

sheen_status sheen_refined_fit(sheen_paper_fit *f, const sheen_mesh *mesh, sheen_photos *photos,
                               const sheen_paper_options *options, sheen_err *err)
{
    sheen_refined_state r = {.f = f, .mesh = mesh, .photos = photos, .o = *options};
    if (f->n_views > SHEEN_REFINED_MAX_VIEWS)
        return sheen_fail(err, SHEEN_EUNSUP,
                          "the refined method takes at most %d photographs, not %zu: use --method paper",
                          SHEEN_REFINED_MAX_VIEWS, f->n_views);
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

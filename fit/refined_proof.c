// SPDX-License-Identifier: Apache-2.0
// refined_proof.c - all that is specular goes where photographs left out are predicted better by the texture alone.
#include "fit/composite_proof.h"
#include "fit/diffuse.h"
#include "fit/refined_state.h"

static sheen_status texture_alone(sheen_refined_state *r, sheen_err *err)
{
    sheen_model *m = &r->f->model;
    sheen_status s = sheen_model_set_lights(m, 0, err);
    if (s || (s = sheen_model_set_lamps(m, NULL, 0, err)))
        return s;
    m->k_s = 0;
    m->surroundings.present = 0;
    m->gloss.n = 0;
    sheen_texture_release(&m->normals); // they were bent by the lights
    r->lamps.n = 0;
    r->keep_mirrored = 0;
    r->f->refined.k_s = 0;
    r->f->refined.n_nodes_left = 0;
    r->f->lights_refuted = true;
    if ((s = sheen_refined_light_views(r, err)))
        return s;
    sheen_diffuse_fit(&m->texture, r->f->texel_deviation, &m->surroundings, r->views, r->lights,
                      r->f->n_views, r->o.n_threads);
    return SHEEN_OK;
}

sheen_status sheen_refined_prove(sheen_refined_state *r, sheen_err *err)
{
    const sheen_model *m = &r->f->model;
    sheen_composite_proof proof;
    if (m->moving == SHEEN_MOVING_OBJECT || (!m->n_lamps && !m->lights.count && !m->surroundings.present))
        return SHEEN_OK;
    const sheen_status s = sheen_composite_prove(&proof, &m->surroundings, r->views, r->lights, r->f->n_views,
                                                 r->o.n_threads, err);
    // Equal: no photograph bears the lights out. Both 0: there was nothing to ask
    return s || proof.with_lights < proof.texture_alone || !(proof.texture_alone > 0) ? s
                                                                                      : texture_alone(r, err);
}

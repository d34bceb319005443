// SPDX-License-Identifier: Apache-2.0
// refined_lamps.c - the step that estimates lamps and their lobe, and makes them the model's.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fit/gloss_fit.h"
#include "fit/refined_state.h"
#include "fit/start_sigma.h"

enum { MAX_LIT = 8000, MAX_DARK = 4000, NARROWER_STARTS = 2 };
static const double well_borne_out = 0.5; // of what photographs left out are wrong by where a lamp shines

static int is_hidden(void *self, const sheen_lamp_sample *s, const float l_world[3])
{
    const sheen_refined_state *r = self;
    return sheen_shade_hidden(&r->shading[s->view], s->p_obj, s->n_world, l_world);
}

// Above the truth: see docs/algorithm.md. Near lamps pass the strict test of section 4.1 nowhere, so a looser one is asked.
static sheen_status start_lobe(sheen_refined_state *r, sheen_err *err)
{
    sheen_paper_fit *f = r->f;
    if (!f->combined.n_assigned) {
        sheen_hemisphere_release(&f->combined);
        const sheen_status s = sheen_hemisphere_combine(&f->combined, f->partials, f->n_views,
                                                        (float)f->threshold_lin, 0.5f, err);
        if (s)
            return s;
    }
    f->sigma0_rad = r->o.sigma0_rad;
    if (!(f->sigma0_rad > 0))
        f->sigma0_rad = f->combined.n_assigned ? sheen_start_sigma(&f->combined, &f->geodesic) : 0.1;
    r->lamps.lobe = (sheen_lobe_shape){.sigma_rad = (float)f->sigma0_rad};
    return SHEEN_OK;
}

static sheen_status use_lamps(sheen_refined_state *r, const sheen_lamp_samples *samples, sheen_err *err)
{
    sheen_model *m = &r->f->model;
    const sheen_lamp_list *list = &r->lamps;
    m->sigma_rad = (double)list->lobe.sigma_rad;
    m->lobe_tail = (double)list->lobe.tail;
    m->lobe_fresnel = (double)list->lobe.fresnel;
    m->k_s = 0;
    double rgb[3] = {0, 0, 0};
    for (size_t i = 0; i < list->n; i++) {
        m->k_s += (double)sheen_luminance(list->lamps[i].rgb);
        for (int c = 0; c < 3; c++)
            rgb[c] += (double)list->lamps[i].rgb[c];
    }
    for (int c = 0; c < 3; c++) {
        m->lamp_origin_world[c] = (double)samples->origin_world[c];
        m->light_rgb[c] = m->k_s > 0 ? rgb[c] / m->k_s : 1;
    }
    r->f->n_samples = samples->count;
    r->f->refined.sigma_rad = m->sigma_rad;
    r->f->refined.k_s = m->k_s;
    r->f->refined.n_nodes_left = list->n;
    r->f->refined.sigma_err = list->scale;
    r->f->refined.converged = list->converged || !list->n;
    r->f->refined.objective = samples->count ? list->cost / (double)samples->count : 0;
    const sheen_refine_turn round = {m->sigma_rad, m->k_s, r->f->refined.objective, list->n};
    const sheen_status s = sheen_refine_note(&r->f->refined, &round, err);
    return s ? s : sheen_model_set_lamps(m, list->lamps, list->n, err);
}

// k_S by region, given the lamps; samples and lamps are brought in step with it.
static sheen_status fit_gloss(sheen_refined_state *r, sheen_lamp_samples *samples, sheen_lamp_proof *proof,
                              const sheen_lamp_fit_options *o, sheen_err *err)
{
    sheen_gloss *gloss = &r->f->model.gloss;
    double strength;
    float *predicted = malloc((samples->count + 1) * sizeof *predicted);
    if (!predicted)
        return sheen_fail_memory(err, 4.0 * (double)samples->count, "samples");
    for (size_t i = 0; i < samples->count; i++)
        samples->at[i].gloss = 1;
    sheen_status s = sheen_lamp_predict(predicted, r->lamps.lamps, r->lamps.n, &r->lamps.lobe, samples, o,
                                        err);
    if (!s)
        s = sheen_gloss_fit(gloss, &strength, samples, predicted, r->lamps.scale,
                            r->f->model.moving == SHEEN_MOVING_OBJECT, err);
    free(predicted);
    if (s)
        return s;
    for (size_t i = 0; i < samples->count; i++)
        samples->at[i].gloss = sheen_gloss_at_root(gloss, samples->at[i].texture_root);
    for (size_t i = 0; i < proof->samples.count; i++)
        proof->samples.at[i].gloss = sheen_gloss_at_root(gloss, proof->samples.at[i].texture_root);
    for (size_t i = 0; i < r->lamps.n; i++)
        for (int c = 0; c < 3; c++)
            r->lamps.lamps[i].rgb[c] *= (float)strength;
    return SHEEN_OK;
}

// The lamps again, with the gloss that was found; it goes where it leaves no less unexplained than lamps `without` it.
static sheen_status fit_with_gloss(sheen_refined_state *r, const sheen_lamp_samples *samples,
                                   const sheen_lamp_list *without, const sheen_lamp_list_options *o,
                                   sheen_err *err)
{
    const sheen_status s = sheen_lamp_list_fit(&r->lamps, samples, o, err);
    if (!s && !(r->lamps.scale < without->scale)) {
        r->lamps = *without;
        r->f->model.gloss.n = 0;
    }
    return s;
}

// Roughness and gloss were those of lamps that are gone: the next round looks for others from the start.
static void forget_lobe(sheen_refined_state *r)
{
    r->lamps.lobe = (sheen_lobe_shape){.sigma_rad = (float)r->f->sigma0_rad};
    r->f->model.gloss.n = 0;
}

// How far the lamp that photographs left out bear out best is borne out; 0 without lamps.
static sheen_status most_explained(double *most, const sheen_lamp_list *list, const sheen_lamp_proof *proof,
                                   const sheen_lamp_fit_options *options, sheen_err *err)
{
    double explained[SHEEN_LAMP_FIT_MAX];
    sheen_lamp_fit_options o = *options;
    o.scale = list->scale;
    const sheen_status s = sheen_lamp_proof_explained(explained, proof, list->lamps, list->n, 0, &list->lobe,
                                                      &o, err);
    *most = 0;
    for (size_t i = 0; i < list->n && !s; i++)
        *most = fmax(*most, explained[i]);
    return s;
}

// One lobe as wide as several lamps together is a lesser minimum, which the first lamp, found alone, may fall into. The first
// residuals still hold what the minimum texture got wrong: there photographs left out tell it, which then bear no lamp out well;
// later, that what is left unexplained would itself count as light.
static sheen_status may_be_too_wide(int *may, const sheen_refined_state *r, const sheen_lamp_list_options *o,
                                    sheen_err *err)
{
    double most = 0;
    sheen_status s = SHEEN_OK;
    if (r->round)
        *may = r->lamps.scale > (double)o->threshold_lin;
    else if (!(s = most_explained(&most, &r->lamps, o->proof, &o->fit, err)))
        *may = most < well_borne_out;
    return s;
}

// The lamps, and where their lobe may be too wide, others that were found under a narrower one, held: those that leave least
// unexplained.
static sheen_status find_lamps(sheen_refined_state *r, const sheen_lamp_samples *samples,
                               const sheen_lamp_list_options *o, sheen_err *err)
{
    int may = 0;
    float start_rad = r->lamps.lobe.sigma_rad;
    sheen_lamp_list_options held = *o;
    held.fit.free_sigma = held.last = 0;
    sheen_status s = sheen_lamp_list_fit(&r->lamps, samples, o, err);
    if (r->round)
        start_rad = r->lamps.lobe.sigma_rad;
    for (int k = 1; k <= NARROWER_STARTS && !s; k++) {
        sheen_lamp_list other = {.lobe = {.sigma_rad = start_rad / (float)(1 << k)}};
        if ((s = may_be_too_wide(&may, r, o, err)) || !may)
            return s;
        if ((s = sheen_lamp_list_fit(&other, samples, &held, err)))
            return s;
        s = sheen_lamp_list_fit(&other, samples, o, err);
        if (!s && other.n && (!r->lamps.n || other.scale < r->lamps.scale))
            r->lamps = other;
    }
    return s;
}

static sheen_lamp_list_options list_options(sheen_refined_state *r, const sheen_lamp_proof *proof)
{
    const sheen_extensions without = r->o.without;
    return (sheen_lamp_list_options){
        .threshold_lin = (float)r->f->threshold_lin,
        .max_lamps = 24,
        .find = 1,
        .last = r->round == SHEEN_REFINED_ROUNDS - 1,
        .proof = proof,
        .fit = {.free_distance = 1,
                .free_radius = 1,
                .free_sigma = 1,
                .free_tail = r->round > 0 && sheen_extension_in(without, SHEEN_EXTENSION_TAIL),
                .free_fresnel = r->round > 0 && sheen_extension_in(without, SHEEN_EXTENSION_FRESNEL),
                .scale = 1,
                .n_threads = r->o.n_threads,
                .hidden = r->f->model.shadows ? is_hidden : NULL,
                .hidden_self = r},
        .progress = r->o.progress};
}

sheen_status sheen_refined_lamps(sheen_refined_state *r, sheen_err *err)
{
    float centre_obj[3], radius_m;
    sheen_lamp_samples samples = {0};
    sheen_lamp_proof proof = {0};
    const sheen_lamp_samples_options so = {(float)r->f->threshold_lin, MAX_LIT, MAX_DARK, &r->f->model.gloss};
    sheen_mesh_sphere(r->mesh, centre_obj, &radius_m);
    sheen_status s = r->round ? SHEEN_OK : start_lobe(r, err);
    if (!s)
        s = sheen_lamp_samples_take(&samples, r->f->residuals, r->photos, centre_obj, radius_m, &so, err);
    if (!s)
        sheen_refined_normal_steps(&samples, r);
    if (!s)
        s = sheen_lamp_proof_take(&proof, r, &samples, err);
    const sheen_lamp_list_options o = list_options(r, &proof);
    sheen_gloss *gloss = &r->f->model.gloss;
    const int gloss_before = gloss->n;
    if (!s)
        s = find_lamps(r, &samples, &o, err);
    const sheen_lamp_list without = r->lamps;
    if (!s && r->lamps.n && sheen_extension_in(r->o.without, SHEEN_EXTENSION_REGIONS))
        s = fit_gloss(r, &samples, &proof, &o.fit, err);
    if (!s && !gloss_before && gloss->n) // the first lamps were found without
        s = fit_with_gloss(r, &samples, &without, &o, err);
    if (!s && !r->lamps.n)
        forget_lobe(r);
    if (!s)
        s = use_lamps(r, &samples, err);
    sheen_lamp_samples_release(&samples);
    sheen_lamp_proof_release(&proof);
    return s;
}

// SPDX-License-Identifier: Apache-2.0
// refined_state.h - what the steps of the refined method share. A step is a function of this state which improves one thing
// given the others; refined.c calls them in their order.
#ifndef SHEEN_FIT_REFINED_STATE_H
#define SHEEN_FIT_REFINED_STATE_H

#include "fit/lamp_list.h"
#include "fit/paper.h"
#include "fit/view_choice.h"
#include "fit/view_light.h"

enum { SHEEN_REFINED_ROUNDS = 3 };

typedef struct sheen_refined_state {
    sheen_paper_fit *f;     // model, gbuffers, residuals, hemispheres: improved in place
    const sheen_mesh *mesh; // lent to f->model for the time of the fit
    sheen_photos
        *photos; // a step may change a pose, and then calls sheen_refined_reload_view; pictures may be lent
    sheen_paper_options o;
    sheen_scene *scene;
    sheen_texel_view *views;  // [n_views] colours of the photographs at the texels
    float *gloss;             // [n_texels] what the model has for them, lent to the lights
    sheen_view_choice choice; // of the photographs that a texel is estimated from
    sheen_view_light *lights; // [n_views] what the model predicts there besides the diffuse part
    sheen_light_cells *cells;
    sheen_lamp_points points;   // of the model's lamps
    sheen_shading *shading;     // [n_views]
    sheen_lamp_list lamps;      // those of the model, with their lobe
    sheen_samples node_samples; // while lights are estimated as nodes
    double normal_change_rad;   // between neighbouring texels of the normal map; 0: there is none
    int normals_chosen;         // 1: that has been decided
    int round;                  // 0, 1, ...
    int keep_mirrored;          // 1: mirror images are good as they are
} sheen_refined_state;

// f, mesh, photos and o are set; the rest is zero. Fills scene and views. ENOMEM.
sheen_status sheen_refined_state_init(sheen_refined_state *r, sheen_err *err);
void sheen_refined_state_release(sheen_refined_state *r);

// To be called when a step has changed a photograph's pose: its gbuffer and texel colours are made anew.
sheen_status sheen_refined_reload_view(sheen_refined_state *r, size_t i_view, sheen_err *err);

// The steps, each given everything else:
// r->lights and r->shading from the model; mirror images only where keep_mirrored is 0, which it then is no more.
sheen_status sheen_refined_light_views(sheen_refined_state *r, sheen_err *err);
// Residuals and partial hemispheres: photographs without what the texture and what is mirrored explain.
sheen_status sheen_refined_residuals(sheen_refined_state *r, sheen_err *err);
// Lamps and their lobe from the residuals.
sheen_status sheen_refined_lamps(sheen_refined_state *r, sheen_err *err);

// n_step of samples that were taken from r's residuals. Those are clear of depth edges: their neighbours lie on the same surface.
void sheen_refined_normal_steps(sheen_lamp_samples *samples, const sheen_refined_state *r);

// What lamps are judged by, from an even choice of the texels that two photographs or more see; origin and size as in the lamps'
// samples. ENOMEM.
sheen_status sheen_lamp_proof_take(sheen_lamp_proof *out, const sheen_refined_state *r,
                                   const sheen_lamp_samples *like, sheen_err *err);

// Nodes of the hemisphere and their lobe instead. consistency: share of the views that must agree on a node. EDATA: no highlight.
sheen_status sheen_refined_nodes(sheen_refined_state *r, float consistency, sheen_err *err);

// The end: lights, surroundings and normals go, and the texture is what it is without them, where photographs left out are predicted
// better so (f->lights_refuted). Not of an object that turned: its lights make its texture, too. ENOMEM.
sheen_status sheen_refined_prove(sheen_refined_state *r, sheen_err *err);

#endif

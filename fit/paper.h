// SPDX-License-Identifier: Apache-2.0
// paper.h - the method of Nishino, Zhang and Ikeuchi (ICCV 2001), sections 3.1 to 4.3, from photographs to model.
#ifndef SHEEN_FIT_PAPER_H
#define SHEEN_FIT_PAPER_H

#include <stdbool.h>

#include "fit/align.h"
#include "fit/extensions.h"
#include "fit/hemisphere.h"
#include "fit/photos.h"
#include "fit/refine.h"
#include "fit/samples.h"
#include "fit/texel_view.h"
#include "render/model.h"

// How far the method goes: a method that begins with it may want a part only.
typedef enum sheen_paper_stop {
    SHEEN_PAPER_ALL,
    SHEEN_PAPER_TEXTURE,    // section 3.2 alone
    SHEEN_PAPER_HEMISPHERE, // and residuals and hemispheres, section 4.1: a matte surface is no error then
} sheen_paper_stop;

typedef struct sheen_paper_options {
    int texels_per_edge;  // of a triangle's patch; 0: as fine as the photographs
    int frequency;        // of the geodesic hemisphere; 0: 60, the paper's 18000 nodes
    double threshold_lin; // residual above which a pixel counts as highlight; 0: 0.04 of white
    double consistency;   // share of the views reaching a node that must see light there; 0: 1, the paper's
    double sigma0_rad;    // where sigma starts; 0: from the hemisphere
    size_t max_samples;   // 0: 30000
    sheen_loss loss;
    bool keep_poses, keep_exposures; // 1: as if they were in `without`
    sheen_extensions without;        // of the refined method
    sheen_paper_stop stop_after;
    bool keep_texels; // for a method that goes on with them: 13 bytes a texel and photograph
    int n_threads;    // 0: one a processor
    sheen_progress progress;
} sheen_paper_options;

// The model and every intermediate result that the paper shows.
typedef struct sheen_paper_fit {
    sheen_model model;         // its mesh is empty: the caller's mesh belongs to it
    sheen_gbuffer *gbuffers;   // [n_views] one sample a pixel
    sheen_residual *residuals; // [n_views]
    sheen_geodesic geodesic;
    sheen_partial_hemisphere *partials; // [n_views]
    sheen_hemisphere combined;
    uint32_t *nodes; // [combined.n_assigned] those with a value
    sheen_refine_result refined;
    size_t n_views, n_samples;
    double threshold_lin, sigma0_rad;
    sheen_texel_view *views; // [n_views] texels of all photographs, where options->keep_texels asked for them
    float *
        texel_deviation; // [n_texels] standard deviation of each texel's luminance, NaN: unknown; NULL: the refined method's only
    bool
        lights_refuted; // lights were found, and photographs left out are predicted better without: the model has none
    sheen_align_result align; // the refined method's; views NULL: nothing was aligned
} sheen_paper_fit;

// Two photographs or more (with one there is nothing to separate). EDATA, with what to do: fewer; a mesh that no photograph
// sees; no highlight. ECANCEL, ENOMEM. The result does not depend on n_threads.
sheen_status sheen_paper_fit_make(sheen_paper_fit *out, const sheen_mesh *mesh, const sheen_photos *photos,
                                  const sheen_paper_options *options, sheen_err *err);
void sheen_paper_fit_release(sheen_paper_fit *f);

// Section 4.3 alone, from f's residuals and combined hemisphere: takes samples (caller releases; they are there while `hidden`
// is asked), refines, and makes the lit nodes the model's lights. hidden: see refine.h; may be NULL.
sheen_status sheen_paper_lights(sheen_paper_fit *f, sheen_samples *samples,
                                const sheen_paper_options *options,
                                int (*hidden)(void *self, size_t i_sample, const float l_world[3]),
                                void *hidden_self, sheen_err *err);

#endif

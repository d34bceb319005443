// SPDX-License-Identifier: Apache-2.0
// certainty.h - how well a fit's numbers are determined, in figures and in sentences, and which photograph would help most.
//
// The model's lights are taken in groups (nodes side by side are one lamp). About the optimum the predicted highlights are
// linear in sigma, in each group's strength and place, and in the clusters' k_S; their Jacobian over the residual pixels and how much the
// equations scatter over the surface (certainty_cells.h) give a covariance. It holds the texture fixed, and it believes the model: systematic
// errors are in it only as far as they differ from place to place.
#ifndef SHEEN_FIT_CERTAINTY_H
#define SHEEN_FIT_CERTAINTY_H

#include "fit/paper.h"

enum { SHEEN_CERTAINTY_SENTENCES = 8, SHEEN_CERTAINTY_SENTENCE_BYTES = 320 };

typedef struct sheen_lamp_certainty {
    double v_world[3];     // weighted mean direction
    double strength;       // k_S times the weights of its lights
    size_t n_lights;       // of the model
    size_t n_views;        // photographs that show its highlight
    double strength_share; // standard deviation of the strength, share of it
    double direction_rad;  // of the direction
} sheen_lamp_certainty;

typedef struct sheen_certainty {
    double sigma_share, k_s_share; // standard deviations, shares of the values; NaN: not determined
    double gloss_share
        [SHEEN_GLOSS_MAX]; // [n_gloss] of the clusters' k_S against the most shining one's, shares of the values
    int n_gloss;
    sheen_lamp_certainty *lamps; // [n_lamps] the brightest first
    size_t n_lamps;
    double unseen_share, once_share; // of the texels: seen by no photograph, by one only
    int advised;                     // a further photograph would help; from where, in world:
    double advice_azimuth_deg, advice_elevation_deg;
    char sentences[SHEEN_CERTAINTY_SENTENCES][SHEEN_CERTAINTY_SENTENCE_BYTES]; // what is not determined
    size_t n_sentences;
} sheen_certainty;

// f: with its residuals. mesh: that was fitted. photos: their poses. ENOMEM.
sheen_status sheen_certainty_find(sheen_certainty *out, const sheen_paper_fit *f, const sheen_mesh *mesh,
                                  const sheen_photos *photos, sheen_moving moving, sheen_err *err);
void sheen_certainty_release(sheen_certainty *c);

#endif

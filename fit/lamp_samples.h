// SPDX-License-Identifier: Apache-2.0
// lamp_samples.h - the residual pixels that lamps are estimated from: lit ones, those beside them, and dark ones which say where no light is.
#ifndef SHEEN_FIT_LAMP_SAMPLES_H
#define SHEEN_FIT_LAMP_SAMPLES_H

#include "fit/residual.h"
#include "render/gloss.h"

typedef struct sheen_lamp_sample {
    float x_m[3]; // the surface point from the lamps' origin, frame world
    float n_world[3], v_world[3], p_obj[3];
    float n_step[2][3]; // by what the normal differs in the next pixel to the right, and below; 0: not known
    float rgb[3], Y;    // residual, linear
    float gloss;        // by which the place shines (gloss.h)
    float texture_root[3]; // square root of its texture's colour
    float weight;          // by how many times a lit sample's pixels it stands for
    uint32_t view;
    int x_px, y_px;  // in it
    uint8_t clipped; // the photograph is at its upper end: the residual is a lower bound
    uint8_t lit;     // Y above the threshold, or clipped
} sheen_lamp_sample;

typedef struct sheen_lamp_samples {
    sheen_lamp_sample *at;
    size_t count, n_lit, n_views;
    float origin_world[3], radius_m; // the object's middle and size
} sheen_lamp_samples;

typedef struct sheen_lamp_samples_options {
    float threshold_lin;
    size_t max_lit, max_dark; // more are thinned evenly; as many again as dark ones beside light
    const sheen_gloss *gloss; // NULL: 1 everywhere
} sheen_lamp_samples_options;

// centre_obj, radius_m: the mesh's sphere; its image in world under the first photograph's pose becomes the origin. ENOMEM.
sheen_status sheen_lamp_samples_take(sheen_lamp_samples *out, const sheen_residual *residuals,
                                     const sheen_photos *photos, const float centre_obj[3], float radius_m,
                                     const sheen_lamp_samples_options *options, sheen_err *err);
void sheen_lamp_samples_release(sheen_lamp_samples *s);

#endif

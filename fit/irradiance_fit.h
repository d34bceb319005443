// SPDX-License-Identifier: Apache-2.0
// irradiance_fit.h - the light on a surface that turns under it, and the surface's albedo, from what views show of texels.
//
// y = a E(n) with E of render/irradiance.h: linear in the albedos given the light, and in the light given the albedos.
// Where no view turned (one light frame) a view says nothing about E, and it stays 1: the paper's model.
#ifndef SHEEN_FIT_IRRADIANCE_FIT_H
#define SHEEN_FIT_IRRADIANCE_FIT_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "render/irradiance.h"

enum { SHEEN_LIT_FOLDS = 3, SHEEN_NO_FOLD = -1 };

// One texel in one view.
typedef struct sheen_lit_sample {
    float rgb[3];     // photograph less all that is not diffuse
    float n_world[3]; // normal as it was turned then
    float x_m[3];     // and the place, from the lamps' origin, in world
    float weight;     // before outliers are weighed
    uint32_t lit;     // bit j: nothing hides lamp j
    int view;
} sheen_lit_sample;

// Samples of texel t: first[t] to first[t + 1].
typedef struct sheen_lit_texels {
    sheen_lit_sample *samples;
    size_t *first; // [n_texels + 1]
    size_t n_texels;
} sheen_lit_texels;

void sheen_lit_texels_release(sheen_lit_texels *t);

// E of a sample.
void sheen_lit_irradiance(double rgb[3], const sheen_irradiance *e, const sheen_lit_sample *s);
// The robust albedo of n samples of one texel under e, 0 where all are black.
void sheen_lit_albedo(double rgb[3], const sheen_irradiance *e, const sheen_lit_sample *samples, size_t n);

// Finds harmonics and the lamps' strengths; e->degree, n_lamps and l_world are given, the rest is where it starts (not
// present: E = 1). Views of one fold (view % SHEEN_LIT_FOLDS == left_out) have no part. Scaled as render/irradiance.h says. ENOMEM.
sheen_status sheen_irradiance_fit(sheen_irradiance *e, const sheen_lit_texels *texels, int left_out,
                                  int n_rounds, sheen_err *err);
// The degree, 0 to 2, with which views that were left out are predicted best; a higher one must be better by 1 %.
sheen_status sheen_irradiance_choose_degree(int *degree, const sheen_irradiance *e,
                                            const sheen_lit_texels *texels, sheen_err *err);

#endif

// SPDX-License-Identifier: Apache-2.0
// lamp_proof.h - does a lamp help to predict photographs that are left out?
//
// A texel has one diffuse colour D in all photographs, which is estimated after the lamps: whatever a lamp adds to all of them alike is
// taken off D again. So the evidence for a lamp is not in residuals from a texture that is held, but in how well each photograph of a
// texel is predicted by the others,
//
//     C = sum_t sum_v log(1 + (d_v - D_-v)^2 / (2 scale^2)),    d_v = Y_v - S_v(lamps),    D_-v a robust mean of the other d
//
// taken where the lamp shines. Neither a bright residue that all views share (the bias of a minimum), nor misplaced paint, which is as
// often too dark as too bright, nor a great number of samples that err together makes a lamp by this measure.
#ifndef SHEEN_FIT_LAMP_PROOF_H
#define SHEEN_FIT_LAMP_PROOF_H

#include "fit/lamp_fit.h"

typedef struct sheen_lamp_proof {
    sheen_lamp_samples
        samples;   // Y: luminance without what is mirrored; weight: of the sample in its texel's mean
    size_t *first; // [n_texels + 1] texel t has the samples first[t] .. first[t + 1], two or more
    size_t n_texels;
} sheen_lamp_proof;

void sheen_lamp_proof_release(sheen_lamp_proof *p);

// explained[n - first]: the share of C that each lamp from `first` on explains, given all others, over the samples that it lights by half of its typical
// light or more: 1 all of it, 0 nothing, below 0 where photographs are predicted better without it. options: scale, hidden and threads. ENOMEM.
sheen_status sheen_lamp_proof_explained(double *explained, const sheen_lamp_proof *proof,
                                        const sheen_lamp *lamps, size_t n, size_t first,
                                        const sheen_lobe_shape *lobe, const sheen_lamp_fit_options *options,
                                        sheen_err *err);

#endif

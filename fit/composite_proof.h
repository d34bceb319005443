// SPDX-License-Identifier: Apache-2.0
// composite_proof.h - do lights and mirror images together predict photographs that are left out, or is the texture alone better?
//
// A texel's photograph v is predicted by its other photographs u, once by their median, and once by
//
//     I_v = median_u (I_u - g_v L_u) + g_v L_v,    L = S + F M, what the model says changes with the view,
//
// g_v in [0, 1] being the share of L that the photographs other than v bear out: the least-squares slope of I on L over pairs of
// them on the same texel. What one photograph alone suggested (a shadow that passed, somebody's reflection) has no share where that
// photograph is predicted.
#ifndef SHEEN_FIT_COMPOSITE_PROOF_H
#define SHEEN_FIT_COMPOSITE_PROOF_H

#include "fit/diffuse.h"

// Mean square of what left-out photographs' luminances are wrong by, up to white; over an even choice of texels.
typedef struct sheen_composite_proof {
    double with_lights, texture_alone; // both 0 where no texel is seen twice
} sheen_composite_proof;

// views, lights: [n_views], of one lattice; at most SHEEN_REFINED_MAX_VIEWS see a texel. ENOMEM.
sheen_status sheen_composite_prove(sheen_composite_proof *out, const sheen_surroundings *surroundings,
                                   const sheen_texel_view *views, const sheen_view_light *lights,
                                   size_t n_views, int n_threads, sheen_err *err);

#endif

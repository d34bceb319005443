// SPDX-License-Identifier: Apache-2.0
// normal_rows.h - what the photographs say of normals, texel by texel, linear about the model's present ones.
//
// Texel t in view v, in luminance: y_v = I_v - F_v M_v = D E_v(n) + S_v(n), D E the texture under the light that it
// turned in (E = 1 where it stood still). With n = n0 + p a + q b (a, b: sheen_axes_aboutf of the mesh's normal)
// r_v = y_v - S_v(n0) = D E_v(n0) + g_v . (p, q), g_v by differences of the renderer's own S and E, those of E times
// the present D. D is eliminated.
#ifndef SHEEN_FIT_NORMAL_ROWS_H
#define SHEEN_FIT_NORMAL_ROWS_H

#include "fit/normal_grid.h"
#include "fit/refined_state.h"

typedef struct sheen_normal_sample {
    float r, S, E, g[2], cosine;
    float changing; // S, and by what the turn has changed D: what a prediction may be wrong in
    uint8_t view;
} sheen_normal_sample;

// A texel on which highlights bear, or under which lights turned.
typedef struct sheen_normal_texel {
    uint32_t texel; // of the model's texture
    uint32_t first; // of its samples; those of the next texel follow
    float a[3], b[3];
} sheen_normal_texel;

typedef struct sheen_normal_samples {
    sheen_normal_texel *texels; // [n_texels + 1]; the last has only `first`
    sheen_normal_sample *samples;
    size_t n_texels;
} sheen_normal_samples;

enum { SHEEN_NORMAL_NONE_OUT = -1 };

// The texels that two views or more see, one of them lit (any where the object turned), evenly thinned to some 150,000; r->lights and r->shading are the model's. ENOMEM.
sheen_status sheen_normal_samples_take(sheen_normal_samples *out, const sheen_refined_state *r,
                                       sheen_err *err);
void sheen_normal_samples_release(sheen_normal_samples *s);

// One row a texel, [s->n_texels], from the views but those whose number leaves fold_out when divided by n_folds. Returns how many.
size_t sheen_normal_rows_make(sheen_normal_row *rows, const sheen_normal_samples *s,
                              const sheen_normal_grid *grid, int texture_texels_per_edge, int fold_out,
                              int n_folds, int n_threads);

// How badly the views of fold_out are predicted, their D from the other views: the sum of log(1 + z^2 / 2), weighted by cosines, over some
// 40,000 texels. normals: in place of the model's, about which s was taken. ENOMEM.
sheen_status sheen_normal_prediction(double *cost, const sheen_normal_samples *s,
                                     const sheen_refined_state *r, const sheen_texture *normals, int fold_out,
                                     int n_folds, sheen_err *err);

#endif

// SPDX-License-Identifier: Apache-2.0
// view_light.h - the view-dependent light that a model predicts for every texel of one photograph.
#ifndef SHEEN_FIT_VIEW_LIGHT_H
#define SHEEN_FIT_VIEW_LIGHT_H

#include "fit/texel_view.h"
#include "render/shade.h"

// Of the texels that the view sees; others are left undefined.
typedef struct sheen_view_light {
    float *lights_rgb; // [n_texels][3] specular part of the lights
    float *
        mirrored_rgb; // [n_texels][3] radiance from the mirror direction where it is the board or the object itself
    float *
        above_world; // [n_texels][3] the mirror direction where it leads up and out, else 0: the room's radiance is
                     //               to be found
    float *cosine; // [n_texels] n.v
    const float *
        gloss; // [n_texels] of the texels' colours, lent; in lights_rgb, not in mirrored_rgb. NULL: 1 everywhere
    size_t n_texels;
} sheen_view_light;

sheen_status sheen_view_light_init(sheen_view_light *l, size_t n_texels, sheen_err *err);
void sheen_view_light_release(sheen_view_light *l);
// with_mirrored 0: mirrored_rgb and above_world, which cost a ray each, stay as they are. seen: the view's texels. The model's texture must have the lattice of `seen`.
void sheen_view_light_fill(sheen_view_light *l, const sheen_shading *shading, const sheen_texel_view *seen,
                           const double p_camera_obj[3], int with_mirrored, int n_threads);

#endif

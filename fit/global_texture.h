// SPDX-License-Identifier: Apache-2.0
// global_texture.h - the view-independent part as the minimum over the views (section 3.2).
#ifndef SHEEN_FIT_GLOBAL_TEXTURE_H
#define SHEEN_FIT_GLOBAL_TEXTURE_H

#include "fit/photos.h"
#include "fit/texel_view.h"
#include "render/texture.h"

typedef struct sheen_global_texture_options {
    int texels_per_edge;
    sheen_texel_view
        *keep; // [photos->count] zeros: receives every photograph's texels; NULL: nobody wants them
    int n_threads;
    const sheen_progress *progress; // may be NULL
} sheen_global_texture_options;

// Texture of the least colour that each texel shows in any view which sees it, the paper's estimate of
// I_D = K_D cos(theta_i) (eq. 2). "Least" is by luminance Y, and the whole colour of that view is kept: a minimum
// taken channel by channel would join the noise of three photographs and lie lower still.
// gbuffers: one per photo, one sample a pixel. EDATA: no view sees any part of the mesh.
sheen_status sheen_global_texture_minimum(sheen_texture *out, const sheen_mesh *mesh,
                                          const sheen_scene *scene, const sheen_photos *photos,
                                          const sheen_gbuffer *gbuffers,
                                          const sheen_global_texture_options *o, sheen_err *err);

#endif

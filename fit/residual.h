// SPDX-License-Identifier: Apache-2.0
// residual.h - residual images: photograph minus global texture, pixel by pixel (section 4.1).
#ifndef SHEEN_FIT_RESIDUAL_H
#define SHEEN_FIT_RESIDUAL_H

#include <stdint.h>

#include "fit/photos.h"
#include "render/gbuffer.h"
#include "render/model.h"

// What one pixel of the object tells: the light that its texture does not explain, and where it was reflected.
typedef struct sheen_residual_pixel {
    float rgb[3];                 // linear, may be negative
    float n_world[3], v_world[3]; // unit normal, unit direction to the camera
    float p_obj[3];
    int x_px, y_px;
    uint8_t clipped;         // the photograph is at its upper end in some channel
    uint8_t texture_root[3]; // 255 times the square root of the texture's colour there
} sheen_residual_pixel;

// The pixels of one view that count: the object is seen clear of depth edges at n.v >= SHEEN_SEEN_MIN_COS, and the
// texture there was seen by at least two photographs. (With one photograph the minimum is that photograph itself: the
// residual is zero whatever the light, and says nothing.)
typedef struct sheen_residual {
    sheen_residual_pixel *pixels; // row by row
    size_t count;
} sheen_residual;

// model: its texture, and its normal map where it has one (else the mesh's normals). The result does not depend on n_threads. ENOMEM.
sheen_status sheen_residual_make(sheen_residual *out, const sheen_mesh *mesh, const sheen_model *model,
                                 const sheen_gbuffer *g, const sheen_camera *cam, const sheen_photo *photo,
                                 int n_threads, sheen_err *err);
void sheen_residual_release(sheen_residual *r);

#endif

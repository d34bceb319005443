// SPDX-License-Identifier: Apache-2.0
// texel_view.h - one photograph texture-mapped onto the mesh: its colour at every texel that it sees (section 3.2).
#ifndef SHEEN_FIT_TEXEL_VIEW_H
#define SHEEN_FIT_TEXEL_VIEW_H

#include <stdint.h>

#include "fit/photos.h"
#include "render/gbuffer.h"
#include "render/scene.h"

// A texel counts as seen by a view when the segment to the camera is free, the surface is not turned away by
// more than acos(SHEEN_SEEN_MIN_COS), and no depth edge, mask edge or image edge lies within a pixel, where
// the photograph mixes two surfaces.
#define SHEEN_SEEN_MIN_COS 0.2f

typedef struct sheen_texel_view {
    float *rgb;    // [n_texels][3], linear; only where seen
    uint8_t *seen; // [n_texels] 1 or 0
    size_t n_texels;
} sheen_texel_view;

sheen_status sheen_texel_view_init(sheen_texel_view *v, size_t n_triangles, int texels_per_edge,
                                   sheen_err *err);
void sheen_texel_view_release(sheen_texel_view *v);

// Fills v from a photograph; g is that view's gbuffer with one sample a pixel. The result does not depend
// on n_threads.
void sheen_texel_view_fill(sheen_texel_view *v, const sheen_mesh *mesh, const sheen_scene *scene,
                           const sheen_gbuffer *g, const sheen_camera *cam, const sheen_photo *photo,
                           int texels_per_edge, int n_threads);

// Texels an edge that make the lattice as fine as the photographs: over half of the area that the mesh covers in them a texel has a
// pixel's area or less; but no more than four texels a pixel of surface. Within the texture's limits.
int sheen_texels_per_edge_for(const sheen_mesh *mesh, const sheen_photos *photos);

#endif

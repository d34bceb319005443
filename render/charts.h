// SPDX-License-Identifier: Apache-2.0
// charts.h - a mesh cut into charts that lie flat in one square picture: the texture coordinates that other programs want.
//
// The global texture (texture.h) has a patch a triangle, which filters and mipmaps of other programs would smear into its
// neighbours in the picture. In a chart neighbours in the picture are neighbours on the surface.
#ifndef SHEEN_RENDER_CHARTS_H
#define SHEEN_RENDER_CHARTS_H

#include <stddef.h>
#include <stdint.h>

#include "base/image.h"
#include "base/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

// Triangles keep their order and their corners'; a vertex on a seam stands once a chart.
typedef struct sheen_charts {
    int side_px;         // of the square picture
    uint32_t *triangles; // [n_triangles][3], each < n_vertices
    uint32_t *vertex;    // [n_vertices] the mesh's vertex
    float *q_px;         // [n_vertices][2] right and down; (0, 0) is the picture's corner
    size_t n_vertices, n_triangles;
} sheen_charts;

// The picture's sides are a power of two up to max_side_px, where a texel of texel_m fits or else a larger one.
// EARG, ENOMEM.
sheen_status sheen_charts_make(sheen_charts *out, const sheen_mesh *mesh, double texel_m, int max_side_px,
                               sheen_err *err);
void sheen_charts_release(sheen_charts *c);

// Which place of the surface a pixel's centre shows.
typedef struct sheen_chart_place {
    uint32_t triangle; // SHEEN_CHART_EMPTY: none
    float b1, b2;
} sheen_chart_place;

#define SHEEN_CHART_EMPTY UINT32_MAX

// places: [side_px][side_px].
void sheen_charts_places(sheen_chart_place *places, const sheen_charts *c);

// Fills the pixels that are not `known` ([height_px][width_px]) with the mean of known ones about them, the nearest
// first, so that filters and mipmaps meet no foreign colour. All stays black where nothing is known. ENOMEM.
sheen_status sheen_image_fill(sheen_image *img, const uint8_t *known, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

// SPDX-License-Identifier: Apache-2.0
// surface_picture.h - the global texture laid out for other programs: charts of a (perhaps simpler) mesh, and its colours.
#ifndef SHEEN_RENDER_SURFACE_PICTURE_H
#define SHEEN_RENDER_SURFACE_PICTURE_H

#include "render/charts.h"
#include "render/model.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_surface_picture {
    sheen_mesh mesh;
    sheen_charts charts;
    sheen_chart_place *places; // [side_px][side_px]
    sheen_image rgb;           // linear; black where not known
    sheen_image
        n_obj; // the normal map's unit normals, zero where there is nothing; no data where there is no map
    uint8_t *known; // [side_px][side_px] 1 where a photograph saw it
    double moved_m; // by simplifying
} sheen_surface_picture;

// Texels as large as the global texture's on average, where max_side_px permits. EARG, ENOMEM, EUNSUP.
sheen_status sheen_surface_picture_make(sheen_surface_picture *out, const sheen_model *model,
                                        size_t max_triangles, int max_side_px, sheen_err *err);
void sheen_surface_picture_release(sheen_surface_picture *p);

#ifdef __cplusplus
}
#endif
#endif

// SPDX-License-Identifier: Apache-2.0
// baselines.h - what a picture would look like without separating anything: the textures that others make.
//
// All are made from the same photographs with the same visibility, so that only the idea differs.
#ifndef SHEEN_FIT_BASELINES_H
#define SHEEN_FIT_BASELINES_H

#include "fit/photos.h"
#include "fit/texel_view.h"
#include "render/texture.h"

typedef enum sheen_baseline {
    SHEEN_BASELINE_MINIMUM, // the paper's global texture, without its highlights
    SHEEN_BASELINE_MEDIAN,  // of each channel
    SHEEN_BASELINE_MEAN,
    SHEEN_BASELINE_BLEND, // view-dependent: the three photographs nearest in direction, weighted by nearness
    SHEEN_BASELINE_COUNT
} sheen_baseline;

const char *sheen_baseline_name(sheen_baseline b); // "minimum", "median", "mean", "blend of 3"

// What every photograph shows at every texel.
typedef struct sheen_texel_views {
    sheen_texel_view *views;   // [n_views]
    double (*p_camera_obj)[3]; // [n_views]
    size_t n_views, n_triangles;
    int texels_per_edge;
} sheen_texel_views;

sheen_status sheen_texel_views_make(sheen_texel_views *out, const sheen_mesh *mesh, const sheen_scene *scene,
                                    const sheen_photos *photos, int texels_per_edge, int n_threads,
                                    const sheen_progress *progress, sheen_err *err);
void sheen_texel_views_release(sheen_texel_views *v);

// The texture by which a baseline would draw a view from p_camera_obj (only the blend depends on it). The blend's weight of
// a view at an angle a to the new direction is (1 - a / a4) / a, with a4 the angle of the fourth nearest view that sees
// the texel (Buehler et al., Unstructured Lumigraph Rendering, 2001).
sheen_status sheen_baseline_texture(sheen_texture *out, sheen_baseline b, const sheen_mesh *mesh,
                                    const sheen_texel_views *v, const double p_camera_obj[3], int n_threads,
                                    sheen_err *err);

#endif

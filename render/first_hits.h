// SPDX-License-Identifier: Apache-2.0
// first_hits.h - what a camera sees of the mesh, a band of the picture's rows at a time: whoever needs the hits once works on them
// while they are in the cache, and keeps no picture of them. Used inside render only.
#ifndef SHEEN_RENDER_FIRST_HITS_H
#define SHEEN_RENDER_FIRST_HITS_H

#include <stdbool.h>

#include "render/gbuffer.h"
#include "render/pixel_rays.h"
#include "render/raster.h"

typedef struct sheen_first_hits_view {
    const sheen_scene *scene;
    const sheen_mesh *mesh;
    const sheen_camera *cam;
    const double *rt_cam_obj;
    int samples_per_side, n_threads;
    bool only_rays; // whatever the lens
} sheen_first_hits_view;

typedef struct sheen_first_hits {
    sheen_gbuffer window; // without hits
    int band_px;          // rows of pixels in a band, but for the last
    size_t n_bands;
    const sheen_scene *scene;   // lent
    sheen_raster_bands *raster; // NULL: rays
    sheen_pixel_rays rays;
} sheen_first_hits;

// Finds the window and prepares its bands. Scene, mesh and camera are lent until the release. EARG, ENOMEM.
sheen_status sheen_first_hits_init(sheen_first_hits *f, const sheen_first_hits_view *v, int band_px,
                                   sheen_err *err);
void sheen_first_hits_release(sheen_first_hits *f);

// A band's window, without hits.
sheen_gbuffer sheen_first_hits_band(const sheen_first_hits *f, size_t band);
// Its hits, laid out as the window's. May be called from several threads at once. ENOMEM.
sheen_status sheen_first_hits_find(const sheen_first_hits *f, sheen_hit *hits, size_t band, sheen_err *err);

#endif

// SPDX-License-Identifier: Apache-2.0
// align_points.h - the points of the surface on which photographs are compared, and who sees them.
#ifndef SHEEN_FIT_ALIGN_POINTS_H
#define SHEEN_FIT_ALIGN_POINTS_H

#include "fit/photos.h"
#include "fit/view_light.h"

typedef struct sheen_align_points {
    float *p_obj;     // [n_points][3]
    uint8_t *seen;    // [n_views][n_points]
    float *predicted; // [n_views][n_points][3] light besides D; zero where nothing is predicted
    size_t n_points, n_views;
} sheen_align_points;

// Points of the lattice of texels_per_edge that two photographs or more see, by the present poses: half of them the ones
// with the strongest edges in the pictures, which tell poses, the others spread evenly, which tell exposures; in an even
// order, so that every second one is like the rest. At most about max_observations points times views. lights: [n_views] of
// that lattice, or NULL. ENOMEM.
sheen_status sheen_align_points_take(sheen_align_points *out, const sheen_photos *photos,
                                     const sheen_mesh *mesh, const sheen_scene *scene, int texels_per_edge,
                                     const sheen_view_light *lights, int n_threads, sheen_err *err);
void sheen_align_points_release(sheen_align_points *a);

#endif

// SPDX-License-Identifier: Apache-2.0
// hemisphere.h - the illumination hemisphere from mirrored residuals (sections 4.1 and 4.2).
//
// Every pixel of a residual image is shot along the perfect mirror direction to the geodesic hemisphere: a partial
// hemisphere for each view. The mask hemisphere counts in how many views a node was reached at all; a node goes
// on to the combined hemisphere when it had an intensity in exactly as many, as their mean.
#ifndef SHEEN_FIT_HEMISPHERE_H
#define SHEEN_FIT_HEMISPHERE_H

#include <stdint.h>

#include "fit/residual.h"
#include "render/geodesic.h"

// One view. A node's value is the mean of the residuals that were shot to it.
typedef struct sheen_partial_hemisphere {
    float *rgb;       // [n_nodes][3]; 0 where not reached
    uint32_t *n_hits; // [n_nodes] pixels
    size_t n_nodes;
} sheen_partial_hemisphere;

sheen_status sheen_partial_hemisphere_make(sheen_partial_hemisphere *out, const sheen_geodesic *g,
                                           const sheen_residual *residual, int n_threads, sheen_err *err);
void sheen_partial_hemisphere_release(sheen_partial_hemisphere *p);

// All views together.
typedef struct sheen_hemisphere {
    float *rgb;         // [n_nodes][3] mean over views where consistent, else 0
    uint8_t *n_reached; // [n_nodes] the mask hemisphere: views that reached the node
    uint8_t *n_lit;     // [n_nodes] views in which its Y was above the threshold
    size_t n_nodes;
    size_t n_assigned; // nodes with a value
} sheen_hemisphere;

// The consistency check of section 4.1: a node keeps its value when n_lit >= min_share * n_reached and n_lit > 0.
// The paper's test, "equal", is min_share = 1.
sheen_status sheen_hemisphere_combine(sheen_hemisphere *out, const sheen_partial_hemisphere *partials,
                                      size_t n_views, float threshold_lin, float min_share, sheen_err *err);
void sheen_hemisphere_release(sheen_hemisphere *h);

// Average colour of the nodes with a value, weighted by them, scaled to Y = 1: the colour that eq. (7) assumes all
// lights to have. White where there are none.
void sheen_hemisphere_colour(double light_rgb[3], const sheen_hemisphere *h);

#endif

// SPDX-License-Identifier: Apache-2.0
// lamp_start.h - where there may be another lamp: the brightest agreeing spot of the illumination hemisphere, in depth.
#ifndef SHEEN_FIT_LAMP_START_H
#define SHEEN_FIT_LAMP_START_H

#include "fit/lamp_samples.h"
#include "render/geodesic.h"
#include "render/lamp.h"

// A place that is not asked again.
typedef struct sheen_lamp_ban {
    float direction_world[3], cosine; // within this cosine of the direction
} sheen_lamp_ban;

typedef struct sheen_lamp_start_options {
    float sigma_rad, threshold_lin; // of the lobe; light that counts
    const sheen_lamp_ban *bans;     // [n_bans]
    size_t n_bans;
    int n_threads;
} sheen_lamp_start_options;

// Residual light is shot along mirror directions as in section 4.1, but to spheres of several radii about the object: where a
// lamp is near, its spot is sharp, and the views agree, on the sphere that it lies on. Spots are ranked by evidence, the
// square of the light that arrives over the shots that do, never by the amplitude that a few shots would ask for; a node needs light
// in at least half of the views that reach it.
// g: hemisphere of sheen_lamp_start_frequency. residual: [count] luminance that is not explained yet. Returns 1 and a lamp without
// colour and extent, whose direction, distance and Y are to be refined; 0: nothing; -1: no memory.
int sheen_lamp_start(sheen_lamp *out, const sheen_geodesic *g, const sheen_lamp_samples *samples,
                     const float *residual, const sheen_lamp_start_options *options);
// Nodes are about one and a half sigma apart: a point's spot is two sigma wide there.
int sheen_lamp_start_frequency(float sigma_rad);

#endif

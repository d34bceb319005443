// SPDX-License-Identifier: Apache-2.0
// lit_sphere.h - samples of highlights on a sphere under known distant lights: eq. (7) in double precision.
#ifndef SHEEN_TESTS_FIT_LIT_SPHERE_H
#define SHEEN_TESTS_FIT_LIT_SPHERE_H

#include "fit/samples.h"
#include "render/lobe.h"

typedef struct lit_sphere {
    double light_world[8][3]; // unit
    double strength[8];       // k_S omega L
    int n_lights;
    double sigma_rad;
    double noise; // standard deviation added to every sample
    int n_views;  // cameras on a ring at 35 degrees
} lit_sphere;

// Samples above `threshold` from a grid of surface points seen by each view; release with sheen_samples_release.
void lit_sphere_samples(sheen_samples *out, const lit_sphere *scene, double threshold, uint64_t seed);

#endif

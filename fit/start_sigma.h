// SPDX-License-Identifier: Apache-2.0
// start_sigma.h - where sigma starts: above the truth, read off the brightest spot of the illumination hemisphere.
#ifndef SHEEN_FIT_START_SIGMA_H
#define SHEEN_FIT_START_SIGMA_H

#include "fit/hemisphere.h"

// A point light leaves a spot of half-maximum radius 2.355 sigma on the hemisphere (the half angle alpha is half the
// angle between light and mirror direction); a light with extent, and views that do not quite agree, leave a wider
// one, so that this errs upwards. Returned: twice that sigma, within 0.02 .. 0.3 rad. h has at least one node with a value.
double sheen_start_sigma(const sheen_hemisphere *h, const sheen_geodesic *g);

#endif

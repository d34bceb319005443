// SPDX-License-Identifier: Apache-2.0
// samples.h - the residual pixels that the lights and sigma are estimated from (section 6: thresholded, every other
// pixel).
#ifndef SHEEN_FIT_SAMPLES_H
#define SHEEN_FIT_SAMPLES_H

#include "fit/residual.h"

typedef struct sheen_samples {
    float *n_world, *v_world; // [count][3] unit normal, unit direction to the camera
    float *p_obj;             // [count][3] where on the object
    size_t *view;             // [count] which photograph
    float *intensity;         // [count] Y of the residual, linear: I_v of eq. (8)
    size_t count;
} sheen_samples;

// Pixels whose Y is above threshold_lin, on a checkerboard; if that is more than max_count, every k-th of them in
// each view. ENOMEM.
sheen_status sheen_samples_take(sheen_samples *out, const sheen_residual *residuals, size_t n_views,
                                float threshold_lin, size_t max_count, sheen_err *err);
void sheen_samples_release(sheen_samples *s);

#endif

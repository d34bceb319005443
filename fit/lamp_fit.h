// SPDX-License-Identifier: Apache-2.0
// lamp_fit.h - lamps and their lobe by Levenberg-Marquardt under the Lorentzian M-estimator.
//
// Residual of sample s in luminance: r_s = Y_s - sum_l hidden_sl' a_l R_l(x_s, n_s, v_s), R as in render/lamp.h, a_l the lamp's Y. Where the
// normal changes across the pixel by more than 0.4 sigma, R is the mean over the pixel's four quarters, as a picture of 2 x 2 samples has it.
// Minimises E = sum_s w_s log(1 + r_s^2 / (2 scale^2)), w_s the sample's weight: the sum form of eq. (9) and (11). A clipped sample counts only where the
// model is darker than it: white is a lower bound.
#ifndef SHEEN_FIT_LAMP_FIT_H
#define SHEEN_FIT_LAMP_FIT_H

#include "fit/lamp_samples.h"
#include "render/lamp.h"

// More than these are not refined together.
enum { SHEEN_LAMP_FIT_MAX = 48 };

typedef struct sheen_lamp_fit_options {
    int free_distance, free_radius, free_sigma, free_tail, free_fresnel;
    double scale;       // of the residuals
    int max_iterations; // ends earlier where E falls by less than 1e-4 of itself
    int n_threads;
    // Does the mesh hide direction l_world from a sample? NULL: nothing is hidden. Called from several threads.
    int (*hidden)(void *self, const sheen_lamp_sample *s, const float l_world[3]);
    void *hidden_self;
} sheen_lamp_fit_options;

typedef struct sheen_lamp_fit_result {
    double cost;   // E
    int converged; // E fell by less than 1e-4 of itself twice running
} sheen_lamp_fit_result;

// Improves lamps[n] and *lobe in place. other: [count] luminance that other causes add to each sample, or NULL. A lamp's colour keeps its chromaticity. ENOMEM.
sheen_status sheen_lamp_fit(sheen_lamp *lamps, size_t n, sheen_lobe_shape *lobe,
                            const sheen_lamp_samples *samples, const float *other,
                            const sheen_lamp_fit_options *options, sheen_lamp_fit_result *out,
                            sheen_err *err);

// Luminance that the lamps add to each sample: predicted[count]. ENOMEM.
sheen_status sheen_lamp_predict(float *predicted, const sheen_lamp *lamps, size_t n,
                                const sheen_lobe_shape *lobe, const sheen_lamp_samples *samples,
                                const sheen_lamp_fit_options *options, sheen_err *err);

// The same lamp by lamp: light[count][n], what each adds; where the mesh hides it 0. ENOMEM.
sheen_status sheen_lamp_light(float *light, const sheen_lamp *lamps, size_t n, const sheen_lobe_shape *lobe,
                              const sheen_lamp_samples *samples, const sheen_lamp_fit_options *options,
                              sheen_err *err);

// r_s, held at 0 where the sample is clipped and the model is not darker.
static inline double sheen_lamp_residual(const sheen_lamp_sample *s, double predicted)
{
    const double r = (double)s->Y - predicted;
    return s->clipped && r < 0 ? 0 : r;
}

// Colours of the lamps: least squares channel by channel over samples that are not clipped, shapes held, non-negative; each
// lamp's Y stays. weight: [count], of the robust fit. ENOMEM.
sheen_status sheen_lamp_colours(sheen_lamp *lamps, size_t n, const sheen_lobe_shape *lobe,
                                const sheen_lamp_samples *samples, const sheen_lamp_fit_options *options,
                                sheen_err *err);

#endif

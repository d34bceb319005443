// SPDX-License-Identifier: Apache-2.0
// response_fit.h - a camera's curve from the same points at several known exposures.
#ifndef SHEEN_CAPTURE_RESPONSE_FIT_H
#define SHEEN_CAPTURE_RESPONSE_FIT_H

#include "base/image.h"

enum { SHEEN_RESPONSE_CODES = 1024 };

// The codes (0..1) of n_points points at each of n_exposures exposures: codes[i_exposure * n_points + i_point].
typedef struct sheen_response_data {
    const float *codes;
    const double *exposure_s; // rising
    size_t n_points;
    int n_exposures;
} sheen_response_data;

typedef struct sheen_response_fit {
    float light[SHEEN_RESPONSE_CODES]; // at codes evenly from 0 to 1; 0 or more, never falling, the last is 1
    double residual;         // by how much exposures disagree under it: relative, rms over codes, noise apart
    double residual_claimed; // likewise under the curve that was claimed
} sheen_response_fit;

// EDATA where the points do not show enough different codes, or too few at two exposures; EARG, ENOMEM.
sheen_status sheen_response_solve(sheen_response_fit *out, const sheen_response_data *data,
                                  sheen_transfer claimed, sheen_err *err);

#endif

// SPDX-License-Identifier: Apache-2.0
// exposure_merge.h - several exposures of one scene into one linear picture.
#ifndef SHEEN_CAPTURE_EXPOSURE_MERGE_H
#define SHEEN_CAPTURE_EXPOSURE_MERGE_H

#include "base/image.h"

enum { SHEEN_MERGE_MAX = 9 };

// Two pictures in a row of one exposure, in linear light (RGB, full scale 1), as developed.
typedef struct sheen_exposure {
    sheen_image pair[2];
    double exposure_s;
} sheen_exposure;

typedef struct sheen_merge_report {
    double noise
        [2]; // variance of a linear value x of one picture: noise[0] + noise[1] x; from the pairs' differences
    double
        residual; // relative, rms over values between 5 % and 90 % of full scale: an exposure against the sum of all
    double saturated; // share of pixels that are saturated in every exposure
} sheen_merge_report;

// *out (RGBA, caller releases): light on the scale of an exposure of reference_s, which may exceed 1; alpha 1, or 0 where
// every exposure was saturated (a channel at 98 % of full scale or more), and RGB is what the shortest one shows. Each
// value counts with the inverse of its variance. EARG (fewer than 2 exposures, sizes that differ), ENOMEM.
sheen_status sheen_exposures_merge(sheen_image *out, sheen_merge_report *report,
                                   const sheen_exposure *exposures, int n_exposures, double reference_s,
                                   sheen_err *err);

#endif

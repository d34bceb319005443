// SPDX-License-Identifier: Apache-2.0
// drift.h - whether the light of a session stays what it was, judged by something that must not change.
#ifndef SHEEN_CAPTURE_DRIFT_H
#define SHEEN_CAPTURE_DRIFT_H

#include <stdbool.h>

#include "base/status.h"

typedef struct sheen_drift {
    bool begun;
    float rgb[3]; // linear light of the white in the first frame
} sheen_drift;    // zero to begin with

// The white's linear light in the next frame. EDATA, with the sentence, where it is a quarter brighter or darker than in
// the first one (paper seen from elsewhere, or nearer the picture's edge, changes less), or its colour is off by 6 %.
sheen_status sheen_drift_check(sheen_drift *d, const float white_rgb[3], sheen_err *err);

#endif

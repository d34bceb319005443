// SPDX-License-Identifier: Apache-2.0
// comparison.h - a photograph and its renderings side by side.
#ifndef SHEEN_FIT_COMPARISON_H
#define SHEEN_FIT_COMPARISON_H

#include "fit/evaluate.h"

// Collects the pictures of one view as sheen_evaluate hands them out, cut to the object with a margin:
// photograph | sheen | their difference x 4 about mid grey | minimum texture | median texture.
typedef struct sheen_comparison {
    sheen_image strip;                     // of the view in hand
    int x0_px, y0_px, width_px, height_px; // the cut
    const char *dir;                       // <view>.png is written here once the last panel is in
    sheen_status status;                   // of the first failure
    sheen_err err;
} sheen_comparison;

// A sheen_evaluation_picture; self is a sheen_comparison with `dir` set.
void sheen_comparison_add(void *self, const sheen_photo *photo, int method, const sheen_image *rendered,
                          const uint8_t *object);
void sheen_comparison_release(sheen_comparison *c);

#endif

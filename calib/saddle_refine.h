// SPDX-License-Identifier: Apache-2.0
// saddle_refine.h - moves a rough chessboard corner to where all grey-value gradients around it point past it.
//
// At the corner q each gradient g(p) in the neighbourhood is perpendicular to p - q: either g is zero (flat) or p
// lies on an edge through q. q solves sum w g g' (p - q) = 0 with Gaussian weights w, iterated with the window
// moved to the new q (Foerstner and Guelch 1987).
#ifndef SHEEN_CALIB_SADDLE_REFINE_H
#define SHEEN_CALIB_SADDLE_REFINE_H

#include <stdint.h>

#include "base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SHEEN_SADDLE_MAX_HALF_PX = 16 };

// q_px[2] is a rough corner in, the refined one out; the window spans half_px (1..SHEEN_SADDLE_MAX_HALF_PX) to
// each side. EDATA (q_px untouched) where the window does not fit into the picture, is flat, or the corner runs out of it.
sheen_status sheen_saddle_refine(double q_px[2], const uint8_t *grey, int width_px, int height_px,
                                 int half_px, sheen_err *err);
// The same in plain C, for tests.
sheen_status sheen_saddle_refine_ref(double q_px[2], const uint8_t *grey, int width_px, int height_px,
                                     int half_px, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

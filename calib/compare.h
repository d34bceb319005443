// SPDX-License-Identifier: Apache-2.0
// compare.h - how differently two cameras see, in pixels over the whole image.
#ifndef SHEEN_CALIB_COMPARE_H
#define SHEEN_CALIB_COMPARE_H

#include "base/camera.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_camera_difference {
    // The same ray projected by both, as they stand; root mean square of the distance in px, and its largest.
    double raw_rms_px, raw_max_px;
    // After the small rotation that makes them agree best (a calibration cannot tell such a rotation from a moved
    // principal point), for points at any distance.
    double turned_rms_px, turned_max_px;
    // After the rotation and the small move that make them agree best for points at the given distance, where
    // the board was: what is left is what a pose measured there cannot absorb.
    double moved_rms_px, moved_max_px;
} sheen_camera_difference;

// Rays through a grid of 32 x 24 pixels that reaches the image's corners. distance_m > 0 along the ray. EARG for
// cameras of different image size, EDATA where a lens has no inverse over the image.
sheen_status sheen_camera_compare(sheen_camera_difference *out, const sheen_camera *a, const sheen_camera *b,
                                  double distance_m, sheen_err *err);

// The same alignment, over the whole image, but the figures of the ring from inner_px to outer_px about the image's
// centre alone.
sheen_status sheen_camera_compare_ring(sheen_camera_difference *out, const sheen_camera *a,
                                       const sheen_camera *b, double distance_m, double inner_px,
                                       double outer_px, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

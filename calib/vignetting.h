// SPDX-License-Identifier: Apache-2.0
// vignetting.h - how much darker the picture is towards its edges, from the white of a calibration's board.
//
// In linear light a white place of the board at p in frame f, seen at a distance rho from the principal point (in halves
// of the image's diagonal), is exp(c_f + g_f . p + k0 rho^2 + k1 rho^4): exposure, distance and tilt to the lamps are
// even over the board but for a slope; what is common to all frames belongs to the lens. Linear least squares; each frame
// is left out once (jackknife), so that light which does not follow the model shows as uncertainty.
#ifndef SHEEN_CALIB_VIGNETTING_H
#define SHEEN_CALIB_VIGNETTING_H

#include <stdbool.h>
#include <stddef.h>

#include "base/camera.h"
#include "calib/view.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_vignetting {
    bool measured;
    char reason[160]; // where it was not
    int n_frames;     // that took part
    double k[2];      // light = exp(k[0] rho^2 + k[1] rho^4), 1 at the principal point
    double reach;     // rho of the outermost white; beyond nothing is known
    double light;     // there
    double sigma;     // its standard deviation
} sheen_vignetting;

// From views whose pictures are linear light after decoding by their transfer. ENOMEM.
sheen_status sheen_vignetting_measure(sheen_vignetting *out, const sheen_camera *camera,
                                      const sheen_board_view *const *views, size_t n_views, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

// SPDX-License-Identifier: Apache-2.0
// calibrate_page.h - the calibration's report for a person: one HTML file.
#ifndef SHEEN_CALIB_CALIBRATE_PAGE_H
#define SHEEN_CALIB_CALIBRATE_PAGE_H

#include "base/image.h"
#include "calib/calibrate.h"

#ifdef __cplusplus
extern "C" {
#endif

// Where the page finds the picture of frame i of sheen_calibration.frames, for the worst ones. read may be NULL.
typedef struct sheen_frame_pictures {
    sheen_status (*read)(void *self, size_t i_frame, sheen_raster *out, sheen_err *err);
    void *self;
} sheen_frame_pictures;

// Verdict and what to do next, figures, coverage, uncertainty over the image, residuals by size, direction, region and
// distribution, cross-validation, every frame, the worst ones with their pictures. EIO, ENOMEM; a picture that cannot
// be read is left out.
sheen_status sheen_calibration_page(const sheen_calibration *c, const sheen_frame_pictures *pictures,
                                    const char *title, const char *path, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

// SPDX-License-Identifier: Apache-2.0
// v4l2_options.h - what follows "v4l2:" in a URI.
#ifndef SHEEN_CAPTURE_V4L2_OPTIONS_H
#define SHEEN_CAPTURE_V4L2_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>

#include "base/file.h"
#include "base/image.h"
#include "base/pixel_format.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_v4l2_options {
    char path[SHEEN_PATH_MAX];
    uint32_t fourcc;         // 0: the camera's own choice
    int width_px, height_px; // 0: likewise
    double rate_hz;          // 0: likewise
    bool lock;
    double exposure_s; // 0: what the camera's automatic finds, to a whole number of the lamps' half periods
    int mains_hz;      // 50, 60; 0: lamps that do not flicker
    bool set_transfer; // take `transfer` for true, whatever the camera claims
    sheen_transfer transfer;
    uint32_t colorspace, ycbcr_enc,
        quantization; // in V4L2's numbers, whatever the camera claims; 0: as it claims
} sheen_v4l2_options;

// "/dev/video0?format=MJPG&size=1280x720&rate=30&exposure_ms=20&mains=60&lock=off&transfer=srgb&matrix=601&range=full".
// EARG.
sheen_status sheen_v4l2_options_parse(sheen_v4l2_options *o, const char *rest, sheen_err *err);
// What the camera claims of its colours, corrected by what the options say of it.
void sheen_v4l2_options_color(sheen_colorimetry *claim, const sheen_v4l2_options *o);

#ifdef __cplusplus
}
#endif
#endif

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

enum { SHEEN_V4L2_MAX_EXPOSURES = 16 };

// Which exposures a camera has, where its driver states it wrongly.
typedef struct sheen_v4l2_exposures {
    double most_s; // longer ones it takes without a word, to no effect; 0: as it states
    double only_s[SHEEN_V4L2_MAX_EXPOSURES]; // it has these only, whatever it takes; n_only 0: all
    int n_only;
} sheen_v4l2_exposures;

typedef struct sheen_v4l2_options {
    char path[SHEEN_PATH_MAX];
    uint32_t fourcc;         // 0: the camera's own choice
    int width_px, height_px; // 0: likewise
    double rate_hz;          // 0: likewise
    bool lock;
    double exposure_s; // 0: what the camera's automatic finds, to a whole number of the lamps' half periods
    sheen_v4l2_exposures exposures;
    int mains_hz;      // 50, 60; 0: lamps that do not flicker
    bool set_transfer; // take `transfer` for true, whatever the camera claims
    sheen_transfer transfer;
    uint32_t colorspace, ycbcr_enc,
        quantization; // in V4L2's numbers, whatever the camera claims; 0: as it claims
} sheen_v4l2_options;

// "/dev/video0?format=MJPG&size=1280x720&rate=30&exposure_ms=20&mains=60&lock=off&transfer=srgb&matrix=601&range=full
// &exposure_most_ms=7.5&exposures_ms=1,2,4".
// EARG.
sheen_status sheen_v4l2_options_parse(sheen_v4l2_options *o, const char *rest, sheen_err *err);
// What the camera claims of its colours, corrected by what the options say of it.
void sheen_v4l2_options_color(sheen_colorimetry *claim, const sheen_v4l2_options *o);

#ifdef __cplusplus
}
#endif
#endif

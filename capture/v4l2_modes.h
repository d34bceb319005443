// SPDX-License-Identifier: Apache-2.0
// v4l2_modes.h - all formats, sizes and rates that a video node offers.
#ifndef SHEEN_CAPTURE_V4L2_MODES_H
#define SHEEN_CAPTURE_V4L2_MODES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "capture/v4l2_io.h"

enum { SHEEN_V4L2_MAX_RATES = 16 };

typedef struct sheen_v4l2_mode {
    uint32_t fourcc;
    char format[8];          // its four characters
    int width_px, height_px; // the largest, where any size from a smallest on is offered
    double rates_hz[SHEEN_V4L2_MAX_RATES];
    int n_rates;   // 0: the driver does not say
    bool recorded; // sheen records this format
} sheen_v4l2_mode;

// *modes_out is the caller's to free(). ENOMEM; a node that does not say has none.
sheen_status sheen_v4l2_modes_read(sheen_v4l2_mode **modes_out, size_t *n_out, const sheen_v4l2_io *io,
                                   int fd, sheen_err *err);

#endif

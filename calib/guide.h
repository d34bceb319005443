// SPDX-License-Identifier: Apache-2.0
// guide.h - where to hold the board next, in words: where it would lower the lens's uncertainty most.
#ifndef SHEEN_CALIB_GUIDE_H
#define SHEEN_CALIB_GUIDE_H

#include <stdbool.h>
#include <stddef.h>

#include "base/board.h"
#include "calib/calibrate.h"
#include "calib/view.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_guidance {
    bool done; // the asked accuracy is reached, with SHEEN_GUIDE_MIN_FRAMES or more
    char words
        [160]; // "hold the board at the upper left, tilted to the right, so that it fills half of the picture"
    double sigma_px;        // largest over the image now; NaN while there are too few frames
    double expected_px;     // after a frame as the words say
    double rt_cam_board[6]; // that pose; all zero while there are too few frames
} sheen_guidance;

enum { SHEEN_GUIDE_MIN_FRAMES = 10 };

// From the n views taken so far. accuracy_px: the largest uncertainty, over the image at the board's distance, that
// is good enough. ENOMEM; frames that do not determine a lens yet are no failure.
sheen_status sheen_guide_next(sheen_guidance *out, const sheen_board *board, const sheen_board_view *views,
                              size_t n, double accuracy_px, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

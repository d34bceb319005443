// SPDX-License-Identifier: Apache-2.0
// steady.h - does the board stand still, and is its picture sharp.
#ifndef SHEEN_CALIB_STEADY_H
#define SHEEN_CALIB_STEADY_H

#include <stdint.h>

#include "calib/view.h"

#ifdef __cplusplus
extern "C" {
#endif

// Median distance in px by which the corners that both views show moved (tags' corners where too few saddles are
// common); NaN where nothing is.
double sheen_views_motion_px(const sheen_board_view *before, const sheen_board_view *now);
// Blur of the board's picture, by optics or motion: the median standard deviation in px of the edges between
// neighbouring saddles, from their steepest slope against their contrast. An edge that is as sharp as pixels
// permit gives about 0.4. NaN without two neighbouring saddles. grey is the picture of view->width_px x height_px.
double sheen_view_blur_px(const sheen_board_view *view, const uint8_t *grey);

#ifdef __cplusplus
}
#endif
#endif

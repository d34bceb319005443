// SPDX-License-Identifier: Apache-2.0
// stillness.h - whether a picture of the board is fit to be measured: how far it moved since the one before it, and how
// soft its edges are, both in pixels at the tags.
#ifndef SHEEN_CALIB_STILLNESS_H
#define SHEEN_CALIB_STILLNESS_H

#include <stddef.h>
#include <stdint.h>

#include "calib/view.h"

#ifdef __cplusplus
extern "C" {
#endif

// Median distance in px between the corners of tags that both pictures show (tags sorted by id); NaN where they share none.
double sheen_tags_motion_px(const sheen_tag_seen *before, size_t n_before, const sheen_tag_seen *after,
                            size_t n_after);

// Median width in px over which the tags' outer edges go from 10 % to 90 % of the way from black to white: about 1.5 in
// a sharp picture, more out of focus or in motion; told too small where it nears half a cell of the tags. Rows of grey adjoin. NaN where no tag is large enough (black border
// of 32 px) to be measured.
double sheen_tags_blur_px(const uint8_t *grey, int width_px, int height_px, const sheen_tag_seen *tags,
                          size_t n_tags);

#ifdef __cplusplus
}
#endif
#endif

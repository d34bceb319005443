// SPDX-License-Identifier: Apache-2.0
// frame_tags.h - a camera's frame as a picture, and the tags of the board in it.
#ifndef SHEEN_CLI_FRAME_TAGS_H
#define SHEEN_CLI_FRAME_TAGS_H

#include "calib/detect.h"
#include "capture/source.h"

typedef struct sheen_cli_frame_tags {
    sheen_raster raster;
    uint8_t *grey; // rows adjoin
    sheen_tag_seen *tags;
    size_t n_tags;
} sheen_cli_frame_tags;

// Develops the frame and looks for the board. No tag in view is success. On failure nothing is left to release.
sheen_status sheen_cli_frame_tags_find(sheen_cli_frame_tags *out, const sheen_frame *frame,
                                       sheen_tag_detector *detector, const sheen_board_set *boards,
                                       sheen_err *err);
void sheen_cli_frame_tags_release(sheen_cli_frame_tags *t);

#endif

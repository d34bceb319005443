// SPDX-License-Identifier: Apache-2.0
// detect.h - finds the boards' tags in a picture, and says what a tag looks like, through libapriltag.
#ifndef SHEEN_CALIB_DETECT_H
#define SHEEN_CALIB_DETECT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/board.h"
#include "base/status.h"
#include "calib/view.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_tag_detector sheen_tag_detector;

// A detector belongs to one thread; making one takes a millisecond. EUNSUP for a tag family other than
// "tag36h11", ENOMEM.
sheen_status sheen_tag_detector_new(sheen_tag_detector **detector_out, const char *family, sheen_err *err);
void sheen_tag_detector_free(sheen_tag_detector **detector);

// The boards' printed tags in an 8-bit picture of width_px x height_px (rows adjoin), sorted by id; tags of other
// ids, read with more than one wrong bit, or seen twice are left out. Corners have (0,0) at the centre of the
// top-left pixel. *tags_out is the caller's to free(); none found is success with *n_out 0.
sheen_status sheen_tags_detect(sheen_tag_seen **tags_out, size_t *n_out, sheen_tag_detector *detector,
                               const uint8_t *grey, int width_px, int height_px,
                               const sheen_board_set *boards, sheen_err *err);

// A tag as it is printed: side x side cells with the black border, row 0 at the top.
enum { SHEEN_TAG_MAX_CELLS = 16 };
typedef struct sheen_tag_picture {
    int side;
    bool white[SHEEN_TAG_MAX_CELLS][SHEEN_TAG_MAX_CELLS];
} sheen_tag_picture;

// From the library's own table. EARG: the family has no such id; EUNSUP: no such family; ENOMEM.
sheen_status sheen_tag_picture_get(sheen_tag_picture *out, const char *family, int id, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

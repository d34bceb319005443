// SPDX-License-Identifier: Apache-2.0
// board_search.h - finds the corners whose tags are covered or unreadable, by the pose that the others give.
#ifndef SHEEN_POSE_BOARD_SEARCH_H
#define SHEEN_POSE_BOARD_SEARCH_H

#include <stdint.h>

#include "base/board.h"
#include "base/camera.h"
#include "calib/view.h"

#ifdef __cplusplus
extern "C" {
#endif

// Adds to a view as sheen_board_observe gave it, from the same picture. Corners are taken only where the pose with them
// passes all tests of sheen_board_pose_find, the tags' among them, and they agree with it; otherwise, and where there is
// no pose, the view stays as it was. ENOMEM, EARG (camera).
sheen_status sheen_board_search(sheen_board_view *view, const uint8_t *grey, const sheen_camera *camera,
                                const sheen_board *board, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

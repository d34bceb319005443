// SPDX-License-Identifier: Apache-2.0
// saddles.h - a frame's view of the board: its tags, and through them its chessboard corners.
#ifndef SHEEN_CALIB_SADDLES_H
#define SHEEN_CALIB_SADDLES_H

#include <stdint.h>

#include "base/board.h"
#include "base/camera.h"
#include "base/status.h"
#include "calib/detect.h"
#include "calib/view.h"

#ifdef __cplusplus
extern "C" {
#endif

// Finds tags and saddles in an 8-bit picture (rows adjoin, perceptual code values). Only corners that are printed
// are looked for; one that is covered, blurred away or too near the picture's edge is left out. A view without
// tags is success. name and file are left empty. Release with sheen_board_view_release. ENOMEM.
sheen_status sheen_board_observe(sheen_board_view *view, sheen_tag_detector *detector, const uint8_t *grey,
                                 int width_px, int height_px, const sheen_board *board, sheen_err *err);
// The same for a set of boards, whose tags are looked for once: views[boards->n_boards], one a board.
sheen_status sheen_boards_observe(sheen_board_view *views, sheen_tag_detector *detector, const uint8_t *grey,
                                  int width_px, int height_px, const sheen_board_set *boards, sheen_err *err);

// The second half of it: fills view->saddles from view->tags and the picture.
sheen_status sheen_saddles_find(sheen_board_view *view, const uint8_t *grey, const sheen_board *board,
                                sheen_err *err);

// Looks for the board's remaining corners, whose tags may be covered or unreadable, where a pose puts them through the
// lens; gate_px: how far from there they may be found. They are judged as the others were and come after them in
// view->saddles, whose room is for all of the board's; nothing here says that the pose is right. EARG (camera).
sheen_status sheen_saddles_search(sheen_board_view *view, const uint8_t *grey, const sheen_board *board,
                                  const sheen_camera *camera, const double rt_cam_board[6], double gate_px,
                                  sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

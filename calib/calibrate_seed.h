// SPDX-License-Identifier: Apache-2.0
// calibrate_seed.h - where a calibration starts from.
#ifndef SHEEN_CALIB_CALIBRATE_SEED_H
#define SHEEN_CALIB_CALIBRATE_SEED_H

#include "base/board.h"
#include "calib/calibrate_problem.h"
#include "calib/view.h"

// Fills the problem's camera (size and lens model are set, distortion becomes 0), and rt_cam_grid of its frames,
// which are the given views. EDATA where a view's corners do not determine a plane in front of the camera.
sheen_status sheen_problem_seed(sheen_problem *p, const sheen_board *board,
                                const sheen_board_view *const *views, sheen_err *err);

// rt_cam_grid alone, for a lens that is known, p->camera. EDATA as above.
sheen_status sheen_problem_seed_poses(sheen_problem *p, const sheen_board *board,
                                      const sheen_board_view *const *views, sheen_err *err);

// grid -> board, the constant pose between mrcal's frame of the corners and the board's.
void sheen_rt_board_grid(double rt_board_grid[6], const sheen_board *board);

#endif

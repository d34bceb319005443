// SPDX-License-Identifier: Apache-2.0
// synthetic_views.h - views of a board made from numbers alone: projected corners with noise.
#ifndef SHEEN_TESTS_SYNTHETIC_VIEWS_H
#define SHEEN_TESTS_SYNTHETIC_VIEWS_H

#include <stdint.h>

#include "base/board.h"
#include "base/camera.h"
#include "calib/view.h"

// Saddles and tags (all that are printed and fall into the image) at a pose, with Gaussian noise of sigma_px per
// axis on the saddles. warp_m: how far the board's middle stands out of its edges along x and y. Release with
// sheen_board_view_release.
void test_view_make(sheen_board_view *view, const char *name, const sheen_board *board,
                    const sheen_camera *camera, const double rt_cam_board[6], double sigma_px,
                    const double warp_m[2], uint64_t *seed);

// The poses of a usual calibration: frame i of many, tilted this way and that, all over the image.
void test_calibration_pose(double rt_cam_board[6], int i, double distance_m);

#endif

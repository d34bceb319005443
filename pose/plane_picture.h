// SPDX-License-Identifier: Apache-2.0
// plane_picture.h - the plane that the object stands on, board and table, as most photographs show it.
//
// A place of the plane has one colour in all photographs that see it; what stands on the plane covers it in some of them,
// in each with another of its parts. So the colour on which most photographs agree is the plane's own.
#ifndef SHEEN_POSE_PLANE_PICTURE_H
#define SHEEN_POSE_PLANE_PICTURE_H

#include <stdbool.h>

#include "base/board.h"
#include "base/camera.h"
#include "base/image.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_plane_view {
    double rt_cam_board[6];
    const sheen_image *rgb; // of the camera's size, linear
    // What a camera that stood as in this view saw without the object; the board may have lain turned otherwise. NULL: not
    // known.
    const struct sheen_plane_view *empty;
} sheen_plane_view;

// Pixel (i, j) is the place (x0_m + i pitch_m, y0_m + j pitch_m, 0) of the board's frame. Colours are square roots of linear
// light: steps of about the same size for eye and noise. Negative: not known.
typedef struct sheen_plane_picture {
    sheen_image rgb;
    double x0_m, y0_m, pitch_m;
} sheen_plane_picture;

// The mean of the largest group of like colours (square roots of light); false where it is of fewer than three or not of more than half of all.
bool sheen_colours_agree(float out[3], float (*rgb)[3], int n);

// The board and as much again about it. A place is known where three photographs and more than half of those that look
// at it agree, else (such as below the object) on the board as a view's picture without the object shows it; and where the board's black and white squares are what they must be. board: the one that lies in z = 0. EDATA: fewer than
// three views, or they do not show the board. ENOMEM.
sheen_status sheen_plane_picture_make(sheen_plane_picture *out, const sheen_camera *camera,
                                      const sheen_board *board, const sheen_plane_view *views, size_t n_views,
                                      int n_threads, sheen_err *err);
void sheen_plane_picture_release(sheen_plane_picture *p);

#ifdef __cplusplus
}
#endif
#endif

// SPDX-License-Identifier: Apache-2.0
// view.h - what one frame shows of the board: tags and chessboard corners ("saddles") in pixels.
#ifndef SHEEN_CALIB_VIEW_H
#define SHEEN_CALIB_VIEW_H

#include <stddef.h>

#include "base/image.h"

#ifdef __cplusplus
extern "C" {
#endif

// A tag of the board that was read. Corners upper left, upper right, lower right, lower left as on the page.
typedef struct sheen_tag_seen {
    int id;
    int i_board; // which board of the set it is on; 0 for a single one
    double q_px[4][2];
    double p_board[4][3]; // metres, in its board's frame
} sheen_tag_seen;

// An inner corner of the chessboard, located to a few hundredths of a pixel.
typedef struct sheen_saddle {
    int row, col; // as in sheen_board_corner
    double q_px[2];
    double p_board[3]; // metres
    // (xx, xy, yy) of q_px for noise of one grey value a pixel; what it is in pixels the residuals say. 0: not known
    double covariance[3];
    double white_dn; // mean code of the white beside it; 0: not known
} sheen_saddle;

typedef struct sheen_board_view {
    char name[64];  // of the frame
    char file[128]; // as seen from the folder of detections/*.vnl; no white space
    int width_px, height_px;
    sheen_transfer transfer; // of the grey values in which it was seen
    size_t n_tags, n_saddles;
    sheen_tag_seen *tags;  // by id
    sheen_saddle *saddles; // row by row
    double noise_dn;       // the corners' median asymmetry (saddle_polish.h), grey values; 0: not known
} sheen_board_view;

void sheen_board_view_release(sheen_board_view *view);

#ifdef __cplusplus
}
#endif
#endif

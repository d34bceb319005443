// SPDX-License-Identifier: Apache-2.0
// board.h - the printed board: a chessboard with AprilTags in its white squares.
//
// Frame "board": origin at the board's centre on the printed surface, x right, y up the page,
// z out of the paper; metres.
#ifndef SHEEN_BASE_BOARD_H
#define SHEEN_BASE_BOARD_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_board_tag {
    int id, row, col;           // row 0 at the top of the page
    bool printed;               // false: under the object's blank disc
    double corners_board[4][3]; // upper left, upper right, lower right, lower left as read on the page
} sheen_board_tag;

typedef struct sheen_board_corner {
    int row, col; // the inner corner (saddle) at the upper left of square (row, col); 1..rows-1, 1..cols-1
    bool printed;
    double p_board[3];
} sheen_board_corner;

typedef struct sheen_board {
    char family[24];             // "tag36h11"
    int n_cols, n_rows;          // squares
    double square_m, tag_side_m; // tag_side: edge of the tag's black border
    size_t n_tags, n_corners;
    sheen_board_tag *tags;       // ids distinct
    sheen_board_corner *corners; // (n_rows-1) * (n_cols-1), row by row
} sheen_board;

// board.json. EFORMAT: not one, or its tags and corners do not fit its squares.
sheen_status sheen_board_parse(sheen_board *board, const void *data, size_t size_bytes, sheen_err *err);
sheen_status sheen_board_load(sheen_board *board, const char *path, sheen_err *err);
void sheen_board_release(sheen_board *board);

// The tag with this id; NULL where the board has none.
const sheen_board_tag *sheen_board_find_tag(const sheen_board *board, int id);

#ifdef __cplusplus
}
#endif
#endif

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
    char name[32];               // "" where it is the only one of its file
    char family[24];             // "tag36h11"
    int n_cols, n_rows;          // squares
    double square_m, tag_side_m; // tag_side: edge of the tag's black border
    double blank_radius_m;       // of the disc at the centre that is left white for the object; 0: none
    size_t n_tags, n_corners;
    sheen_board_tag *tags;       // ids distinct
    sheen_board_corner *corners; // (n_rows-1) * (n_cols-1), row by row
} sheen_board;

// What one chooses of a board; the rest follows.
typedef struct sheen_board_layout {
    int n_cols, n_rows; // squares, 2 to 100
    double square_m, tag_side_m;
    int first_id;          // of the upper left tag; ids count up in reading order
    double blank_radius_m; // 0: none
} sheen_board_layout;

// A board with a tag in each white square (row + column odd). Tags that the disc would touch, and corners that it
// would touch or come near (0.2 squares), are not printed. EARG for sizes out of range. Release *board.
sheen_status sheen_board_make(sheen_board *board, const sheen_board_layout *layout, sheen_err *err);

// board.json of one board: the only one, or the first of its file. EFORMAT: not one, or its tags and corners do
// not fit its squares.
sheen_status sheen_board_parse(sheen_board *board, const void *data, size_t size_bytes, sheen_err *err);
sheen_status sheen_board_load(sheen_board *board, const char *path, sheen_err *err);
void sheen_board_release(sheen_board *board);
// All lengths times `factor`: the print came out larger or smaller than drawn.
void sheen_board_scale(sheen_board *board, double factor);

// Several boards about one object: sheets of a ring, sides of a box. Each has its own frame; where they are to each
// other is measured from frames that see several.
typedef struct sheen_board_set {
    sheen_board *boards; // names differ; no tag id occurs twice
    size_t n_boards;     // 1 or more
} sheen_board_set;

enum { SHEEN_BOARD_SET_MAX = 64 };

// board.json: an object with a list "boards", or a single board, which is a set of one.
sheen_status sheen_board_set_parse(sheen_board_set *set, const void *data, size_t size_bytes, sheen_err *err);
sheen_status sheen_board_set_load(sheen_board_set *set, const char *path, sheen_err *err);
void sheen_board_set_release(sheen_board_set *set);
// Writes n boards as board.json: one as itself, several as a list. EIO, EACCESS, ENOMEM.
sheen_status sheen_boards_save(const sheen_board *boards, size_t n, const char *path, sheen_err *err);

// The tag with this id; NULL where the board has none.
const sheen_board_tag *sheen_board_find_tag(const sheen_board *board, int id);

#ifdef __cplusplus
}
#endif
#endif

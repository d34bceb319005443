// SPDX-License-Identifier: Apache-2.0
// board_build.c - makes a board from its sizes, scales it, and writes board.json.
#include "base/board.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/json_write.h"

enum { MAX_SQUARES = 100, MAX_ID = 100000 };

static const double max_square_m = 10;
static const double CORNER_CLEARANCE = 0.2; // of a square, between the disc and a corner that is printed

static sheen_status check_layout(const sheen_board_layout *l, sheen_err *err)
{
    if (l->n_cols < 2 || l->n_rows < 2 || l->n_cols > MAX_SQUARES || l->n_rows > MAX_SQUARES)
        return sheen_fail(err, SHEEN_EARG, "a board of %d x %d squares is out of range", l->n_cols,
                          l->n_rows);
    if (!(l->square_m > 0 && l->square_m <= max_square_m))
        return sheen_fail(err, SHEEN_EARG, "a square of %g mm is out of range", 1000 * l->square_m);
    if (!(l->tag_side_m > 0 && l->tag_side_m <= 0.9 * l->square_m))
        return sheen_fail(
            err, SHEEN_EARG,
            "a tag of %g mm leaves no white rim in a square of %g mm: at most nine tenths of it",
            1000 * l->tag_side_m, 1000 * l->square_m);
    if (l->first_id < 0 || l->first_id > MAX_ID)
        return sheen_fail(err, SHEEN_EARG, "%d is no tag's id", l->first_id);
    if (!(l->blank_radius_m >= 0 && l->blank_radius_m <= max_square_m))
        return sheen_fail(err, SHEEN_EARG, "a disc of %g mm is out of range", 2000 * l->blank_radius_m);
    return SHEEN_OK;
}

// Distance from the board's centre to the nearest point of a square of side 2 h about (x, y).
static double nearest(double x, double y, double h)
{
    return hypot(fmax(0, fabs(x) - h), fmax(0, fabs(y) - h));
}

static void add_square(sheen_board *b, int row, int col, int first_id)
{
    const double x = (col - 0.5 * b->n_cols) * b->square_m, y = (0.5 * b->n_rows - row) * b->square_m;
    if (row && col)
        b->corners[b->n_corners++] = (sheen_board_corner){
            .row = row,
            .col = col,
            .printed = b->blank_radius_m <= 0 ||
                       hypot(x, y) > b->blank_radius_m + CORNER_CLEARANCE * b->square_m,
            .p_board = {x, y, 0}};
    if ((row + col) % 2 == 0)
        return;
    const double cx = x + b->square_m / 2, cy = y - b->square_m / 2, h = b->tag_side_m / 2;
    const double rim = b->tag_side_m / 8; // a white cell around a tag belongs to it
    b->tags[b->n_tags] = (sheen_board_tag){
        .id = first_id + (int)b->n_tags,
        .row = row,
        .col = col,
        .printed = b->blank_radius_m <= 0 || nearest(cx, cy, h + rim) > b->blank_radius_m,
        .corners_board = {
            {cx - h, cy + h, 0}, {cx + h, cy + h, 0}, {cx + h, cy - h, 0}, {cx - h, cy - h, 0}}};
    b->n_tags++;
}

sheen_status sheen_board_make(sheen_board *board, const sheen_board_layout *layout, sheen_err *err)
{
    *board = (sheen_board){0};
    const sheen_status s = check_layout(layout, err);
    if (s)
        return s;
    board->n_cols = layout->n_cols;
    board->n_rows = layout->n_rows;
    board->square_m = layout->square_m;
    board->tag_side_m = layout->tag_side_m;
    board->blank_radius_m = layout->blank_radius_m;
    snprintf(board->family, sizeof board->family, "tag36h11");
    const size_t n_squares = (size_t)board->n_cols * (size_t)board->n_rows;
    board->tags = calloc(n_squares, sizeof *board->tags);
    board->corners = calloc(n_squares, sizeof *board->corners);
    if (!board->tags || !board->corners) {
        sheen_board_release(board);
        return sheen_fail_memory(err, (double)n_squares * sizeof *board->tags, "a board");
    }
    for (int row = 0; row < board->n_rows; row++)
        for (int col = 0; col < board->n_cols; col++)
            add_square(board, row, col, layout->first_id);
    return SHEEN_OK;
}

void sheen_board_scale(sheen_board *board, double factor)
{
    board->square_m *= factor;
    board->tag_side_m *= factor;
    board->blank_radius_m *= factor;
    for (size_t i = 0; i < board->n_tags; i++)
        for (int k = 0; k < 12; k++)
            board->tags[i].corners_board[k / 3][k % 3] *= factor;
    for (size_t i = 0; i < board->n_corners; i++)
        for (int k = 0; k < 3; k++)
            board->corners[i].p_board[k] *= factor;
}

static void write_tags(sheen_json_writer *w, const sheen_board *board)
{
    sheen_json_open(w, "tags", '[');
    for (size_t i = 0; i < board->n_tags; i++) {
        const sheen_board_tag *tag = &board->tags[i];
        sheen_json_open(w, NULL, '{');
        sheen_json_put_int(w, "id", tag->id);
        sheen_json_put_int(w, "row", tag->row);
        sheen_json_put_int(w, "col", tag->col);
        sheen_json_put_bool(w, "printed", tag->printed);
        sheen_json_open(w, "corners", '[');
        for (int k = 0; k < 4; k++)
            sheen_json_put_numbers(w, NULL, tag->corners_board[k], 3);
        sheen_json_close(w);
        sheen_json_close(w);
    }
    sheen_json_close(w);
}

static void write_corners(sheen_json_writer *w, const sheen_board *board)
{
    sheen_json_open(w, "corners", '[');
    for (size_t i = 0; i < board->n_corners; i++) {
        sheen_json_open(w, NULL, '{');
        sheen_json_put_int(w, "row", board->corners[i].row);
        sheen_json_put_int(w, "col", board->corners[i].col);
        sheen_json_put_bool(w, "printed", board->corners[i].printed);
        sheen_json_put_numbers(w, "p", board->corners[i].p_board, 3);
        sheen_json_close(w);
    }
    sheen_json_close(w);
}

static void write_board(sheen_json_writer *w, const sheen_board *board, bool several)
{
    sheen_json_open(w, NULL, '{');
    if (several)
        sheen_json_put_string(w, "name", board->name);
    sheen_json_put_string(w, "family", board->family);
    sheen_json_put_int(w, "cols", board->n_cols);
    sheen_json_put_int(w, "rows", board->n_rows);
    sheen_json_put_number(w, "square", board->square_m);
    sheen_json_put_number(w, "tag_black_side", board->tag_side_m);
    sheen_json_put_number(w, "disc_radius", board->blank_radius_m);
    sheen_json_put_string(
        w, "frame",
        "origin at the board's centre on the printed surface; metres; x right, y up the page "
        "(towards row 0), z out of the paper");
    write_tags(w, board);
    write_corners(w, board);
    sheen_json_close(w);
}

sheen_status sheen_boards_save(const sheen_board *boards, size_t n, const char *path, sheen_err *err)
{
    sheen_json_writer w = {0};
    if (n == 1)
        write_board(&w, &boards[0], false);
    else {
        sheen_json_open(&w, NULL, '{');
        sheen_json_open(&w, "boards", '[');
        for (size_t i = 0; i < n; i++)
            write_board(&w, &boards[i], true);
        sheen_json_close(&w);
        sheen_json_close(&w);
    }
    return sheen_json_save(&w, path, err);
}

// SPDX-License-Identifier: Apache-2.0
// board.c - reads board.json and holds its tags and corners against its squares.
//
// The positions follow from columns, rows and sizes; the file states them all the same, so that other programs
// need not know how. Here the two must agree: a board of wrong size would spoil every pose silently.
#include "base/board.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"

enum { MAX_SQUARES = 100, MAX_FILE_BYTES = 16 << 20 };

static const double max_square_m = 10;
static const double tolerance = 1e-3; // of a square's side

void sheen_board_release(sheen_board *board)
{
    free(board->tags);
    free(board->corners);
    *board = (sheen_board){0};
}

const sheen_board_tag *sheen_board_find_tag(const sheen_board *board, int id)
{
    for (size_t i = 0; i < board->n_tags; i++)
        if (board->tags[i].id == id)
            return &board->tags[i];
    return NULL;
}

// The upper left of square (row, col), from the squares' size and number. Halves give centres.
static void expected_point(const sheen_board *board, double row, double col, double p_board[3])
{
    p_board[0] = (col - 0.5 * board->n_cols) * board->square_m;
    p_board[1] = (0.5 * board->n_rows - row) * board->square_m; // y is up the page, rows count down
    p_board[2] = 0;
}

static bool fits(const sheen_board *board, const double p[3], const double want[3])
{
    for (int c = 0; c < 3; c++)
        if (!(fabs(p[c] - want[c]) <= tolerance * board->square_m))
            return false;
    return true;
}

static sheen_status read_squares(sheen_board *board, const sheen_json *root, sheen_err *err)
{
    const char *family;
    sheen_status s = sheen_json_string(root, "family", &family, err);
    if (!s)
        s = sheen_json_int(root, "cols", 2, MAX_SQUARES, &board->n_cols, err);
    if (!s)
        s = sheen_json_int(root, "rows", 2, MAX_SQUARES, &board->n_rows, err);
    if (!s)
        s = sheen_json_number(root, "square", &board->square_m, err);
    if (!s)
        s = sheen_json_number(root, "tag_black_side", &board->tag_side_m, err);
    if (!s && sheen_json_get(root, "disc_radius"))
        s = sheen_json_number(root, "disc_radius", &board->blank_radius_m, err);
    if (s)
        return s;
    if (!(board->blank_radius_m >= 0 && board->blank_radius_m <= MAX_SQUARES * max_square_m))
        return sheen_fail(err, SHEEN_EFORMAT, "a disc of %g m is out of range", board->blank_radius_m);
    if (!family[0] || strlen(family) >= sizeof board->family)
        return sheen_fail(err, SHEEN_EFORMAT, "tag family '%.30s' is unknown: use tag36h11", family);
    snprintf(board->family, sizeof board->family, "%s", family);
    if (!(board->square_m > 0 && board->square_m <= max_square_m))
        return sheen_fail(err, SHEEN_EFORMAT, "a square of %g m is out of range", board->square_m);
    if (!(board->tag_side_m > 0 && board->tag_side_m <= board->square_m))
        return sheen_fail(err, SHEEN_EFORMAT, "a tag of %g m does not fit into a square of %g m",
                          board->tag_side_m, board->square_m);
    return SHEEN_OK;
}

static sheen_status check_tag(const sheen_board *board, const sheen_board_tag *tag, sheen_err *err)
{
    // upper left, upper right, lower right, lower left as read on the page, whose y is up
    static const double side[4][2] = {{-1, 1}, {1, 1}, {1, -1}, {-1, -1}};
    if ((tag->row + tag->col) % 2 == 0)
        return sheen_fail(err, SHEEN_EFORMAT, "tag %d is in a black square (row %d, column %d)", tag->id,
                          tag->row, tag->col);
    for (int k = 0; k < 4; k++) {
        double want[3];
        expected_point(board, tag->row + 0.5, tag->col + 0.5, want);
        want[0] += side[k][0] * board->tag_side_m / 2;
        want[1] += side[k][1] * board->tag_side_m / 2;
        if (!fits(board, tag->corners_board[k], want))
            return sheen_fail(
                err, SHEEN_EFORMAT,
                "corner %d of tag %d is at (%g, %g, %g) m, but its square puts it at (%g, %g, 0)", k, tag->id,
                tag->corners_board[k][0], tag->corners_board[k][1], tag->corners_board[k][2], want[0],
                want[1]);
    }
    return SHEEN_OK;
}

static sheen_status read_tag(sheen_board *board, const sheen_json *value, uint8_t *taken, sheen_err *err)
{
    sheen_board_tag tag;
    sheen_status s = sheen_json_int(value, "id", 0, INT32_MAX, &tag.id, err);
    if (!s)
        s = sheen_json_int(value, "row", 0, board->n_rows - 1, &tag.row, err);
    if (!s)
        s = sheen_json_int(value, "col", 0, board->n_cols - 1, &tag.col, err);
    if (!s)
        s = sheen_json_bool(value, "printed", &tag.printed, err);
    if (!s)
        s = sheen_json_numbers(value, "corners", tag.corners_board[0], 12, err);
    if (!s)
        s = check_tag(board, &tag, err);
    if (s)
        return s;
    if (sheen_board_find_tag(board, tag.id))
        return sheen_fail(err, SHEEN_EFORMAT, "tag %d is there twice", tag.id);
    uint8_t *square = &taken[tag.row * board->n_cols + tag.col];
    if (*square)
        return sheen_fail(err, SHEEN_EFORMAT, "two tags are in the square of row %d, column %d", tag.row,
                          tag.col);
    *square = 1;
    board->tags[board->n_tags++] = tag;
    return SHEEN_OK;
}

static sheen_status read_tags(sheen_board *board, const sheen_json *root, sheen_err *err)
{
    const sheen_json *list;
    sheen_status s = sheen_json_array(root, "tags", &list, err);
    if (s)
        return s;
    const size_t n = sheen_json_count(list), n_squares = (size_t)board->n_cols * (size_t)board->n_rows;
    if (!n || n > n_squares / 2)
        return sheen_fail(err, SHEEN_EFORMAT, "%zu tags do not fit into the white squares of %d x %d", n,
                          board->n_cols, board->n_rows);
    uint8_t *taken = calloc(n_squares, 1);
    board->tags = calloc(n, sizeof *board->tags);
    if (!taken || !board->tags) {
        free(taken);
        return sheen_fail_memory(err, (double)(n * sizeof *board->tags), "tags");
    }
    for (size_t i = 0; i < n && !s; i++) {
        s = read_tag(board, sheen_json_at(list, i), taken, err);
        if (s)
            s = sheen_wrap(err, s, "item %zu of 'tags'", i);
    }
    free(taken);
    return s;
}

static sheen_status read_corner(sheen_board *board, const sheen_json *value, sheen_err *err)
{
    sheen_board_corner corner;
    sheen_status s = sheen_json_int(value, "row", 1, board->n_rows - 1, &corner.row, err);
    if (!s)
        s = sheen_json_int(value, "col", 1, board->n_cols - 1, &corner.col, err);
    if (!s)
        s = sheen_json_bool(value, "printed", &corner.printed, err);
    if (!s)
        s = sheen_json_numbers(value, "p", corner.p_board, 3, err);
    if (s)
        return s;
    double want[3];
    expected_point(board, corner.row, corner.col, want);
    if (!fits(board, corner.p_board, want))
        return sheen_fail(
            err, SHEEN_EFORMAT,
            "the corner of row %d, column %d is at (%g, %g, %g) m, but the squares put it at (%g, %g, 0)",
            corner.row, corner.col, corner.p_board[0], corner.p_board[1], corner.p_board[2], want[0],
            want[1]);
    sheen_board_corner *slot = &board->corners[(corner.row - 1) * (board->n_cols - 1) + corner.col - 1];
    if (slot->row)
        return sheen_fail(err, SHEEN_EFORMAT, "the corner of row %d, column %d is there twice", corner.row,
                          corner.col);
    *slot = corner;
    return SHEEN_OK;
}

// As many as there are places, and none twice: then none is missing.
static sheen_status read_corners(sheen_board *board, const sheen_json *root, sheen_err *err)
{
    const sheen_json *list;
    sheen_status s = sheen_json_array(root, "corners", &list, err);
    if (s)
        return s;
    const size_t n = sheen_json_count(list), want = (size_t)(board->n_cols - 1) * (size_t)(board->n_rows - 1);
    if (n != want)
        return sheen_fail(err, SHEEN_EFORMAT, "%zu corners, but %d x %d squares have %zu inner ones", n,
                          board->n_cols, board->n_rows, want);
    board->corners = calloc(n, sizeof *board->corners);
    if (!board->corners)
        return sheen_fail_memory(err, (double)(n * sizeof *board->corners), "corners");
    board->n_corners = n;
    for (size_t i = 0; i < n && !s; i++) {
        s = read_corner(board, sheen_json_at(list, i), err);
        if (s)
            s = sheen_wrap(err, s, "item %zu of 'corners'", i);
    }
    return s;
}

// One board, from an open object; release it after success.
static sheen_status read_board(sheen_board *board, const sheen_json *root, sheen_err *err)
{
    *board = (sheen_board){0};
    sheen_status s = read_squares(board, root, err);
    if (!s)
        s = read_tags(board, root, err);
    if (!s)
        s = read_corners(board, root, err);
    if (s)
        sheen_board_release(board);
    return s;
}

// Against the boards before it.
static sheen_status check_distinct(const sheen_board_set *set, size_t i, sheen_err *err)
{
    const sheen_board *board = &set->boards[i];
    for (size_t k = 0; k < i; k++) {
        if (!strcmp(set->boards[k].name, board->name))
            return sheen_fail(err, SHEEN_EFORMAT, "two boards are named '%s'", board->name);
        if (strcmp(set->boards[k].family, board->family) != 0)
            return sheen_fail(err, SHEEN_EFORMAT, "boards '%s' and '%s' have tags of different families",
                              set->boards[k].name, board->name);
        for (size_t t = 0; t < board->n_tags; t++)
            if (sheen_board_find_tag(&set->boards[k], board->tags[t].id))
                return sheen_fail(err, SHEEN_EFORMAT, "tag %d is on board '%s' and on board '%s'",
                                  board->tags[t].id, set->boards[k].name, board->name);
    }
    return SHEEN_OK;
}

static sheen_status read_set(sheen_board_set *set, const sheen_json *root, sheen_err *err)
{
    const sheen_json *list = sheen_json_get(root, "boards");
    const bool several = list != NULL;
    sheen_status s = several ? sheen_json_array(root, "boards", &list, err) : SHEEN_OK;
    if (s)
        return s;
    const size_t n = several ? sheen_json_count(list) : 1;
    if (n < 1 || n > SHEEN_BOARD_SET_MAX)
        return sheen_fail(err, SHEEN_EFORMAT, "%zu boards are not 1 to %d", n, (int)SHEEN_BOARD_SET_MAX);
    set->boards = calloc(n, sizeof *set->boards);
    if (!set->boards)
        return sheen_fail_memory(err, (double)(n * sizeof *set->boards), "boards");
    for (size_t i = 0; i < n && !s; i++) {
        const sheen_json *item = several ? sheen_json_at(list, i) : root;
        const char *name = "";
        if (several)
            s = sheen_json_string(item, "name", &name, err);
        if (!s)
            s = read_board(&set->boards[i], item, err);
        if (s)
            return several ? sheen_wrap(err, s, "item %zu of 'boards'", i) : s;
        snprintf(set->boards[i].name, sizeof set->boards[i].name, "%s", name);
        set->n_boards = i + 1;
        s = check_distinct(set, i, err);
    }
    return s;
}

void sheen_board_set_release(sheen_board_set *set)
{
    for (size_t i = 0; i < set->n_boards; i++)
        sheen_board_release(&set->boards[i]);
    free(set->boards);
    *set = (sheen_board_set){0};
}

sheen_status sheen_board_set_parse(sheen_board_set *set, const void *data, size_t size_bytes, sheen_err *err)
{
    *set = (sheen_board_set){0};
    sheen_json *root = NULL;
    sheen_status s = sheen_json_parse(&root, data, size_bytes, err);
    if (!s)
        s = read_set(set, root, err);
    sheen_json_free(&root);
    if (s)
        sheen_board_set_release(set);
    return s;
}

sheen_status sheen_board_set_load(sheen_board_set *set, const char *path, sheen_err *err)
{
    *set = (sheen_board_set){0};
    uint8_t *data;
    size_t size_bytes;
    sheen_status s = sheen_file_read(&data, &size_bytes, path, MAX_FILE_BYTES, err);
    if (s)
        return s;
    s = sheen_board_set_parse(set, data, size_bytes, err);
    free(data);
    return s ? sheen_wrap(err, s, "cannot read '%s'", path) : SHEEN_OK;
}

// Keeps the first board of a set and lets the others go.
static void take_first(sheen_board *board, sheen_board_set *set)
{
    *board = set->boards[0];
    set->boards[0] = (sheen_board){0};
    sheen_board_set_release(set);
}

sheen_status sheen_board_parse(sheen_board *board, const void *data, size_t size_bytes, sheen_err *err)
{
    sheen_board_set set;
    *board = (sheen_board){0};
    const sheen_status s = sheen_board_set_parse(&set, data, size_bytes, err);
    if (!s)
        take_first(board, &set);
    return s;
}

sheen_status sheen_board_load(sheen_board *board, const char *path, sheen_err *err)
{
    sheen_board_set set;
    *board = (sheen_board){0};
    const sheen_status s = sheen_board_set_load(&set, path, err);
    if (!s)
        take_first(board, &set);
    return s;
}

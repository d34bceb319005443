// SPDX-License-Identifier: Apache-2.0
// test_board.c - board.json: the sample's board, and boards whose numbers do not fit together.
#include "tests/support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/board.h"

#define SAMPLE SHEEN_TEST_DATA "/penguin/board.json"

static void reads_the_sample_board(void **state)
{
    (void)state;
    sheen_err err;
    sheen_board board;
    assert_ok(sheen_board_load(&board, SAMPLE, &err), err);
    assert_string_equal(board.family, "tag36h11");
    assert_int_equal(board.n_cols, 12);
    assert_int_equal(board.n_rows, 9);
    assert_close(board.square_m, 0.03, 0);
    assert_close(board.tag_side_m, 0.0192, 0);
    assert_int_equal(board.n_tags, 54);
    assert_int_equal(board.n_corners, 88);

    size_t n_printed = 0;
    for (size_t i = 0; i < board.n_tags; i++)
        n_printed += board.tags[i].printed;
    assert_int_equal(n_printed, 41); // the rest lies under the object's disc
    n_printed = 0;
    for (size_t i = 0; i < board.n_corners; i++)
        n_printed += board.corners[i].printed;
    assert_int_equal(n_printed, 72);
    sheen_board_release(&board);
    assert_null(board.tags);
}

// By hand: the square of row 0, column 1 is centred at x = (1.5 - 6) 0.03, y = (4.5 - 0.5) 0.03.
static void tag_corners_are_read_as_on_the_page(void **state)
{
    (void)state;
    sheen_err err;
    sheen_board board;
    assert_ok(sheen_board_load(&board, SAMPLE, &err), err);
    const sheen_board_tag *tag = sheen_board_find_tag(&board, 0);
    assert_non_null(tag);
    assert_int_equal(tag->row, 0);
    assert_int_equal(tag->col, 1);
    static const double x = -0.135, y = 0.12, h = 0.0096;
    static const double want[4][2] = {{x - h, y + h}, {x + h, y + h}, {x + h, y - h}, {x - h, y - h}};
    for (int k = 0; k < 4; k++) {
        assert_close(tag->corners_board[k][0], want[k][0], 1e-9);
        assert_close(tag->corners_board[k][1], want[k][1], 1e-9);
        assert_close(tag->corners_board[k][2], 0, 0);
    }
    assert_null(sheen_board_find_tag(&board, 54));
    assert_null(sheen_board_find_tag(&board, -1));
    sheen_board_release(&board);
}

static void corners_are_in_order_and_in_place(void **state)
{
    (void)state;
    sheen_err err;
    sheen_board board;
    assert_ok(sheen_board_load(&board, SAMPLE, &err), err);
    for (int row = 1; row < 9; row++)
        for (int col = 1; col < 12; col++) {
            const sheen_board_corner *c = &board.corners[(row - 1) * 11 + col - 1];
            assert_int_equal(c->row, row);
            assert_int_equal(c->col, col);
            assert_close(c->p_board[0], (col - 6) * 0.03, 1e-9);
            assert_close(c->p_board[1], (4.5 - row) * 0.03, 1e-9);
        }
    sheen_board_release(&board);
}

// The smallest board: 2 x 2 squares, tags in the two white ones, one inner corner.
static const char good[] =
    "{\"family\": \"tag36h11\", \"cols\": 2, \"rows\": 2, \"square\": 0.1, \"tag_black_side\": 0.06,"
    "\"tags\": ["
    "{\"id\": 3, \"row\": 0, \"col\": 1, \"printed\": true, \"corners\":"
    "[[0.02, 0.08, 0], [0.08, 0.08, 0], [0.08, 0.02, 0], [0.02, 0.02, 0]]},"
    "{\"id\": 4, \"row\": 1, \"col\": 0, \"printed\": false, \"corners\":"
    "[[-0.08, -0.02, 0], [-0.02, -0.02, 0], [-0.02, -0.08, 0], [-0.08, -0.08, 0]]}],"
    "\"corners\": [{\"row\": 1, \"col\": 1, \"printed\": true, \"p\": [0, 0, 0]}]}";

static void says_what_does_not_fit(void **state)
{
    (void)state;
    static const struct {
        const char *from, *to, *msg;
    } cases[] = {
        {"\"family\"", "\"f\"", "no text 'family'"},
        {"tag36h11", "", "tag family '' is unknown: use tag36h11"},
        {"\"cols\": 2", "\"cols\": 1", "'cols' is 1, not a whole number from 2 to 100"},
        {"\"cols\": 2", "\"cols\": 3",
         "item 0 of 'tags': corner 0 of tag 3 is at (0.02, 0.08, 0) m, but its square "
         "puts it at (-0.03, 0.08, 0)"},
        {"\"rows\": 2", "\"rows\": 1e9", "'rows' is 1e+09, not a whole number from 2 to 100"},
        {"\"square\": 0.1", "\"square\": 0", "a square of 0 m is out of range"},
        {"\"square\": 0.1", "\"square\": 100", "a square of 100 m is out of range"},
        {"0.06", "0.2", "a tag of 0.2 m does not fit into a square of 0.1 m"},
        {"0.06", "0.05",
         "item 0 of 'tags': corner 0 of tag 3 is at (0.02, 0.08, 0) m, but its square puts it at "
         "(0.025, 0.075, 0)"},
        {"\"id\": 4", "\"id\": 3", "item 1 of 'tags': tag 3 is there twice"},
        {"\"id\": 3", "\"id\": -3", "item 0 of 'tags': 'id' is -3, not a whole number from 0 to 2147483647"},
        {"\"row\": 0, \"col\": 1", "\"row\": 0, \"col\": 0",
         "item 0 of 'tags': tag 3 is in a black square (row 0, column 0)"},
        {"\"row\": 0, \"col\": 1", "\"row\": 2, \"col\": 1",
         "item 0 of 'tags': 'row' is 2, not a whole number from 0 to 1"},
        {"\"printed\": false", "\"printed\": 0", "item 1 of 'tags': no true or false 'printed'"},
        {"[0.02, 0.08, 0], ", "", "item 0 of 'tags': 'corners' has 9 numbers, not 12"},
        {"[0.02, 0.08, 0], [0.08, 0.08, 0]", "[0.08, 0.08, 0], [0.02, 0.08, 0]",
         "item 0 of 'tags': corner 0 of tag 3 is at (0.08, 0.08, 0) m, but its square puts it at (0.02, "
         "0.08, 0)"},
        {"\"p\": [0, 0, 0]", "\"p\": [0, 0.01, 0]",
         "item 0 of 'corners': the corner of row 1, column 1 is at (0, 0.01, 0) m, but the squares put it at "
         "(0, 0, 0)"},
        {"{\"row\": 1, \"col\": 1, \"printed\": true, \"p\": [0, 0, 0]}", "",
         "0 corners, but 2 x 2 squares have 1 inner ones"},
        {"\"tags\"", "\"labels\"", "no list 'tags'"},
    };
    sheen_err err;
    sheen_board board;
    assert_ok(sheen_board_parse(&board, good, strlen(good), &err), err);
    assert_true(board.tags[0].printed && !board.tags[1].printed);
    sheen_board_release(&board);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[1200];
        const char *at = strstr(good, cases[i].from);
        assert_non_null(at);
        snprintf(text, sizeof text, "%.*s%s%s", (int)(at - good), good, cases[i].to,
                 at + strlen(cases[i].from));
        const sheen_status s = sheen_board_parse(&board, text, strlen(text), &err);
        assert_string_equal(err.msg, cases[i].msg);
        assert_int_equal(s, SHEEN_EFORMAT);
        assert_null(board.tags);
        assert_null(board.corners);
    }
}

static void cut_files_are_refused(void **state)
{
    (void)state;
    sheen_err err;
    sheen_board board;
    for (size_t n = 0; n < sizeof good - 1; n++)
        assert_int_equal(sheen_board_parse(&board, good, n, NULL), SHEEN_EFORMAT);
    assert_int_equal(sheen_board_load(&board, "/nowhere/board.json", &err), SHEEN_EIO);
    assert_string_equal(err.msg, "cannot open '/nowhere/board.json': No such file or directory");
}

static void a_made_board_reads_back(void **state)
{
    sheen_err err;
    sheen_board made, read;
    char path[TEST_PATH_MAX];
    const sheen_board_layout layout = {.n_cols = 12,
                                       .n_rows = 9,
                                       .square_m = 0.025,
                                       .tag_side_m = 0.018,
                                       .first_id = 7,
                                       .blank_radius_m = 0.05};
    assert_ok(sheen_board_make(&made, &layout, &err), err);
    assert_int_equal(made.n_tags, 54);
    assert_int_equal(made.n_corners, 88);
    sheen_board_scale(&made, 0.99);
    test_scratch_file(path, *state, "board.json");
    assert_ok(sheen_boards_save(&made, 1, path, &err), err);
    assert_ok(sheen_board_load(&read, path, &err), err);
    assert_close(read.square_m, 0.02475, 1e-15);
    assert_close(read.blank_radius_m, 0.0495, 1e-15);
    for (size_t i = 0; i < made.n_tags; i++) {
        const sheen_board_tag *tag = &read.tags[i];
        assert_int_equal(tag->id, 7 + (int)i);
        assert_int_equal(tag->printed, made.tags[i].printed);
        double least = 1; // what is printed keeps clear of the disc
        for (int k = 0; k < 4; k++)
            least = fmin(least, hypot(tag->corners_board[k][0], tag->corners_board[k][1]));
        assert_true(!tag->printed || least > 0.0495);
    }
    for (size_t i = 0; i < made.n_corners; i++)
        assert_int_equal(read.corners[i].printed, made.corners[i].printed);
    sheen_board_release(&read);
    sheen_board_release(&made);
}

static void makes_no_impossible_board(void **state)
{
    (void)state;
    static const struct {
        sheen_board_layout layout;
        const char *msg;
    } cases[] = {
        {{1, 9, 0.025, 0.018, 0, 0}, "a board of 1 x 9 squares is out of range"},
        {{12, 9, 0, 0.018, 0, 0}, "a square of 0 mm is out of range"},
        {{12, 9, 0.025, 0.025, 0, 0},
         "a tag of 25 mm leaves no white rim in a square of 25 mm: at most nine tenths of it"},
        {{12, 9, 0.025, 0.018, -1, 0}, "-1 is no tag's id"},
        {{12, 9, 0.025, 0.018, 0, -1}, "a disc of -2000 mm is out of range"},
    };
    sheen_err err;
    sheen_board board;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_int_equal(sheen_board_make(&board, &cases[i].layout, &err), SHEEN_EARG);
        assert_string_equal(err.msg, cases[i].msg);
    }
}

static void several_boards_share_a_file(void **state)
{
    sheen_err err;
    sheen_board boards[3];
    sheen_board_set set;
    char path[TEST_PATH_MAX];
    for (int i = 0; i < 3; i++) {
        const sheen_board_layout layout = {4 + i, 4, 0.02, 0.014, 20 * i, 0};
        assert_ok(sheen_board_make(&boards[i], &layout, &err), err);
        snprintf(boards[i].name, sizeof boards[i].name, "sheet-%d", i + 1);
    }
    test_scratch_file(path, *state, "board.json");
    assert_ok(sheen_boards_save(boards, 3, path, &err), err);
    assert_ok(sheen_board_set_load(&set, path, &err), err);
    assert_int_equal(set.n_boards, 3);
    assert_string_equal(set.boards[2].name, "sheet-3");
    assert_int_equal(set.boards[2].tags[0].id, 40);
    assert_int_equal(set.boards[2].n_cols, 6);
    sheen_board_set_release(&set);
    sheen_board first;
    assert_ok(sheen_board_load(&first, path, &err), err);
    assert_string_equal(first.name, "sheet-1");
    sheen_board_release(&first);

    boards[1].tags[0].id = 3; // sheet-1 has that too
    assert_ok(sheen_boards_save(boards, 3, path, &err), err);
    assert_fails(sheen_board_set_load(&set, path, &err), err, SHEEN_EFORMAT,
                 "tag 3 is on board 'sheet-1' and on board 'sheet-2'");
    boards[1].tags[0].id = 20;
    snprintf(boards[1].name, sizeof boards[1].name, "sheet-1");
    assert_ok(sheen_boards_save(boards, 3, path, &err), err);
    assert_fails(sheen_board_set_load(&set, path, &err), err, SHEEN_EFORMAT,
                 "two boards are named 'sheet-1'");
    static const char empty[] = "{\"boards\": []}";
    assert_fails(sheen_board_set_parse(&set, empty, strlen(empty), &err), err, SHEEN_EFORMAT,
                 "0 boards are not 1 to 64");
    for (int i = 0; i < 3; i++)
        sheen_board_release(&boards[i]);
}

// A single board is a set of one.
static void a_single_board_is_a_set(void **state)
{
    (void)state;
    sheen_err err;
    sheen_board_set set;
    assert_ok(sheen_board_set_load(&set, SAMPLE, &err), err);
    assert_int_equal(set.n_boards, 1);
    assert_string_equal(set.boards[0].name, "");
    assert_close(set.boards[0].blank_radius_m, 0.066, 0);
    sheen_board_set_release(&set);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads_the_sample_board),
        cmocka_unit_test(tag_corners_are_read_as_on_the_page),
        cmocka_unit_test(corners_are_in_order_and_in_place),
        cmocka_unit_test(says_what_does_not_fit),
        cmocka_unit_test(cut_files_are_refused),
        cmocka_unit_test_setup_teardown(a_made_board_reads_back, test_scratch_setup, test_scratch_teardown),
        cmocka_unit_test(makes_no_impossible_board),
        cmocka_unit_test_setup_teardown(several_boards_share_a_file, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test(a_single_board_is_a_set),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

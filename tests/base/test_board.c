// SPDX-License-Identifier: Apache-2.0
// test_board.c - board.json: the sample's board, and boards whose numbers do not fit together.
#include "tests/support.h"

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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads_the_sample_board),
        cmocka_unit_test(tag_corners_are_read_as_on_the_page),
        cmocka_unit_test(corners_are_in_order_and_in_place),
        cmocka_unit_test(says_what_does_not_fit),
        cmocka_unit_test(cut_files_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// SPDX-License-Identifier: Apache-2.0
// fuzz_board.c - any bytes as a board.json.
#include <stdlib.h>

#include "base/board.h"

static void check(const sheen_board *board)
{
    for (size_t i = 0; i < board->n_tags; i++)
        if (sheen_board_find_tag(board, board->tags[i].id) != &board->tags[i])
            abort();
    for (size_t i = 0; i < board->n_corners; i++)
        if (board->corners[i].row != 1 + (int)i / (board->n_cols - 1))
            abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    sheen_err err;
    sheen_board_set set;
    if (sheen_board_set_parse(&set, data, size_bytes, &err))
        return 0;
    for (size_t i = 0; i < set.n_boards; i++)
        check(&set.boards[i]);
    sheen_board_set_release(&set);
    return 0;
}

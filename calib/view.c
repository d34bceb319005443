// SPDX-License-Identifier: Apache-2.0
// view.c - memory of a view of the board.
#include "calib/view.h"

#include <stdlib.h>

void sheen_board_view_release(sheen_board_view *view)
{
    free(view->tags);
    free(view->saddles);
    *view = (sheen_board_view){0};
}

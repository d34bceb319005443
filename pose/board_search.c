// SPDX-License-Identifier: Apache-2.0
// board_search.c - pose, search where it puts the other corners, pose again: until nothing is gained.
//
// A search about a wrong pose could lock onto a grid shifted by a square, whose corners are as good as the right ones.
// So the gate is far below a square, each round's pose must agree with the tags, and a round counts only where more
// corners agree than before.
#include "pose/board_search.h"

#include <stdbool.h>
#include <stdlib.h>

#include "calib/saddles.h"
#include "pose/board_pose.h"

enum { ROUNDS = 3 };

static const double GATE_PX = 1;
static const double TAG_GATE_PX = 2.5; // of a pose from the tags' corners, which blur moves

static int by_place(const void *a, const void *b)
{
    const sheen_saddle *left = a, *right = b;
    return left->row != right->row ? (left->row > right->row) - (left->row < right->row)
                                   : (left->col > right->col) - (left->col < right->col);
}

// Keeps of the corners from n_before on those that agree with the pose.
static void keep_inliers(sheen_board_view *view, size_t n_before, const bool *is_inlier)
{
    size_t n = n_before;
    for (size_t i = n_before; i < view->n_saddles; i++)
        if (is_inlier[i])
            view->saddles[n++] = view->saddles[i];
    view->n_saddles = n;
}

typedef struct picture {
    const uint8_t *grey;
    const sheen_camera *camera;
    const sheen_board *board;
} picture;

// One search about `pose`, which becomes the better one. *gained: whether anything was.
static sheen_status search_once(bool *gained, sheen_board_pose *pose, sheen_board_view *view, bool *is_inlier,
                                const picture *in, sheen_err *err)
{
    const size_t n_before = view->n_saddles;
    sheen_board_pose again;
    *gained = false;
    sheen_status s = sheen_saddles_search(view, in->grey, in->board, in->camera, pose->rt_cam_board,
                                          pose->from_tags ? TAG_GATE_PX : GATE_PX, err);
    if (s || view->n_saddles == n_before)
        return s;
    s = sheen_board_pose_find(&again, is_inlier, in->camera, in->board, view, err);
    if (s || again.from_tags || (!pose->from_tags && again.n_points <= pose->n_points)) {
        view->n_saddles = n_before;
        return s == SHEEN_EDATA ? SHEEN_OK : s;
    }
    keep_inliers(view, n_before, is_inlier);
    *pose = again;
    *gained = true;
    return SHEEN_OK;
}

sheen_status sheen_board_search(sheen_board_view *view, const uint8_t *grey, const sheen_camera *camera,
                                const sheen_board *board, sheen_err *err)
{
    sheen_board_pose pose;
    bool *is_inlier = malloc((board->n_corners + 1) * sizeof *is_inlier), gained = true;
    if (!is_inlier)
        return sheen_fail_memory(err, (double)board->n_corners, "a search for corners");
    const picture in = {grey, camera, board};
    sheen_status s = sheen_board_pose_find(&pose, NULL, camera, board, view, err);
    for (int round = 0; round < ROUNDS && gained && !s; round++)
        s = search_once(&gained, &pose, view, is_inlier, &in, err);
    if (view->n_saddles)
        qsort(view->saddles, view->n_saddles, sizeof *view->saddles, by_place);
    free(is_inlier);
    return s == SHEEN_EDATA ? SHEEN_OK : s; // no pose to search by
}

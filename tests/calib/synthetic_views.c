// SPDX-License-Identifier: Apache-2.0
// synthetic_views.c - projects a board's corners and tags.
#include "synthetic_views.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"
#include "support_board.h"

static bool inside(const double q[2], const sheen_camera *camera)
{
    return q[0] >= 5 && q[1] >= 5 && q[0] <= camera->width_px - 6 && q[1] <= camera->height_px - 6;
}

void test_view_make(sheen_board_view *view, const char *name, const sheen_board *board,
                    const sheen_camera *camera, const double rt_cam_board[6], double sigma_px,
                    const double warp_m[2], uint64_t *seed)
{
    *view = (sheen_board_view){.width_px = camera->width_px,
                               .height_px = camera->height_px,
                               .tags = calloc(board->n_tags, sizeof *view->tags),
                               .saddles = calloc(board->n_corners, sizeof *view->saddles)};
    assert_true(view->tags && view->saddles);
    snprintf(view->name, sizeof view->name, "%s", name);
    snprintf(view->file, sizeof view->file, "../frames/%s.jpg", name);
    for (size_t i = 0; i < board->n_corners; i++) {
        const sheen_board_corner *c = &board->corners[i];
        sheen_saddle *s = &view->saddles[view->n_saddles];
        double p[3], q[2];
        memcpy(p, c->p_board, sizeof p);
        // mrcal's shape of a bent board: a parabola that is zero at the outermost corners
        const double u = 2.0 * (c->col - 1) / (board->n_cols - 2) - 1,
                     v = 2.0 * (c->row - 1) / (board->n_rows - 2) - 1;
        p[2] = warp_m[0] * (1 - u * u) + warp_m[1] * (1 - v * v);
        test_board_project(q, camera, rt_cam_board, p);
        for (int k = 0; k < 2; k++)
            q[k] += sigma_px * test_random_normal(seed);
        if (!c->printed || !inside(q, camera))
            continue;
        *s = (sheen_saddle){.row = c->row, .col = c->col, .q_px = {q[0], q[1]}};
        memcpy(s->p_board, c->p_board, sizeof s->p_board);
        view->n_saddles++;
    }
    for (size_t i = 0; i < board->n_tags; i++) {
        sheen_tag_seen *t = &view->tags[view->n_tags];
        *t = (sheen_tag_seen){.id = board->tags[i].id};
        memcpy(t->p_board, board->tags[i].corners_board, sizeof t->p_board);
        bool all = board->tags[i].printed;
        for (int k = 0; k < 4; k++) {
            test_board_project(t->q_px[k], camera, rt_cam_board, t->p_board[k]);
            all = all && inside(t->q_px[k], camera);
        }
        view->n_tags += all;
    }
}

void test_calibration_pose(double rt_cam_board[6], int i, double distance_m)
{
    const double target[2] = {0.08 * (i % 3 - 1), 0.06 * (i / 3 % 3 - 1)};
    test_board_look(rt_cam_board, target, distance_m * (1 + 0.15 * (i % 4 - 1.5)), 8 + 9 * (i % 5), 137.5 * i,
                    90 * (i % 4) + 10 * (i % 3));
}

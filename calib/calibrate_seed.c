// SPDX-License-Identifier: Apache-2.0
// calibrate_seed.c - focal length from homographies (Zhang 2000, section 3.1, with the principal point at the
// image's centre, square pixels, no distortion), and poses from the same homographies; or poses alone where the lens is
// known, from homographies to undistorted directions.
#include "calib/calibrate_seed.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "calib/homography.h"

void sheen_rt_board_grid(double rt_board_grid[6], const sheen_board *board)
{
    // x the same, y and z turned round; the origin is the corner (1, 1)
    const sheen_Rt Rt = {
        .R = {{1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
        .t = {(1 - 0.5 * board->n_cols) * board->square_m, (0.5 * board->n_rows - 1) * board->square_m, 0}};
    sheen_rt_from_Rt(rt_board_grid, &Rt);
}

// H maps board (x, y) to pixels about the image's centre, in units of the image's width.
static sheen_status view_homography(double H[9], const sheen_problem *p, const sheen_board_view *view,
                                    sheen_err *err)
{
    const size_t n = view->n_saddles;
    double *xy = malloc(4 * n * sizeof *xy), *q = xy ? xy + 2 * n : NULL;
    if (!xy)
        return sheen_fail_memory(err, 4 * (double)n * sizeof *xy, "a calibration");
    for (size_t i = 0; i < n; i++) {
        const sheen_saddle *c = &view->saddles[i];
        memcpy(xy + 2 * i, c->p_board, 2 * sizeof *xy);
        q[2 * i] = (c->q_px[0] - (p->camera.width_px - 1) / 2.0) / p->camera.width_px;
        q[2 * i + 1] = (c->q_px[1] - (p->camera.height_px - 1) / 2.0) / p->camera.width_px;
    }
    const bool ok = sheen_homography_fit(H, xy, q, n);
    free(xy);
    return ok ? SHEEN_OK
              : sheen_fail(err, SHEEN_EDATA, "the corners in frame '%s' do not lie on a board", view->name);
}

// Adds one equation a w + b = 0 about w = 1/f^2, scaled to the size of the columns that it compares.
static void add_equation(double *aa, double *ab, double a, double b, double scale)
{
    *aa += a * a / (scale * scale);
    *ab += a * b / (scale * scale);
}

// The focal length in units of the image's width. Frames that see the board face on say nothing; without any
// other, or where noise makes w negative, a usual one is taken: the optimiser has room.
static double focal_length(double (*H)[9], int n_frames)
{
    double aa = 0, ab = 0;
    for (int i = 0; i < n_frames; i++) {
        const double *h = H[i];
        const double n1 = h[0] * h[0] + h[3] * h[3], n2 = h[1] * h[1] + h[4] * h[4];
        const double scale = sqrt(n1 * n2);
        add_equation(&aa, &ab, h[0] * h[1] + h[3] * h[4], h[6] * h[7], scale);
        add_equation(&aa, &ab, n1 - n2, h[6] * h[6] - h[7] * h[7], scale);
    }
    const double usual = 1.2;
    const double w = aa > 0 ? -ab / aa : 0;
    const double f = w > 0 ? 1 / sqrt(w) : usual;
    return f > 0.2 && f < 20 ? f : usual;
}

// The pose of frame i of the problem, whose H maps board (x, y) to (X/Z, Y/Z).
static sheen_status seed_pose(sheen_problem *p, int i, const double H[9], const sheen_board *board,
                              const sheen_board_view *view, sheen_err *err)
{
    sheen_Rt Rt_cam_board;
    double rt_cam_board[6], rt_board_grid[6];
    if (!sheen_homography_pose(&Rt_cam_board, H, view->saddles[0].p_board))
        return sheen_fail(err, SHEEN_EDATA, "the board in frame '%s' has no pose", view->name);
    sheen_rt_board_grid(rt_board_grid, board);
    sheen_rt_from_Rt(rt_cam_board, &Rt_cam_board);
    sheen_rt_compose(p->rt_cam_grid + 6 * (size_t)i, rt_cam_board, rt_board_grid);
    return SHEEN_OK;
}

sheen_status sheen_problem_seed(sheen_problem *p, const sheen_board *board,
                                const sheen_board_view *const *views, sheen_err *err)
{
    double(*H)[9] = calloc((size_t)p->n_frames + 1, sizeof *H);
    if (!H)
        return sheen_fail_memory(err, (double)p->n_frames * sizeof *H, "a calibration");
    sheen_status s = SHEEN_OK;
    for (int i = 0; i < p->n_frames && !s; i++)
        s = view_homography(H[i], p, views[i], err);
    if (s)
        goto done;
    const double f = focal_length(H, p->n_frames);
    memset(p->camera.intrinsics, 0, sizeof p->camera.intrinsics);
    p->camera.intrinsics[0] = p->camera.intrinsics[1] = f * p->camera.width_px;
    p->camera.intrinsics[2] = (p->camera.width_px - 1) / 2.0;
    p->camera.intrinsics[3] = (p->camera.height_px - 1) / 2.0;
    for (int i = 0; i < p->n_frames && !s; i++) {
        for (int k = 0; k < 6; k++)
            H[i][k] /= f;
        s = seed_pose(p, i, H[i], board, views[i], err);
    }

done:
    free(H);
    return s;
}

sheen_status sheen_problem_seed_poses(sheen_problem *p, const sheen_board *board,
                                      const sheen_board_view *const *views, sheen_err *err)
{
    const size_t n_max = (size_t)p->n_cols * (size_t)p->n_rows;
    double *q_px = malloc(7 * n_max * sizeof *q_px);
    if (!q_px)
        return sheen_fail_memory(err, 7 * (double)n_max * sizeof *q_px, "a calibration");
    double *xy = q_px + 2 * n_max, *v = xy + 2 * n_max; // v: directions, then (X/Z, Y/Z) in their place
    sheen_status s = SHEEN_OK;
    for (int i = 0; i < p->n_frames && !s; i++) {
        const size_t n = views[i]->n_saddles;
        double H[9];
        for (size_t k = 0; k < n; k++) {
            memcpy(q_px + 2 * k, views[i]->saddles[k].q_px, 2 * sizeof *q_px);
            memcpy(xy + 2 * k, views[i]->saddles[k].p_board, 2 * sizeof *xy);
        }
        s = sheen_camera_unproject(&p->camera, v, q_px, n, err);
        for (size_t k = 0; k < n && !s; k++) {
            const double z = v[3 * k + 2];
            v[2 * k] = v[3 * k] / z;
            v[2 * k + 1] = v[3 * k + 1] / z;
        }
        if (!s && !sheen_homography_fit(H, xy, v, n))
            s = sheen_fail(err, SHEEN_EDATA, "the corners in frame '%s' do not lie on a board",
                           views[i]->name);
        if (!s)
            s = seed_pose(p, i, H, board, views[i], err);
    }
    free(q_px);
    return s;
}

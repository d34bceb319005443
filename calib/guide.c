// SPDX-License-Identifier: Apache-2.0
// guide.c - tries places and tilts of the board, and takes the one that promises the smallest uncertainty.
//
// A view with derivatives A by the lens and B by its own pose adds the information A'A - A'B (B'B)^-1 B'A about the
// lens. The lens's covariance with it is the inverse of the sum; over the image that gives an uncertainty
// (lens_grid.h), of which the largest counts.
#include "calib/guide.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "base/vec.h"
#include "calib/calibrate_problem.h"
#include "calib/cholesky.h"
#include "calib/lens_grid.h"

enum { PLACES = 9, TILTS = 5, SIZES = 2, MAX_LENS = 16, LEAST_CORNERS = 16 };

static const char *const place_words[PLACES] = {"at the upper left", "at the top",    "at the upper right",
                                                "at the left",       "in the middle", "at the right",
                                                "at the lower left", "at the bottom", "at the lower right"};
static const double tilt_rad = 0.6;
static const struct {
    const char *words;
    double about_x, about_y;
} tilts[TILTS] = {{"facing the camera", 0, 0},
                  {"its left edge towards the camera", 0, -1},
                  {"its right edge towards the camera", 0, 1},
                  {"its upper edge towards the camera", 1, 0},
                  {"its lower edge towards the camera", -1, 0}};
static const struct {
    const char *words;
    double share; // of the picture's width
} sizes[SIZES] = {{"half of the picture's width", 0.5}, {"most of the picture's width", 0.85}};

// Before there is a calibration: five views that make one.
static const char *const first_words[SHEEN_CALIBRATE_MIN_FRAMES] = {
    "hold the board in the middle, facing the camera, so that it fills most of the picture",
    "tilt the board: its left edge towards the camera, by a third of a right angle",
    "tilt the board: its right edge towards the camera", "tilt the board: its upper edge towards the camera",
    "tilt the board: its lower edge towards the camera"};

// Information of one corner, added to [lens, pose] x [lens, pose].
static sheen_status add_corner(double *N, const sheen_camera *camera, const double p_cam[3],
                               const double dq_dp[6], double noise_px, sheen_err *err)
{
    const size_t n_lens = (size_t)camera->n_intrinsics, n = n_lens + 6;
    double lens[2 * MAX_LENS], J[2][6], row[MAX_LENS + 6];
    const sheen_status s = sheen_lens_gradient(lens, camera, p_cam, err);
    sheen_motion_gradient(J, dq_dp, p_cam);
    for (size_t k = 0; k < 2 && !s; k++) {
        memcpy(row, lens + k * n_lens, n_lens * sizeof *row);
        memcpy(row + n_lens, J[k], sizeof J[k]);
        for (size_t a = 0; a < n; a++)
            for (size_t b = 0; b < n; b++)
                N[a * n + b] += row[a] * row[b] / (noise_px * noise_px);
    }
    return s;
}

// The lens's part of N with the pose eliminated, added to information[n_lens][n_lens]. False: no pose.
static bool eliminate_pose(double *information, const double *N, size_t n_lens)
{
    const size_t n = n_lens + 6;
    double P[36];
    for (size_t a = 0; a < 6; a++)
        for (size_t b = 0; b < 6; b++)
            P[6 * a + b] = N[(n_lens + a) * n + n_lens + b];
    if (!sheen_cholesky(P, 6))
        return false;
    for (size_t a = 0; a < n_lens; a++) {
        double y[6];
        for (size_t k = 0; k < 6; k++)
            y[k] = N[(n_lens + k) * n + a];
        sheen_cholesky_solve(y, P, 6);
        for (size_t b = 0; b < n_lens; b++) {
            double explained = 0;
            for (size_t k = 0; k < 6; k++)
                explained += N[b * n + n_lens + k] * y[k];
            information[b * n_lens + a] += N[b * n + a] - explained;
        }
    }
    return true;
}

// The board in the camera: its centre towards a ninth of the image, at the distance at which it has that size.
static bool candidate_pose(double rt_cam_board[6], const sheen_camera *camera, const sheen_board *board,
                           int i)
{
    const int place = i % PLACES, tilt = i / PLACES % TILTS, size = i / PLACES / TILTS;
    const double q[2] = {(0.2 + 0.3 * (place % 3)) * camera->width_px,
                         (0.2 + 0.3 * ((double)(place / 3))) * camera->height_px};
    const double width_m = board->square_m * board->n_cols;
    const double depth_m = camera->intrinsics[0] * width_m / (sizes[size].share * camera->width_px);
    double v[3];
    if (sheen_camera_unproject(camera, v, q, 1, NULL) || !(v[2] > 0))
        return false;
    // facing the camera: x to the right, y up in the picture, z towards it
    const double facing[6] = {acos(-1.0), 0, 0, 0, 0, 0};
    const double turn[6] = {tilt_rad * tilts[tilt].about_x, tilt_rad * tilts[tilt].about_y, 0, 0, 0, 0};
    sheen_rt_compose(rt_cam_board, turn, facing);
    for (int k = 0; k < 3; k++)
        rt_cam_board[3 + k] = v[k] / v[2] * depth_m;
    return true;
}

// The largest sigma over the image if the board were also seen at that pose; infinite where it would not be seen.
static double promised(const sheen_calibration *c, const sheen_board *board, const sheen_lens_grid *g,
                       const double *information, const double rt_cam_board[6])
{
    const size_t n_lens = g->n_lens, n = n_lens + 6;
    double N[(MAX_LENS + 6) * (MAX_LENS + 6)] = {0}, L[MAX_LENS * MAX_LENS], C[MAX_LENS * MAX_LENS];
    int n_seen = 0;
    sheen_Rt Rt;
    (void)n;
    sheen_Rt_from_rt(&Rt, rt_cam_board);
    for (size_t i = 0; i < board->n_corners; i++) {
        double p_cam[3], q[2], dq_dp[6];
        sheen_Rt_point(p_cam, &Rt, board->corners[i].p_board);
        if (!board->corners[i].printed || sheen_camera_project(&c->camera, q, dq_dp, p_cam, 1, NULL) ||
            !(q[0] > 8 && q[1] > 8 && q[0] < c->camera.width_px - 9 && q[1] < c->camera.height_px - 9))
            continue;
        if (add_corner(N, &c->camera, p_cam, dq_dp, c->noise_px, NULL))
            return INFINITY;
        n_seen++;
    }
    memcpy(L, information, n_lens * n_lens * sizeof *L);
    if (n_seen < LEAST_CORNERS || !eliminate_pose(L, N, n_lens) || !sheen_cholesky(L, (int)n_lens))
        return INFINITY;
    sheen_cholesky_invert(C, L, (int)n_lens);
    double worst = 0;
    for (size_t i = 0; i < g->n; i++)
        worst = fmax(worst, sheen_lens_grid_variance(g, i, C));
    return sqrt(worst / 2);
}

static double present(const sheen_lens_grid *g, const double *C)
{
    double worst = 0;
    for (size_t i = 0; i < g->n; i++)
        worst = fmax(worst, sheen_lens_grid_variance(g, i, C));
    return sqrt(worst / 2);
}

static void choose(sheen_guidance *out, const sheen_calibration *c, const sheen_board *board,
                   const sheen_lens_grid *g)
{
    const size_t n = g->n_lens;
    double L[MAX_LENS * MAX_LENS], information[MAX_LENS * MAX_LENS];
    memcpy(L, c->lens_covariance, n * n * sizeof *L);
    if (!sheen_cholesky(L, (int)n))
        return;
    sheen_cholesky_invert(information, L, (int)n);
    out->sigma_px = present(g, c->lens_covariance);
    out->expected_px = INFINITY;
    for (int i = 0; i < PLACES * TILTS * SIZES; i++) {
        double rt_cam_board[6];
        if (!candidate_pose(rt_cam_board, &c->camera, board, i))
            continue;
        const double sigma_px = promised(c, board, g, information, rt_cam_board);
        if (!(sigma_px < out->expected_px))
            continue;
        out->expected_px = sigma_px;
        memcpy(out->rt_cam_board, rt_cam_board, sizeof rt_cam_board);
        snprintf(out->words, sizeof out->words, "hold the board %s, %s, so that it fills %s",
                 place_words[i % PLACES], tilts[i / PLACES % TILTS].words, sizes[i / PLACES / TILTS].words);
    }
}

sheen_status sheen_guide_next(sheen_guidance *out, const sheen_board *board, const sheen_board_view *views,
                              size_t n, double accuracy_px, sheen_err *err)
{
    const sheen_calibrate_options options = {.lensmodel = "opencv8", .n_threads = 1};
    *out = (sheen_guidance){.sigma_px = (double)NAN, .expected_px = (double)NAN};
    snprintf(out->words, sizeof out->words, "%s", first_words[n % SHEEN_CALIBRATE_MIN_FRAMES]);
    sheen_calibration c;
    sheen_status s = sheen_calibrate(&c, board, views, n, &options, err);
    if (s)
        return s == SHEEN_EDATA ? SHEEN_OK : s;
    sheen_lens_grid *g = calloc(1, sizeof *g);
    s = g ? sheen_lens_grid_init(g, &c.camera, c.distance_m, NULL, NULL, err)
          : sheen_fail_memory(err, sizeof *g, "guidance");
    if (!s) {
        choose(out, &c, board, g);
        out->done = n >= SHEEN_GUIDE_MIN_FRAMES && c.tilt_rad > 0.5 && out->sigma_px <= accuracy_px;
    }
    if (g)
        sheen_lens_grid_release(g);
    free(g);
    sheen_calibration_release(&c);
    return s == SHEEN_EDATA ? SHEEN_OK : s;
}

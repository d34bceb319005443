// SPDX-License-Identifier: Apache-2.0
// calibrate_summary.c - residuals, coverage, tilt, warp, and one sentence about them.
#include "calib/calibrate_summary.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "base/vec.h"
#include "calib/calibrate_seed.h"

static int cell_of(double x, int n_pixels, int n_cells)
{
    const int i = (int)floor((x + 0.5) / n_pixels * n_cells);
    return i < 0 ? 0 : i >= n_cells ? n_cells - 1 : i;
}

// A frame's corners, outliers, rms; returns its sum of squared residuals.
static double summarise_frame(sheen_calibration *c, const sheen_problem *p, const sheen_board *board, int i,
                              sheen_calibration_frame *frame)
{
    const size_t n = (size_t)p->n_cols * (size_t)p->n_rows;
    const double *seen = p->observations + 3 * n * (size_t)i, *x = p->residuals_px + 2 * n * (size_t)i;
    double sum = 0;
    int n_inliers = 0;
    for (size_t k = 0; k < n; k++) {
        if (!(seen[3 * k + 2] > 0))
            continue;
        n_inliers++;
        sum += x[2 * k] * x[2 * k] + x[2 * k + 1] * x[2 * k + 1];
        c->cells[cell_of(seen[3 * k + 1], p->camera.height_px, SHEEN_COVERAGE_ROWS)]
                [cell_of(seen[3 * k], p->camera.width_px, SHEEN_COVERAGE_COLS)]++;
    }
    frame->used = true;
    frame->n_outliers = frame->n_corners - n_inliers;
    frame->rms_px = n_inliers ? sqrt(sum / (2 * n_inliers)) : (double)NAN;
    double rt_board_grid[6], rt_grid_board[6];
    sheen_rt_board_grid(rt_board_grid, board);
    sheen_rt_invert(rt_grid_board, rt_board_grid);
    sheen_rt_compose(frame->rt_cam_board, p->rt_cam_grid + 6 * (size_t)i, rt_grid_board);
    return sum;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Median distance, and the largest angle between two boards' normals. O(frames^2), which is a few hundred.
static void summarise_poses(sheen_calibration *c, const sheen_problem *p)
{
    double *distance = malloc((size_t)p->n_frames * sizeof *distance);
    double largest = 1;
    for (int i = 0; i < p->n_frames; i++) {
        sheen_Rt a, b;
        sheen_Rt_from_rt(&a, p->rt_cam_grid + 6 * (size_t)i);
        if (distance)
            distance[i] = sheen_norm(a.t);
        for (int k = 0; k < i; k++) {
            sheen_Rt_from_rt(&b, p->rt_cam_grid + 6 * (size_t)k);
            const double cosine = a.R[0][2] * b.R[0][2] + a.R[1][2] * b.R[1][2] + a.R[2][2] * b.R[2][2];
            largest = fmin(largest, cosine);
        }
    }
    c->tilt_rad = acos(fmax(-1, largest));
    c->distance_m = sheen_norm(p->rt_cam_grid + 3);
    if (distance) {
        qsort(distance, (size_t)p->n_frames, sizeof *distance, ascending);
        c->distance_m = distance[p->n_frames / 2];
    }
    free(distance);
}

void sheen_calibration_summarise(sheen_calibration *c, const sheen_problem *p, const sheen_board *board,
                                 const int *i_view)
{
    double sum = 0;
    c->camera = p->camera;
    c->n_used = p->n_frames;
    c->n_corners = c->n_outliers = 0;
    c->i_worst = i_view[0];
    memset(c->cells, 0, sizeof c->cells);
    for (int i = 0; i < p->n_frames; i++) {
        sheen_calibration_frame *frame = &c->frames[i_view[i]];
        sum += summarise_frame(c, p, board, i, frame);
        c->n_corners += frame->n_corners;
        c->n_outliers += frame->n_outliers;
        if (!(frame->rms_px <= c->frames[c->i_worst].rms_px))
            c->i_worst = i_view[i];
    }
    const int n_inliers = c->n_corners - c->n_outliers;
    c->rms_px = n_inliers ? sqrt(sum / (2 * n_inliers)) : (double)NAN;
    int n_filled = 0;
    for (int row = 0; row < SHEEN_COVERAGE_ROWS; row++)
        for (int col = 0; col < SHEEN_COVERAGE_COLS; col++)
            n_filled += c->cells[row][col] > 0;
    c->coverage = (double)n_filled / (SHEEN_COVERAGE_ROWS * SHEEN_COVERAGE_COLS);
    // the grid's z goes into the paper: what deflects along it lies behind
    for (int k = 0; k < 2; k++)
        c->warp_m[k] = -p->warp_m[k];
    summarise_poses(c, p);
}

// The side of the image whose cells hold the fewest corners.
static const char *emptiest_side(const sheen_calibration *c)
{
    int left = 0, right = 0, top = 0, bottom = 0;
    for (int row = 0; row < SHEEN_COVERAGE_ROWS; row++) {
        left += c->cells[row][0] > 0;
        right += c->cells[row][SHEEN_COVERAGE_COLS - 1] > 0;
    }
    for (int col = 0; col < SHEEN_COVERAGE_COLS; col++) {
        top += c->cells[0][col] > 0;
        bottom += c->cells[SHEEN_COVERAGE_ROWS - 1][col] > 0;
    }
    const double across = fmin(left, right) / SHEEN_COVERAGE_ROWS,
                 down = fmin(top, bottom) / SHEEN_COVERAGE_COLS;
    if (across < down)
        return left < right ? "left" : "right";
    return top < bottom ? "top" : "bottom";
}

void sheen_calibration_judge(sheen_calibration *c)
{
    char what[160] = "";
    const double outliers = c->n_corners ? (double)c->n_outliers / c->n_corners : 1;
    c->good = false;
    if (c->tilt_rad < 0.5)
        snprintf(what, sizeof what, "tilt the board more, by 30 degrees and more to each side");
    else if (!(c->rms_px <= 0.5))
        snprintf(what, sizeof what, "hold the board flat and still and focus on it; the worst frame is '%s'",
                 c->frames[c->i_worst].name);
    else if (outliers > 0.1)
        snprintf(what, sizeof what,
                 "%.0f %% of the corners do not fit: check that the printed board is the one in "
                 "its file",
                 100 * outliers);
    else if (c->coverage < 0.7)
        snprintf(what, sizeof what, "add frames with the board at the image's %s edge", emptiest_side(c));
    else if (c->n_used < 10)
        snprintf(what, sizeof what, "add frames, 10 and more in all");
    else if (!(c->sigma_worst_px <= 0.5) || (c->has_halves && !(c->halves.moved_rms_px <= 0.5)))
        snprintf(what, sizeof what, "add tilted frames that fill the image's corners");
    else
        c->good = true;
    if (c->good)
        snprintf(c->verdict, sizeof c->verdict,
                 "good: corners fit to %.2f px, and at the board's distance the lens is certain to %.2f px "
                 "everywhere",
                 c->rms_px, c->sigma_worst_px);
    else
        snprintf(c->verdict, sizeof c->verdict, "usable with care (corners fit to %.2f px): %s", c->rms_px,
                 what);
}

// SPDX-License-Identifier: Apache-2.0
// calibrate_summary.c - residuals, coverage, tilt, warp, and one sentence about them.
#include "calib/calibrate_summary.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/order.h"
#include "base/pose3.h"
#include "base/vec.h"
#include "calib/calibrate_seed.h"

// Far outside of what noise alone makes: neighbouring corners of a frame err alike, so that some pattern is usual.
static const double MOST_PATTERN = 5, MOST_DISAGREEMENT = 3;

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
        qsort(distance, (size_t)p->n_frames, sizeof *distance, sheen_ascending);
        c->distance_m = distance[p->n_frames / 2];
    }
    free(distance);
}

// The used frames' corners, inliers with their residuals; their places come from the views.
static sheen_status list_corners(sheen_calibration *c, const sheen_problem *p, const sheen_board_view *views,
                                 const int *i_view, sheen_err *err)
{
    size_t n = 0;
    free(c->corners);
    c->corners = calloc((size_t)c->n_corners + 1, sizeof *c->corners);
    if (!c->corners)
        return sheen_fail_memory(err, (double)c->n_corners * sizeof *c->corners, "corners");
    for (int i = 0; i < p->n_frames; i++) {
        const sheen_board_view *view = &views[i_view[i]];
        for (size_t k = 0; k < view->n_saddles; k++) {
            const sheen_saddle *saddle = &view->saddles[k];
            const size_t at = ((size_t)i * (size_t)p->n_rows + (size_t)(saddle->row - 1)) *
                                  (size_t)p->n_cols +
                              (size_t)(saddle->col - 1);
            c->corners[n++] = (sheen_calibration_corner){
                .i_frame = i_view[i],
                .row = saddle->row,
                .col = saddle->col,
                .q_px = {saddle->q_px[0], saddle->q_px[1]},
                .residual_px = {p->residuals_px[2 * at], p->residuals_px[2 * at + 1]},
                .outlier = !(p->observations[3 * at + 2] > 0)};
        }
    }
    return SHEEN_OK;
}

static void summarise_regions(sheen_calibration *c)
{
    double sum = 0, n_regions = 0;
    memset(c->regions, 0, sizeof c->regions);
    for (int i = 0; i < c->n_corners; i++) {
        const sheen_calibration_corner *corner = &c->corners[i];
        if (corner->outlier)
            continue;
        sheen_calibration_region *region =
            &c->regions[cell_of(corner->q_px[1], c->camera.height_px, SHEEN_COVERAGE_ROWS) *
                            SHEEN_COVERAGE_COLS +
                        cell_of(corner->q_px[0], c->camera.width_px, SHEEN_COVERAGE_COLS)];
        region->n++;
        for (int k = 0; k < 2; k++) {
            region->mean_px[k] += corner->residual_px[k];
            region->rms_px += corner->residual_px[k] * corner->residual_px[k];
        }
    }
    for (int i = 0; i < SHEEN_COVERAGE_ROWS * SHEEN_COVERAGE_COLS; i++) {
        sheen_calibration_region *region = &c->regions[i];
        if (!region->n)
            continue;
        region->rms_px = sqrt(region->rms_px / (2.0 * region->n));
        for (int k = 0; k < 2; k++) {
            region->mean_px[k] /= region->n;
            sum += region->n * region->mean_px[k] * region->mean_px[k] / (2 * c->noise_px * c->noise_px);
        }
        n_regions++;
    }
    c->pattern = sqrt(sum / fmax(1, n_regions));
}

// The noise of a corner: residuals of a fit are smaller by what its parameters took up.
static double noise_of(double rms_px, int n_inliers, const sheen_problem *p)
{
    const double n = 2.0 * n_inliers, free_n = n - (p->camera.n_intrinsics + 6.0 * p->n_frames + 2);
    return free_n > 0.1 * n ? rms_px * sqrt(n / free_n) : rms_px * sqrt(10);
}

sheen_status sheen_calibration_summarise(sheen_calibration *c, const sheen_problem *p,
                                         const sheen_calibrate_job *j, sheen_err *err)
{
    const sheen_board *board = j->board;
    const int *i_view = j->used;
    double sum = 0;
    c->camera = p->camera;
    c->board_cols = board->n_cols;
    c->board_rows = board->n_rows;
    c->square_m = board->square_m;
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
    c->noise_px = noise_of(c->rms_px, n_inliers, p);
    summarise_poses(c, p);
    const sheen_status s = list_corners(c, p, j->views, i_view, err);
    if (!s)
        summarise_regions(c);
    return s;
}

// How far along a row of the map, from the middle column on, the uncertainty stays within the limit.
static int reach(const sheen_calibration *c, int row, int step)
{
    int col = SHEEN_SIGMA_COLS / 2 - (step < 0);
    while (col >= 0 && col < SHEEN_SIGMA_COLS && c->sigma_px[row][col] <= SHEEN_VALID_SIGMA_PX)
        col += step;
    return step > 0 ? col : col + 1;
}

void sheen_calibration_bound(sheen_calibration *c)
{
    const double cell_px[2] = {(double)c->camera.width_px / SHEEN_SIGMA_COLS,
                               (double)c->camera.height_px / SHEEN_SIGMA_ROWS};
    int first = SHEEN_SIGMA_ROWS / 2, last = first, n_cells = 0;
    c->n_region = 0;
    c->valid_share = 0;
    while (first > 0 && reach(c, first - 1, 1) > reach(c, first - 1, -1))
        first--;
    while (last < SHEEN_SIGMA_ROWS && reach(c, last, 1) > reach(c, last, -1))
        last++;
    if (first >= last)
        return;
    for (int side = 0; side < 2; side++) // down the left edge, up the right one
        for (int i = 0; i < last - first; i++) {
            const int row = side ? last - 1 - i : first + i, col = reach(c, row, side ? 1 : -1);
            n_cells += side ? col : -col;
            for (int end = 0; end < 2; end++) {
                double *q = c->region_px[c->n_region++];
                q[0] = fmin(c->camera.width_px - 1, fmax(0, col * cell_px[0] - 0.5));
                q[1] = fmin(c->camera.height_px - 1, fmax(0, (row + (end != side)) * cell_px[1] - 0.5));
            }
        }
    memcpy(c->region_px[c->n_region++], c->region_px[0], sizeof c->region_px[0]);
    c->valid_share = (double)n_cells / (SHEEN_SIGMA_COLS * SHEEN_SIGMA_ROWS);
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

// What one would do next about it, or "" where nothing is amiss.
static void advise(char what[200], const sheen_calibration *c)
{
    const double outliers = c->n_corners ? (double)c->n_outliers / c->n_corners : 1;
    const char *worst = c->frames[c->i_worst].name;
    what[0] = 0;
    if (c->tilt_rad < 0.5)
        snprintf(what, 200, "tilt the board more, by 30 degrees and more to each side");
    else if (!(c->rms_px <= 0.5))
        snprintf(what, 200,
                 "hold the board flat and still (a rolling shutter bends what moves) and focus on it; the "
                 "worst frame is '%.60s'",
                 worst);
    else if (outliers > 0.03)
        snprintf(what, 200,
                 "%.0f %% of the corners do not fit: check that the printed board is the one in its file, "
                 "and look at '%.60s'",
                 100 * outliers, worst);
    else if (c->coverage < 0.7)
        snprintf(what, 200, "add frames with the board at the image's %s edge", emptiest_side(c));
    else if (c->n_used < 10)
        snprintf(what, 200, "add frames, 10 and more in all");
    else if (!(c->sigma_worst_px <= SHEEN_VALID_SIGMA_PX) ||
             (c->has_halves && !(c->halves.moved_rms_px <= 0.5)))
        snprintf(what, 200, "add tilted frames that fill the image's corners");
    else if (c->pattern > MOST_PATTERN)
        snprintf(what, 200, "residuals lean to one side by region: try --model auto, or a flatter board");
    else if (c->has_halves && c->normalised_error > MOST_DISAGREEMENT)
        snprintf(what, 200,
                 "halves of the frames disagree %.1f times more than noise explains: try --model auto; was "
                 "the focus changed, or the board bent, between frames?",
                 c->normalised_error);
}

void sheen_calibration_judge(sheen_calibration *c)
{
    char what[200];
    advise(what, c);
    c->good = !what[0];
    if (c->good)
        snprintf(c->verdict, sizeof c->verdict,
                 "good: corners fit to %.2f px, and at the board's distance the lens is certain to %.2f px "
                 "everywhere",
                 c->rms_px, c->sigma_worst_px);
    else
        snprintf(c->verdict, sizeof c->verdict, "usable with care (corners fit to %.2f px): %s", c->rms_px,
                 what);
}

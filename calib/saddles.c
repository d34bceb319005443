// SPDX-License-Identifier: Apache-2.0
// saddles.c - chessboard corners by way of the tags around them.
//
// For each printed corner: a homography from the tags within 1.7 squares predicts it to a fraction of a pixel
// (local, so that the lens hardly bends it); the refinement then works in a window that ends before the tags; a
// corner stays only where the four squares around it are as dark and bright as printed, and where nothing else is in
// its window. Tags give identity and place only: their own corners shrink inwards by tenths of a pixel under blur,
// saddles do not.
#include "calib/saddles.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/order.h"
#include "base/pose3.h"
#include "calib/homography.h"
#include "calib/saddle_polish.h"
#include "calib/saddle_refine.h"

enum { MAX_NEAR = 8, MIN_HALF_PX = 2, MAX_HALF_PX = 8, MIN_CONTRAST = 15 };

static const double NEAR_SQUARES = 1.7;
static const double ADJACENT_SQUARES = 0.8; // the tags of the corner's own two white squares
static const double WINDOW_OF_GAP = 0.9;
static const double ASYMMETRY_SIGMAS = 18; // of the mean square, beyond the frame's median
static const double LEAST_ASYMMETRY = 2.5; // grey values: less than that does no harm

typedef struct finder {
    const sheen_board_view *view;
    const uint8_t *grey;
    const sheen_board *board;
    double gap_m;     // from a corner to the tag in its white square, along each axis
    int white_parity; // (row + col) & 1 of white squares
} finder;

static void tag_centre(double centre[2], const sheen_tag_seen *tag)
{
    for (int k = 0; k < 2; k++)
        centre[k] = (tag->p_board[0][k] + tag->p_board[1][k] + tag->p_board[2][k] + tag->p_board[3][k]) / 4;
}

// The homography from the board to pixels around p_board; false where there are not enough tags.
static bool local_homography(double H[9], const finder *f, const double p_board[3])
{
    double xy[8 * MAX_NEAR], q[8 * MAX_NEAR];
    size_t n_near = 0, n_adjacent = 0;
    for (size_t i = 0; i < f->view->n_tags && n_near < MAX_NEAR; i++) {
        const sheen_tag_seen *tag = &f->view->tags[i];
        double centre[2];
        tag_centre(centre, tag);
        const double squares = hypot(centre[0] - p_board[0], centre[1] - p_board[1]) / f->board->square_m;
        if (squares > NEAR_SQUARES)
            continue;
        n_adjacent += squares < ADJACENT_SQUARES;
        for (size_t k = 0; k < 4; k++) {
            memcpy(xy + 8 * n_near + 2 * k, tag->p_board[k], 2 * sizeof *xy);
            memcpy(q + 8 * n_near + 2 * k, tag->q_px[k], 2 * sizeof *q);
        }
        n_near++;
    }
    if (n_near < 2 && !n_adjacent)
        return false;
    return sheen_homography_fit(H, xy, q, 4 * n_near);
}

static bool map_offset(double q_px[2], const double H[9], const double p_board[3], double dx_m, double dy_m)
{
    return sheen_homography_apply(q_px, H, (const double[2]){p_board[0] + dx_m, p_board[1] + dy_m});
}

// Half the side of the window around q_px: it ends before the nearest ink of the two tags (their corner and the
// two sides that meet there). 0 where that is too small to work with.
static int window_half(const finder *f, const double H[9], const sheen_board_corner *corner,
                       const double q_px[2])
{
    const double g = f->gap_m;
    double nearest = MAX_HALF_PX / WINDOW_OF_GAP;
    for (int dr = -1; dr <= 0; dr++)
        for (int dc = -1; dc <= 0; dc++) {
            if (((corner->row + dr + corner->col + dc) & 1) != f->white_parity)
                continue;
            const double sx = dc ? -1 : 1, sy = dr ? 1 : -1; // the board's y goes up the page, rows go down
            const double along[4] = {1, 1.5, 2, 3};
            for (int k = 0; k < 4; k++)
                for (int side = 0; side < 2; side++) {
                    double ink[2];
                    if (!map_offset(ink, H, corner->p_board, sx * g * (side ? 1 : along[k]),
                                    sy * g * (side ? along[k] : 1)))
                        return 0;
                    nearest = fmin(nearest, fmax(fabs(ink[0] - q_px[0]), fabs(ink[1] - q_px[1])));
                }
        }
    const int half = (int)(WINDOW_OF_GAP * nearest);
    return half < MIN_HALF_PX ? (nearest > MIN_HALF_PX ? MIN_HALF_PX : 0) : half;
}

static bool grey_at(double *out, const finder *f, const double q_px[2])
{
    const int width_px = f->view->width_px, height_px = f->view->height_px;
    if (!(q_px[0] >= 0 && q_px[1] >= 0 && q_px[0] < width_px - 1 && q_px[1] < height_px - 1))
        return false;
    const int x = (int)q_px[0], y = (int)q_px[1];
    const double a = q_px[0] - x, b = q_px[1] - y;
    const uint8_t *p = f->grey + (size_t)y * (size_t)width_px + (size_t)x;
    *out = (1 - b) * ((1 - a) * p[0] + a * p[1]) + b * ((1 - a) * p[width_px] + a * p[width_px + 1]);
    return true;
}

// True where the white quadrants are bright and the black ones dark, each pair alike: an object's edge or a
// highlight across the corner fails. *white_dn: the white ones' mean.
static bool looks_printed(double *white_dn, const finder *f, const double H[9],
                          const sheen_board_corner *corner, const double q_px[2])
{
    double predicted[2], low[2] = {256, 256}, high[2] = {-1, -1}; // [1]: white
    if (!map_offset(predicted, H, corner->p_board, 0, 0))
        return false;
    const double d = 0.55 * f->gap_m;
    for (int dr = -1; dr <= 0; dr++)
        for (int dc = -1; dc <= 0; dc++) {
            double q[2], value;
            if (!map_offset(q, H, corner->p_board, dc ? -d : d, dr ? d : -d))
                return false;
            q[0] += q_px[0] - predicted[0];
            q[1] += q_px[1] - predicted[1];
            if (!grey_at(&value, f, q))
                return false;
            const int white = ((corner->row + dr + corner->col + dc) & 1) == f->white_parity;
            low[white] = fmin(low[white], value);
            high[white] = fmax(high[white], value);
        }
    *white_dn = (low[1] + high[1]) / 2;
    const double contrast = (low[1] + high[1] - low[0] - high[0]) / 2;
    return contrast > MIN_CONTRAST && low[1] - high[0] > 0.5 * contrast;
}

// Half a turn's noise over that of the picture, for the corner's limit.
typedef struct symmetry {
    double asymmetry, n_pairs;
} symmetry;

// The corner near where H puts it, not further than gate_px.
static bool find_one(sheen_saddle *out, symmetry *sym, const finder *f, const sheen_board_corner *corner,
                     const double H[9], double gate_px)
{
    sheen_saddle_polished fine;
    double q[2], predicted[2], white_dn;
    if (!map_offset(predicted, H, corner->p_board, 0, 0))
        return false;
    memcpy(q, predicted, sizeof q);
    const int half = window_half(f, H, corner, q);
    if (!half || sheen_saddle_refine(q, f->grey, f->view->width_px, f->view->height_px, half, NULL))
        return false;
    if (!looks_printed(&white_dn, f, H, corner, q))
        return false;
    if (!sheen_saddle_polish(&fine, f->grey, f->view->width_px, f->view->height_px, q, half) ||
        hypot(fine.q_px[0] - predicted[0], fine.q_px[1] - predicted[1]) > gate_px)
        return false;
    *out = (sheen_saddle){
        .row = corner->row, .col = corner->col, .q_px = {fine.q_px[0], fine.q_px[1]}, .white_dn = white_dn};
    memcpy(out->p_board, corner->p_board, sizeof out->p_board);
    memcpy(out->covariance, fine.covariance, sizeof out->covariance);
    *sym = (symmetry){fine.asymmetry, fine.n_pairs};
    return true;
}

// True where there is something in the corner's window that does not belong to the board. Of n pairs of samples with noise
// of variance v the mean square is v (1 +- sqrt(2 / n)).
static bool is_disturbed(const symmetry *sym, const sheen_board_view *view)
{
    const double usual = fmax(LEAST_ASYMMETRY, view->noise_dn);
    return !(sym->asymmetry <= usual * sqrt(1 + ASYMMETRY_SIGMAS * sqrt(2 / sym->n_pairs)));
}

static void drop_disturbed(sheen_board_view *view, const symmetry *sym, double *scratch)
{
    const size_t n = view->n_saddles;
    for (size_t i = 0; i < n; i++)
        scratch[i] = sym[i].asymmetry;
    qsort(scratch, n, sizeof *scratch, sheen_ascending);
    view->noise_dn = n ? scratch[n / 2] : 0;
    view->n_saddles = 0;
    for (size_t i = 0; i < n; i++)
        if (!is_disturbed(&sym[i], view))
            view->saddles[view->n_saddles++] = view->saddles[i];
}

static finder finder_of(const sheen_board_view *view, const uint8_t *grey, const sheen_board *board)
{
    return (finder){.view = view,
                    .grey = grey,
                    .board = board,
                    .gap_m = (board->square_m - board->tag_side_m) / 2,
                    .white_parity = (board->tags[0].row + board->tags[0].col) & 1};
}

sheen_status sheen_saddles_find(sheen_board_view *view, const uint8_t *grey, const sheen_board *board,
                                sheen_err *err)
{
    view->n_saddles = 0;
    if (!view->n_tags || !board->n_tags)
        return SHEEN_OK;
    free(view->saddles);
    view->saddles = calloc(board->n_corners, sizeof *view->saddles);
    if (!view->saddles)
        return sheen_fail_memory(err, (double)board->n_corners * sizeof *view->saddles, "corners");
    symmetry *sym = calloc(board->n_corners + 1, sizeof *sym);
    double *scratch = calloc(board->n_corners + 1, sizeof *scratch);
    if (!sym || !scratch) {
        free(sym);
        free(scratch);
        return sheen_fail_memory(err, 3 * (double)board->n_corners * sizeof *scratch, "corners");
    }
    const finder f = finder_of(view, grey, board);
    for (size_t i = 0; i < board->n_corners; i++) {
        double H[9];
        const size_t n = view->n_saddles;
        if (board->corners[i].printed && local_homography(H, &f, board->corners[i].p_board) &&
            find_one(&view->saddles[n], &sym[n], &f, &board->corners[i], H, INFINITY))
            view->n_saddles++;
    }
    drop_disturbed(view, sym, scratch);
    free(sym);
    free(scratch);
    return SHEEN_OK;
}

// The homography from the board to pixels around p_board, by nine points' projections.
static bool projected_homography(double H[9], const sheen_camera *camera, const sheen_Rt *Rt_cam_board,
                                 const double p_board[3], double square_m)
{
    enum { N = 9 };
    double xy[2 * N], q[2 * N], p_cam[3 * N];
    for (int i = 0; i < N; i++) {
        const double p[3] = {p_board[0] + (i % 3 - 1) * square_m, p_board[1] + (i / 3 - 1) * square_m, 0};
        memcpy(xy + 2 * (size_t)i, p, 2 * sizeof *xy);
        sheen_Rt_point(p_cam + 3 * (size_t)i, Rt_cam_board, p);
        if (!(p_cam[3 * i + 2] > 0))
            return false;
    }
    return !sheen_camera_project(camera, q, NULL, p_cam, N, NULL) && sheen_homography_fit(H, xy, q, N);
}

static bool has_saddle(const sheen_board_view *view, const sheen_board_corner *corner)
{
    for (size_t i = 0; i < view->n_saddles; i++)
        if (view->saddles[i].row == corner->row && view->saddles[i].col == corner->col)
            return true;
    return false;
}

sheen_status sheen_saddles_search(sheen_board_view *view, const uint8_t *grey, const sheen_board *board,
                                  const sheen_camera *camera, const double rt_cam_board[6], double gate_px,
                                  sheen_err *err)
{
    const sheen_status s = sheen_camera_check(camera, err);
    if (s || !view->saddles || !board->n_tags)
        return s;
    const finder f = finder_of(view, grey, board);
    sheen_Rt Rt;
    sheen_Rt_from_rt(&Rt, rt_cam_board);
    for (size_t i = 0; i < board->n_corners; i++) {
        const sheen_board_corner *corner = &board->corners[i];
        double H[9];
        symmetry sym;
        if (corner->printed && !has_saddle(view, corner) &&
            projected_homography(H, camera, &Rt, corner->p_board, board->square_m) &&
            find_one(&view->saddles[view->n_saddles], &sym, &f, corner, H, gate_px) &&
            !is_disturbed(&sym, view))
            view->n_saddles++;
    }
    return SHEEN_OK;
}

// Gives each board's view the tags that are on it.
static sheen_status deal_tags(sheen_board_view *views, size_t n_boards, const sheen_tag_seen *tags,
                              size_t n_tags, sheen_err *err)
{
    for (size_t b = 0; b < n_boards; b++) {
        views[b].tags = calloc(n_tags + 1, sizeof *views[b].tags);
        if (!views[b].tags)
            return sheen_fail_memory(err, (double)n_tags * sizeof *tags, "tags");
        for (size_t i = 0; i < n_tags; i++)
            if (tags[i].i_board == (int)b)
                views[b].tags[views[b].n_tags++] = tags[i];
    }
    return SHEEN_OK;
}

sheen_status sheen_boards_observe(sheen_board_view *views, sheen_tag_detector *detector, const uint8_t *grey,
                                  int width_px, int height_px, const sheen_board_set *boards, sheen_err *err)
{
    sheen_tag_seen *tags;
    size_t n_tags;
    for (size_t b = 0; b < boards->n_boards; b++)
        views[b] = (sheen_board_view){.width_px = width_px, .height_px = height_px};
    sheen_status s = sheen_tags_detect(&tags, &n_tags, detector, grey, width_px, height_px, boards, err);
    if (!s)
        s = deal_tags(views, boards->n_boards, tags, n_tags, err);
    free(tags);
    for (size_t b = 0; b < boards->n_boards && !s; b++)
        s = sheen_saddles_find(&views[b], grey, &boards->boards[b], err);
    for (size_t b = 0; b < boards->n_boards && s; b++)
        sheen_board_view_release(&views[b]);
    return s;
}

sheen_status sheen_board_observe(sheen_board_view *view, sheen_tag_detector *detector, const uint8_t *grey,
                                 int width_px, int height_px, const sheen_board *board, sheen_err *err)
{
    sheen_board one = *board;
    const sheen_board_set set = {.boards = &one, .n_boards = 1};
    return sheen_boards_observe(view, detector, grey, width_px, height_px, &set, err);
}

// SPDX-License-Identifier: Apache-2.0
// steady.c - motion from view to view, and the width of edges.
//
// Across an edge blurred by a Gaussian of sigma the steepest slope is contrast / (sigma sqrt(2 pi)).
#include "calib/steady.h"
#include "base/order.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

enum { MAX_VALUES = 1024, LEAST_COMMON = 4, STEPS = 8 };

static const double STEP_PX = 0.5,
                    ALONG = 0.22; // of the way from one saddle to the next: before the tag begins
static const double LEAST_CONTRAST = 12, REACH = 0.11; // of a square: within the white rim

static double median(double *values, int n)
{
    if (!n)
        return (double)NAN;
    qsort(values, (size_t)n, sizeof *values, sheen_ascending);
    return values[n / 2];
}

double sheen_views_motion_px(const sheen_board_view *before, const sheen_board_view *now)
{
    double moved[MAX_VALUES];
    int n = 0;
    for (size_t i = 0, k = 0; i < before->n_saddles && k < now->n_saddles && n < MAX_VALUES;) {
        const sheen_saddle *a = &before->saddles[i], *b = &now->saddles[k];
        const int order = a->row != b->row ? a->row - b->row : a->col - b->col;
        if (!order)
            moved[n++] = hypot(a->q_px[0] - b->q_px[0], a->q_px[1] - b->q_px[1]);
        i += order <= 0;
        k += order >= 0;
    }
    if (n >= LEAST_COMMON)
        return median(moved, n);
    n = 0;
    for (size_t i = 0, k = 0; i < before->n_tags && k < now->n_tags && n < MAX_VALUES;) {
        const sheen_tag_seen *a = &before->tags[i], *b = &now->tags[k];
        const int order = (a->id > b->id) - (a->id < b->id);
        for (int corner = 0; !order && corner < 4 && n < MAX_VALUES; corner++)
            moved[n++] = hypot(a->q_px[corner][0] - b->q_px[corner][0],
                               a->q_px[corner][1] - b->q_px[corner][1]);
        i += order <= 0;
        k += order >= 0;
    }
    return median(moved, n);
}

static bool sample(double *out, const sheen_board_view *view, const uint8_t *grey, double x, double y)
{
    if (!(x >= 0 && y >= 0 && x < view->width_px - 1 && y < view->height_px - 1))
        return false;
    const int i = (int)x, k = (int)y;
    const double a = x - i, b = y - k;
    const uint8_t *p = grey + (size_t)k * (size_t)view->width_px + (size_t)i;
    *out = (1 - b) * ((1 - a) * p[0] + a * p[1]) +
           b * ((1 - a) * p[view->width_px] + a * p[view->width_px + 1]);
    return true;
}

// The edge's sigma where the line from saddle a to its neighbour b is crossed; NaN where it shows none.
static double edge_sigma(const sheen_board_view *view, const uint8_t *grey, const double a[2],
                         const double b[2])
{
    const double dx = b[0] - a[0], dy = b[1] - a[1], length = hypot(dx, dy);
    const double x = a[0] + ALONG * dx, y = a[1] + ALONG * dy, reach_px = fmax(2, REACH * length);
    const double nx = -dy / length, ny = dx / length;
    double values[2 * STEPS + 1] = {0}, low = 256, high = -1, steepest = 0;
    const int steps = (int)fmin(STEPS, reach_px / STEP_PX);
    for (int i = -steps; i <= steps; i++) {
        double *v = &values[i + steps];
        if (!sample(v, view, grey, x + i * STEP_PX * nx, y + i * STEP_PX * ny))
            return (double)NAN;
        low = fmin(low, *v);
        high = fmax(high, *v);
    }
    for (int i = 2; i <= 2 * steps; i++) // over a pixel
        steepest = fmax(steepest, fabs(values[i] - values[i - 2]) / (2 * STEP_PX));
    return high - low > LEAST_CONTRAST && length > 8 ? (high - low) / (steepest * sqrt(2 * acos(-1.0)))
                                                     : (double)NAN;
}

double sheen_view_blur_px(const sheen_board_view *view, const uint8_t *grey)
{
    double sigma[MAX_VALUES];
    int n = 0;
    for (size_t i = 0; i + 1 < view->n_saddles; i++)
        for (size_t k = i + 1; k < view->n_saddles && view->saddles[k].row <= view->saddles[i].row + 1; k++) {
            const sheen_saddle *a = &view->saddles[i], *b = &view->saddles[k];
            if (abs(a->row - b->row) + abs(a->col - b->col) != 1 || n >= MAX_VALUES)
                continue;
            const double value = edge_sigma(view, grey, a->q_px, b->q_px);
            if (isfinite(value))
                sigma[n++] = value;
        }
    return median(sigma, n);
}

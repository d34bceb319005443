// SPDX-License-Identifier: Apache-2.0
// stillness.c - motion from corners of tags, blur from their edges.
//
// Blur: across the middle part of each side of a tag's black border, profiles at right angles to it are read (one cell
// of the tag to either side is black within and white without) and averaged; the border's levels are the means of the
// profile's ends, and the width is the distance between its crossings of 10 % and 90 %. A profile that does not rise by a
// tenth of full scale says nothing. In the middle of the side, corners and their halos are far away.
#include "calib/stillness.h"

#include <math.h>
#include <stdlib.h>

enum { CELLS = 8, N_ALONG = 9, N_STEPS = 49, MAX_SAMPLES = 2048 }; // CELLS: of a tag36h11 with its border
static const double min_cell_px = 4, least_rise = 25.5;

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *x, size_t n)
{
    if (!n)
        return (double)NAN;
    qsort(x, n, sizeof *x, compare);
    return n % 2 ? x[n / 2] : 0.5 * (x[n / 2 - 1] + x[n / 2]);
}

double sheen_tags_motion_px(const sheen_tag_seen *before, size_t n_before, const sheen_tag_seen *after,
                            size_t n_after)
{
    double moved[MAX_SAMPLES];
    size_t n = 0;
    for (size_t i = 0, k = 0; i < n_before && k < n_after && n + 4 <= MAX_SAMPLES;) {
        if (before[i].id != after[k].id) {
            if (before[i].id < after[k].id)
                i++;
            else
                k++;
            continue;
        }
        for (int c = 0; c < 4; c++)
            moved[n++] = hypot(after[k].q_px[c][0] - before[i].q_px[c][0],
                               after[k].q_px[c][1] - before[i].q_px[c][1]);
        i++;
        k++;
    }
    return median(moved, n);
}

// Between pixels by bilinear interpolation; NaN outside of the picture.
static double grey_at(const uint8_t *grey, int width_px, int height_px, double x, double y)
{
    if (!(x >= 0 && y >= 0 && x < width_px - 1 && y < height_px - 1))
        return (double)NAN;
    const int x0 = (int)x, y0 = (int)y;
    const uint8_t *p = grey + (size_t)y0 * (size_t)width_px + x0;
    const double u = x - x0, v = y - y0;
    return (1 - v) * ((1 - u) * p[0] + u * p[1]) + v * ((1 - u) * p[width_px] + u * p[width_px + 1]);
}

// Where the rising profile crosses `level`, in steps; between the last sample below and the next.
static double crossing(const double profile[N_STEPS], double level)
{
    for (int i = N_STEPS / 2; i > 0; i--) // from the edge inward, for the low levels
        if (profile[i - 1] < level && profile[i] >= level)
            return i - 1 + (level - profile[i - 1]) / (profile[i] - profile[i - 1]);
    for (int i = N_STEPS / 2; i + 1 < N_STEPS; i++)
        if (profile[i] < level && profile[i + 1] >= level)
            return i + (level - profile[i]) / (profile[i + 1] - profile[i]);
    return (double)NAN;
}

static double mean(const double *x, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += x[i];
    return sum / n;
}

// 10 % to 90 % width of the side from corner a to corner b, `out` pointing out of the tag; NaN: cannot be told.
static double side_blur_px(const uint8_t *grey, int width_px, int height_px, const double a[2],
                           const double b[2], const double middle[2])
{
    const double along[2] = {b[0] - a[0], b[1] - a[1]}, length = hypot(along[0], along[1]);
    double out[2] = {along[1] / length, -along[0] / length};
    if (out[0] * (a[0] - middle[0]) + out[1] * (a[1] - middle[1]) < 0) {
        out[0] = -out[0];
        out[1] = -out[1];
    }
    if (!(length / CELLS >= min_cell_px))
        return (double)NAN;
    const double reach_px = 0.9 * length / CELLS, step_px = 2 * reach_px / (N_STEPS - 1);
    double profile[N_STEPS];
    for (int i = 0; i < N_STEPS; i++) {
        double sum = 0;
        for (int k = 0; k < N_ALONG; k++) {
            const double t = 0.3 + 0.4 * k / (N_ALONG - 1), s = i * step_px - reach_px;
            sum += grey_at(grey, width_px, height_px, a[0] + t * along[0] + s * out[0],
                           a[1] + t * along[1] + s * out[1]);
        }
        profile[i] = sum / N_ALONG;
    }
    const double black = mean(profile, N_STEPS / 8),
                 white = mean(profile + N_STEPS - N_STEPS / 8, N_STEPS / 8);
    if (!(white - black >= least_rise))
        return (double)NAN;
    return step_px * (crossing(profile, black + 0.9 * (white - black)) -
                      crossing(profile, black + 0.1 * (white - black)));
}

double sheen_tags_blur_px(const uint8_t *grey, int width_px, int height_px, const sheen_tag_seen *tags,
                          size_t n_tags)
{
    double widths[MAX_SAMPLES];
    size_t n = 0;
    for (size_t i = 0; i < n_tags; i++) {
        const double(*q)[2] = tags[i].q_px;
        const double middle[2] = {0.25 * (q[0][0] + q[1][0] + q[2][0] + q[3][0]),
                                  0.25 * (q[0][1] + q[1][1] + q[2][1] + q[3][1])};
        for (int k = 0; k < 4 && n < MAX_SAMPLES; k++) {
            const double width = side_blur_px(grey, width_px, height_px, q[k], q[(k + 1) % 4], middle);
            if (isfinite(width))
                widths[n++] = width;
        }
    }
    return median(widths, n);
}

// SPDX-License-Identifier: Apache-2.0
// outline_border.c - borders of masks and edges of pictures, along an outline's normal.
#include "pose/outline_border.h"

#include <math.h>

static const double STEP_PX = 0.5;
static const double MIN_EDGE = 0.04; // of brightness over two pixels, to be an edge at all

// Bilinear; NaN outside and where a neighbour is not known.
static double sample(const float *data, int width_px, int height_px, double x, double y)
{
    if (!(x >= 0 && y >= 0 && x <= width_px - 1 && y <= height_px - 1))
        return (double)NAN;
    const int i = x < width_px - 1 ? (int)x : width_px - 2, j = y < height_px - 1 ? (int)y : height_px - 2;
    const float *p = data + (size_t)j * (size_t)width_px + i, *q = p + width_px;
    const double u = x - i, v = y - j;
    if (!(p[0] >= 0 && p[1] >= 0 && q[0] >= 0 && q[1] >= 0))
        return (double)NAN;
    return (1 - v) * ((1 - u) * (double)p[0] + u * (double)p[1]) +
           v * ((1 - u) * (double)q[0] + u * (double)q[1]);
}

bool sheen_outline_find_border(double *distance_px, const sheen_outline_view *v,
                               const sheen_outline_sample *s, double reach_px)
{
    const int w = v->canvas.width_px, h = v->canvas.height_px;
    double before = sample(v->mask, w, h, s->q_px[0], s->q_px[1]);
    const double sign = before >= 0.5 ? 1 : -1;
    const int n_steps = (int)(reach_px / STEP_PX);
    for (int step = 1; step <= n_steps && isfinite(before); step++) {
        const double t = step * STEP_PX;
        const double now = sample(v->mask, w, h, s->q_px[0] + sign * t * s->n_px[0],
                                  s->q_px[1] + sign * t * s->n_px[1]);
        if (!isfinite(now))
            return false;
        if ((now >= 0.5) != (before >= 0.5)) {
            *distance_px = sign * (t - STEP_PX + STEP_PX * (0.5 - before) / (now - before));
            return true;
        }
        before = now;
    }
    return false;
}

bool sheen_outline_find_edge(double *distance_px, const sheen_outline_view *v, const sheen_outline_sample *s,
                             double reach_px)
{
    enum { MAX = 64 };
    double step[MAX], best = 0;
    const int n = (int)fmin(MAX / 2 - 1, reach_px / STEP_PX), w = v->canvas.width_px, h = v->canvas.height_px;
    int at = -1;
    if (!v->light)
        return false;
    for (int i = 0; i <= 2 * n; i++) {
        const double t = (i - n) * STEP_PX;
        const double out = sample(v->light, w, h, s->q_px[0] + (t + 1) * s->n_px[0],
                                  s->q_px[1] + (t + 1) * s->n_px[1]);
        const double in = sample(v->light, w, h, s->q_px[0] + (t - 1) * s->n_px[0],
                                 s->q_px[1] + (t - 1) * s->n_px[1]);
        step[i] = fabs(out - in);
        if (!isfinite(step[i]))
            return false;
        const double preferred = step[i] / (1 + t * t / (reach_px * reach_px));
        if (preferred > best) {
            best = preferred;
            at = i;
        }
    }
    if (at < 1 || at >= 2 * n || step[at] < MIN_EDGE || step[at] < step[at - 1] || step[at] < step[at + 1])
        return false;
    const double curve = step[at - 1] - 2 * step[at] + step[at + 1];
    const double peak = curve < 0 ? 0.5 * (step[at - 1] - step[at + 1]) / curve : 0;
    *distance_px = (at - n + peak) * STEP_PX;
    return true;
}

bool sheen_outline_mask_known(const sheen_outline_view *v, const sheen_outline_sample *s)
{
    return !isnan(sample(v->mask, v->canvas.width_px, v->canvas.height_px, s->q_px[0], s->q_px[1]));
}

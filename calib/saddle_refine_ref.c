// SPDX-License-Identifier: Apache-2.0
// saddle_refine_ref.c - the corner refinement in plain C: the slow twin of saddle_refine_opencv.cc.
#include <math.h>

#include "calib/saddle_refine.h"

static double bilinear(const uint8_t *grey, int width_px, double x, double y)
{
    const int x0 = (int)floor(x), y0 = (int)floor(y);
    const double a = x - x0, b = y - y0;
    const uint8_t *p = grey + (long)y0 * width_px + x0;
    return (1 - b) * ((1 - a) * p[0] + a * p[1]) + b * ((1 - a) * p[width_px] + a * p[width_px + 1]);
}

// One solution of sum w g g' (p - q) = 0 around q; the step from q, or false where the window is flat.
static int step(double d[2], const uint8_t *grey, int width_px, const double q[2], int half_px)
{
    double xx = 0, xy = 0, yy = 0, bx = 0, by = 0;
    for (int j = -half_px; j <= half_px; j++)
        for (int i = -half_px; i <= half_px; i++) {
            const double x = q[0] + i, y = q[1] + j;
            const double u = (double)i / half_px, v = (double)j / half_px;
            const double w = exp(-u * u - v * v);
            const double gx = bilinear(grey, width_px, x + 1, y) - bilinear(grey, width_px, x - 1, y);
            const double gy = bilinear(grey, width_px, x, y + 1) - bilinear(grey, width_px, x, y - 1);
            xx += w * gx * gx;
            xy += w * gx * gy;
            yy += w * gy * gy;
            bx += w * (gx * gx * i + gx * gy * j);
            by += w * (gx * gy * i + gy * gy * j);
        }
    const double det = xx * yy - xy * xy;
    if (!(det > 1e-12 * (xx + yy) * (xx + yy)))
        return 0;
    d[0] = (yy * bx - xy * by) / det;
    d[1] = (xx * by - xy * bx) / det;
    return 1;
}

sheen_status sheen_saddle_refine_ref(double q_px[2], const uint8_t *grey, int width_px, int height_px,
                                     int half_px, sheen_err *err)
{
    if (half_px < 1 || half_px > SHEEN_SADDLE_MAX_HALF_PX)
        return sheen_fail(err, SHEEN_EARG, "a window of %d px to each side is out of range", half_px);
    double q[2] = {q_px[0], q_px[1]};
    for (int round = 0; round < 40; round++) {
        const double margin = half_px + 3;
        if (!(q[0] >= margin && q[1] >= margin && q[0] <= width_px - 1 - margin &&
              q[1] <= height_px - 1 - margin))
            return sheen_fail(err, SHEEN_EDATA, "a corner lies at the edge of the picture");
        double d[2];
        if (!step(d, grey, width_px, q, half_px))
            return sheen_fail(err, SHEEN_EDATA, "a corner lies in a flat place");
        q[0] += d[0];
        q[1] += d[1];
        if (!(fabs(q[0] - q_px[0]) < half_px && fabs(q[1] - q_px[1]) < half_px))
            return sheen_fail(err, SHEEN_EDATA, "a corner ran out of its window");
        if (hypot(d[0], d[1]) < 1e-3)
            break;
    }
    q_px[0] = q[0];
    q_px[1] = q[1];
    return SHEEN_OK;
}

// SPDX-License-Identifier: Apache-2.0
// turntable_gain.c - what was asked of a turntable against what it did: a line through (asked, measured).
//
// Measured angles are known up to whole turns. They are brought beside the line of the better sign, the line is
// fitted, and both again until no angle changes its turn.
#include <math.h>
#include <stdlib.h>

#include "pose/turntable_axis.h"

enum { ROUNDS = 10 };

static const double PI = 3.14159265358979323846;
static const double MAX_BESIDE_RAD = 3.14159265358979323846 / 4;

static bool counts(const sheen_turntable *t, const double *asked_rad, size_t i)
{
    return t->views[i].used && isfinite(asked_rad[i]);
}

// Where view i lies, unwrapped beside the line offset + gain * asked.
static double beside(const sheen_turntable *t, size_t i, double line_rad)
{
    return line_rad + remainder(t->views[i].angle_rad - line_rad, 2 * PI);
}

// Least squares of measured = offset + gain * asked; false where all was asked alike.
static bool fit_line(sheen_turntable_gain *out, const sheen_turntable *t, const double *asked_rad)
{
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (size_t i = 0; i < t->n_views; i++) {
        if (!counts(t, asked_rad, i))
            continue;
        n++;
        x += asked_rad[i];
        y += beside(t, i, out->offset_rad + out->gain * asked_rad[i]);
    }
    x /= n;
    y /= n;
    for (size_t i = 0; i < t->n_views; i++) {
        if (!counts(t, asked_rad, i))
            continue;
        const double dx = asked_rad[i] - x;
        xx += dx * dx;
        xy += dx * (beside(t, i, out->offset_rad + out->gain * asked_rad[i]) - y);
    }
    if (!(n >= 3 && xx > 1e-6))
        return false;
    out->n = (size_t)n;
    out->gain = xy / xx;
    out->offset_rad = y - out->gain * x;
    out->sigma_gain = 1 / sqrt(xx); // of one radian; scaled by judge
    return true;
}

static void judge(sheen_turntable_gain *out, const sheen_turntable *t, const double *asked_rad)
{
    double sum = 0;
    out->worst_rad = 0;
    for (size_t i = 0; i < t->n_views; i++) {
        if (!counts(t, asked_rad, i))
            continue;
        const double d = remainder(t->views[i].angle_rad - out->offset_rad - out->gain * asked_rad[i],
                                   2 * PI);
        sum += d * d;
        if (fabs(d) >= fabs(out->worst_rad)) {
            out->worst_rad = d;
            out->i_worst = i;
        }
    }
    out->rms_rad = sqrt(sum / (double)out->n);
    out->sigma_gain *= sqrt(sum / fmax(1, (double)out->n - 2));
}

static bool try_sign(sheen_turntable_gain *out, const sheen_turntable *t, const double *asked_rad,
                     double sign)
{
    *out = (sheen_turntable_gain){.gain = sign};
    for (size_t i = 0; i < t->n_views; i++) // the line goes through the first of them
        if (counts(t, asked_rad, i)) {
            out->offset_rad = t->views[i].angle_rad - sign * asked_rad[i];
            break;
        }
    for (int round = 0; round < ROUNDS; round++)
        if (!fit_line(out, t, asked_rad))
            return false;
    judge(out, t, asked_rad);
    return true;
}

sheen_status sheen_turntable_compare(sheen_turntable_gain *out, const sheen_turntable *table,
                                     const double *asked_rad, sheen_err *err)
{
    sheen_turntable_gain forward, backward;
    if (!try_sign(&forward, table, asked_rad, 1) || !try_sign(&backward, table, asked_rad, -1))
        return sheen_fail(
            err, SHEEN_EDATA,
            "at least three views at different commanded angles are needed to judge a turntable");
    *out = backward.rms_rad < forward.rms_rad ? backward : forward;
    if (fabs(out->worst_rad) > MAX_BESIDE_RAD)
        return sheen_fail(
            err, SHEEN_EDATA,
            "the table's measured angles do not follow the commanded ones (%.1f degrees apart at "
            "view %zu)",
            fabs(out->worst_rad) * 180 / PI, out->i_worst);
    return SHEEN_OK;
}

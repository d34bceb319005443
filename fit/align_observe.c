// SPDX-License-Identifier: Apache-2.0
// align_observe.c - the photographs at the points, and how far they disagree there.
#include <math.h>
#include <stdlib.h>

#include "base/order.h"
#include "base/parallel.h"
#include "base/vec.h"
#include "fit/align_state.h"
#include "fit/robust.h"

enum { TAPS = 2 };

static const double tap_weight[2 * TAPS + 1] = {0.20189652, 0.67032005, 1, 0.67032005,
                                                0.20189652}; // exp(-0.4 i^2)

static const double least_scale = 0.003;

// Gaussian means and slopes of the photograph about q; false at clipped pixels and outside.
static int sample(sheen_align_observation *o, const sheen_align_state *st, const sheen_image *image,
                  const double q_px[2])
{
    double sum[3] = {0, 0, 0}, slope[3][2] = {{0}}, total = 0, second = 0;
    for (int j = -TAPS; j <= TAPS; j++)
        for (int i = -TAPS; i <= TAPS; i++) {
            float rgb[3];
            const double w = tap_weight[i + TAPS] * tap_weight[j + TAPS];
            if (!sheen_image_bilinear(rgb, image, q_px[0] + i * st->spacing_px, q_px[1] + j * st->spacing_px))
                return 0;
            total += w;
            second += w * i * i * st->spacing_px;
            for (int c = 0; c < 3; c++) {
                if (!((double)rgb[c] < st->white_lin))
                    return 0;
                sum[c] += w * (double)rgb[c];
                slope[c][0] += w * i * (double)rgb[c];
                slope[c][1] += w * j * (double)rgb[c];
            }
        }
    for (int c = 0; c < 3; c++) {
        o->rgb[c] = (float)(sum[c] / total);
        for (int k = 0; k < 2; k++)
            o->rgb_dq[c][k] = (float)(slope[c][k] / second);
    }
    return 1;
}

// dq / d(w, d) from dq / dp at p_cam.
static void set_motion(sheen_align_observation *o, const double dq_dp[6], const double p_cam[3],
                       const double centre_cam[3])
{
    double x[3];
    sheen_sub(x, p_cam, centre_cam);
    for (int r = 0; r < 2; r++) {
        double turned[3];
        sheen_cross(turned, x, dq_dp + 3 * r); // g . (w x x) = w . (x x g)
        for (int k = 0; k < 3; k++) {
            o->q_dx[r][k] = (float)turned[k];
            o->q_dx[r][3 + k] = (float)dq_dp[3 * r + k];
        }
    }
}

static void observe_points(void *self, size_t begin, size_t end)
{
    const sheen_align_state *st = self;
    const sheen_align_pose *v = &st->views[st->i_view];
    for (size_t i = begin; i < end; i++) {
        sheen_align_observation *o = sheen_align_at(st, st->i_view, i);
        o->valid = 0;
        if (i / 2 % st->stride || !st->points->seen[st->i_view * st->n_points + i])
            continue;
        double p_obj[3], p_cam[3], q_px[2], dq_dp[6];
        for (int k = 0; k < 3; k++)
            p_obj[k] = (double)st->points->p_obj[3 * i + (size_t)k];
        sheen_Rt_point(p_cam, &v->Rt_cam_obj, p_obj);
        if (sheen_camera_project(&st->photos->cam, q_px, dq_dp, p_cam, 1, NULL) || !(fabs(q_px[0]) < 1e6) ||
            !(fabs(q_px[1]) < 1e6) || !sample(o, st, &st->photos->photos[st->i_view].image, q_px))
            continue;
        set_motion(o, dq_dp, p_cam, v->centre_cam);
        o->valid = 1;
    }
}

// Looks every point up in every photograph by the present poses.
sheen_status sheen_align_observe(sheen_align_state *st, sheen_err *err)
{
    for (st->i_view = 0; st->i_view < st->n_views; st->i_view++) {
        const sheen_status s = sheen_progress_step(&st->o->progress, "poses and exposures", (int)st->i_view,
                                                   (int)st->n_views, err);
        if (s)
            return s;
        sheen_parallel_for(st->n_points, 512, st->o->n_threads, observe_points, st);
    }
    return SHEEN_OK;
}

static const double Y_of[3] = {0.2126, 0.7152, 0.0722};

// Luminances under the present gains.
static void apply_gains(const sheen_align_state *st)
{
    sheen_align_set_gains(st);
    for (size_t v = 0; v < st->n_views; v++)
        for (size_t i = 0; i < st->n_points; i++) {
            sheen_align_observation *o = sheen_align_at(st, v, i);
            if (!o->valid)
                continue;
            double y = -(double)sheen_luminance(st->points->predicted + 3 * (v * st->n_points + i));
            for (int c = 0; c < 3; c++)
                y += Y_of[c] * (double)o->rgb[c] * st->views[v].per_gain[c];
            o->y = (float)y;
        }
}

// The point's D by a reweighted mean that starts from the median; residuals and weights follow. Returns how many views see it.
static size_t settle_point(const sheen_align_state *st, size_t i)
{
    size_t n = 0;
    for (size_t v = 0; v < st->n_views; v++)
        if (sheen_align_at(st, v, i)->valid)
            st->scratch[n++] = (double)sheen_align_at(st, v, i)->y;
    if (n < 2)
        return n;
    qsort(st->scratch, n, sizeof *st->scratch, sheen_ascending);
    double mean = st->scratch[(n - 1) / 2]; // highlights only add
    for (int round = 0; round < 3; round++) {
        double sum = 0, total = 0;
        for (size_t v = 0; v < st->n_views; v++) {
            sheen_align_observation *o = sheen_align_at(st, v, i);
            if (!o->valid)
                continue;
            const double r = (double)o->y - mean;
            const double w = sheen_loss_weight(SHEEN_LOSS_LORENTZIAN, r, st->scale);
            o->residual = (float)r;
            o->weight = (float)w;
            sum += w * (double)o->y;
            total += w;
        }
        mean = sum / total;
    }
    return n;
}

// Weights and residuals of all points, and the robust scale of those of the parity in use.
double sheen_align_settle(const sheen_align_state *st)
{
    double *r = malloc((st->n_views * st->n_points + 1) * 2 * sizeof *r);
    size_t n = 0;
    if (!r)
        return st->scale;
    for (size_t i = 0; i < st->n_points; i++) {
        if (i / 2 % st->stride)
            continue;
        const size_t views = settle_point(st, i);
        for (size_t v = 0; v < st->n_views && views >= 2 && (int)(i % 2) == st->parity; v++)
            if (sheen_align_at(st, v, i)->valid) // n residuals about their own mean are small by (n - 1) / n
                r[n++] = (double)sheen_align_at(st, v, i)->residual *
                         sqrt((double)views / ((double)views - 1));
    }
    const double scale = sheen_robust_scale(r, n, r + n);
    free(r);
    return scale;
}

void sheen_align_measure(sheen_align_state *st)
{
    apply_gains(st);
    for (int i = 0; i < 2; i++) // a scale belongs to the weights that it made
        st->scale = fmax(least_scale, sheen_align_settle(st));
}

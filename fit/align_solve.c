// SPDX-License-Identifier: Apache-2.0
// align_solve.c - Gauss-Newton for all poses, and least squares for the gains, with every point's D eliminated.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "calib/cholesky.h"
#include "fit/align_state.h"

static const double Y_of[3] = {0.2126, 0.7152, 0.0722};

// Slope of an observation's luminance by its view's six numbers.
static void slope_of(double J[6], const sheen_align_observation *o, const double log_gain[3])
{
    double g[2] = {0, 0};
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 2; k++)
            g[k] += Y_of[c] * exp(-log_gain[c]) * (double)o->rgb_dq[c][k];
    for (int k = 0; k < 6; k++)
        J[k] = g[0] * (double)o->q_dx[0][k] + g[1] * (double)o->q_dx[1][k];
}

// Adds the point's part of the normal equations with D eliminated: J' W J - (J' w)(J' w)' / sum w.
static void add_point(sheen_align_state *st, size_t i, double (*J)[6], double *w)
{
    const size_t N = 6 * st->n_views;
    double total = 0;
    for (size_t v = 0; v < st->n_views; v++) {
        const sheen_align_observation *o = sheen_align_at(st, v, i);
        w[v] = o->valid ? (double)o->weight / (st->scale * st->scale) : 0;
        total += w[v];
        if (o->valid)
            slope_of(J[v], o, st->views[v].log_gain);
    }
    for (size_t v = 0; v < st->n_views; v++) {
        if (!(w[v] > 0))
            continue;
        const double r = (double)sheen_align_at(st, v, i)->residual;
        for (size_t a = 0; a < 6; a++) {
            double *row = st->A + (6 * v + a) * N;
            st->b[6 * v + a] -= w[v] * r * J[v][a];
            for (size_t b = 0; b <= a; b++)
                row[6 * v + b] += w[v] * J[v][a] * J[v][b];
            for (size_t u = 0; u <= v; u++)
                for (size_t b = 0; b < 6 && w[u] > 0 && 6 * u + b <= 6 * v + a; b++)
                    row[6 * u + b] -= w[v] * w[u] / total * J[v][a] * J[u][b];
        }
    }
}

// The mean residual of each point is 0 only up to the last reweighting: what is left of it is D's to take.
sheen_status sheen_align_equations(sheen_align_state *st, sheen_err *err)
{
    const size_t N = 6 * st->n_views;
    double(*J)[6] = calloc(st->n_views, sizeof *J), *w = calloc(st->n_views, sizeof *w);
    sheen_status s = SHEEN_OK;
    memset(st->A, 0, N * N * sizeof *st->A);
    memset(st->b, 0, N * sizeof *st->b);
    if (!J || !w)
        s = sheen_fail_memory(err, 60.0 * (double)st->n_views, "poses");
    for (size_t i = (size_t)st->parity; i < st->n_points && !s; i += 2)
        add_point(st, i, J, w);
    free(J);
    free(w);
    for (size_t v = 0; v < st->n_views; v++)
        for (size_t k = 0; k < 6; k++) {
            const double p = st->views[v].px_per[k] / st->views[v].prior_px;
            st->A[(6 * v + k) * (N + 1)] += p * p;
            st->b[6 * v + k] -= p * p * st->views[v].moved[k];
        }
    return s;
}

static void move_view(sheen_align_pose *v, const double step[6])
{
    const double w_zero[6] = {step[0], step[1], step[2], 0, 0, 0};
    sheen_Rt turn, out;
    sheen_Rt_from_rt(&turn, w_zero);
    double from_centre[3], turned[3];
    sheen_sub(from_centre, v->Rt_cam_obj.t, v->centre_cam);
    sheen_Rt_compose(&out, &turn, &v->Rt_cam_obj);
    sheen_Rt_direction(turned, &turn, from_centre);
    for (int k = 0; k < 3; k++) {
        out.t[k] = v->centre_cam[k] + turned[k] + step[3 + k];
        v->centre_cam[k] += step[3 + k];
    }
    v->Rt_cam_obj = out;
    for (int k = 0; k < 6; k++)
        v->moved[k] += step[k];
}

// One step for all poses; *step_px: its largest rms motion.
sheen_status sheen_align_move(sheen_align_state *st, double *step_px, sheen_err *err)
{
    sheen_status s = sheen_align_equations(st, err);
    const size_t N = 6 * st->n_views;
    *step_px = 0;
    if (s)
        return s;
    if (!sheen_cholesky(st->A, (int)N))
        return sheen_fail(err, SHEEN_EDATA, "the photographs' agreement does not determine their poses");
    sheen_cholesky_solve(st->b, st->A, (int)N);
    for (size_t v = 0; v < st->n_views; v++) {
        double px2 = 0;
        for (size_t k = 0; k < 6; k++)
            px2 += pow(st->b[6 * v + k] * st->views[v].px_per[k], 2);
        const double most_px = 3, shrink = px2 > most_px * most_px ? most_px / sqrt(px2) : 1;
        for (size_t k = 0; k < 6; k++)
            st->b[6 * v + k] *= shrink;
        move_view(&st->views[v], st->b + 6 * v);
        *step_px = fmax(*step_px, shrink * sqrt(px2));
    }
    return SHEEN_OK;
}

// z: a point's light in one photograph by the present gain; its weight; the same without what is predicted.
typedef struct lit_point {
    double z, weight, rest;
} lit_point;

static lit_point lit_at(const sheen_align_state *st, size_t view, size_t i, int c)
{
    const sheen_align_observation *o = sheen_align_at(st, view, i);
    if (!o->valid)
        return (lit_point){0, 0, 0};
    const double z = (double)o->rgb[c] * exp(-st->views[view].log_gain[c]);
    const double predicted = (double)st->points->predicted[3 * (view * st->n_points + i) + (size_t)c];
    return (lit_point){z, (double)o->weight / (st->scale * st->scale), z - predicted};
}

// A point's part of the normal equations of one channel's gains, its D eliminated.
static void add_gains(sheen_align_state *st, size_t i, int c)
{
    const size_t N = st->n_views;
    double total = 0, mean = 0;
    for (size_t v = 0; v < N; v++) {
        const lit_point p = lit_at(st, v, i, c);
        total += p.weight;
        mean += p.weight * p.rest;
    }
    for (size_t v = 0; v < N && total > 0; v++) {
        const lit_point p = lit_at(st, v, i, c);
        if (!(p.weight > 0))
            continue;
        st->b[v] += p.weight * p.z * (p.rest - mean / total);
        st->A[v * (N + 1)] += p.weight * p.z * p.z;
        for (size_t u = 0; u <= v; u++) {
            const lit_point q = lit_at(st, u, i, c);
            st->A[v * N + u] -= p.weight * q.weight / total * p.z * q.z;
        }
    }
}

// Gains of one channel: linear least squares for the logarithms' change.
static int solve_channel(sheen_align_state *st, int c)
{
    const size_t N = st->n_views;
    memset(st->A, 0, N * N * sizeof *st->A);
    memset(st->b, 0, N * sizeof *st->b);
    for (size_t i = (size_t)st->parity; i < st->n_points; i += 2)
        add_gains(st, i, c);
    // Their sum is held at 0: darkening all photographs together would lower every residual
    const double p = 1 / (st->prior_ev * log(2));
    double trace = 0;
    for (size_t v = 0; v < N; v++)
        trace += st->A[v * (N + 1)];
    for (size_t v = 0; v < N; v++) {
        for (size_t u = 0; u <= v; u++)
            st->A[v * N + u] += trace;
        st->A[v * (N + 1)] += p * p;
        st->b[v] -= p * p * st->views[v].log_gain[c];
    }
    if (!sheen_cholesky(st->A, (int)N))
        return 0;
    sheen_cholesky_solve(st->b, st->A, (int)N);
    for (size_t v = 0; v < N; v++)
        st->views[v].log_gain[c] += fmax(-0.5, fmin(0.5, st->b[v]));
    return 1;
}

// Their geometric mean is 1: the scale of light is nobody's to say.
void sheen_align_solve_gains(sheen_align_state *st)
{
    for (int c = 0; c < 3; c++) {
        double mean = 0;
        if (!solve_channel(st, c))
            continue;
        for (size_t v = 0; v < st->n_views; v++)
            mean += st->views[v].log_gain[c] / (double)st->n_views;
        for (size_t v = 0; v < st->n_views; v++)
            st->views[v].log_gain[c] -= mean;
    }
}

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
static void slope_of(double J[6], const sheen_align_observation *o, const double per_gain[3])
{
    double g[2] = {0, 0};
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 2; k++)
            g[k] += Y_of[c] * per_gain[c] * (double)o->rgb_dq[c][k];
    for (int k = 0; k < 6; k++)
        J[k] = g[0] * (double)o->q_dx[0][k] + g[1] * (double)o->q_dx[1][k];
}

// Adds the point's part of the normal equations with D eliminated: J' W J - (J' w)(J' w)' / sum w. Views that do not see it cost nothing.
static void add_point(sheen_align_state *st, size_t i, double (*J)[6], double *w, size_t *view)
{
    const size_t N = 6 * st->n_views;
    double total = 0;
    size_t n = 0;
    for (size_t v = 0; v < st->n_views; v++) {
        const sheen_align_observation *o = sheen_align_at(st, v, i);
        if (!o->valid || !(o->weight > 0))
            continue;
        w[n] = (double)o->weight / (st->scale * st->scale);
        total += w[n];
        slope_of(J[n], o, st->views[v].per_gain);
        view[n++] = v;
    }
    for (size_t k = 0; k < n; k++) {
        const size_t v = view[k];
        const double r = (double)sheen_align_at(st, v, i)->residual;
        for (size_t a = 0; a < 6; a++) {
            double *row = st->A + (6 * v + a) * N;
            const double along = w[k] * J[k][a];
            st->b[6 * v + a] -= along * r;
            for (size_t b = 0; b <= a; b++)
                row[6 * v + b] += along * J[k][b] * (1 - w[k] / total);
            for (size_t m = 0; m < k; m++)
                for (size_t b = 0; b < 6; b++)
                    row[6 * view[m] + b] -= along * w[m] / total * J[m][b];
        }
    }
}

// The mean residual of each point is 0 only up to the last reweighting: what is left of it is D's to take.
sheen_status sheen_align_equations(sheen_align_state *st, sheen_err *err)
{
    const size_t N = 6 * st->n_views;
    double(*J)[6] = calloc(st->n_views, sizeof *J), *w = calloc(st->n_views, sizeof *w);
    size_t *view = calloc(st->n_views, sizeof *view);
    sheen_status s = SHEEN_OK;
    memset(st->A, 0, N * N * sizeof *st->A);
    memset(st->b, 0, N * sizeof *st->b);
    sheen_align_set_gains(st);
    if (!J || !w || !view)
        s = sheen_fail_memory(err, 60.0 * (double)st->n_views, "poses");
    for (size_t i = (size_t)st->parity; i < st->n_points && !s; i += 2)
        add_point(st, i, J, w, view);
    free(J);
    free(w);
    free(view);
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
    const double z = (double)o->rgb[c] * st->views[view].per_gain[c];
    const double predicted = (double)st->points->predicted[3 * (view * st->n_points + i) + (size_t)c];
    return (lit_point){z, (double)o->weight / (st->scale * st->scale), z - predicted};
}

// A point's part of the normal equations of one channel's gains, its D eliminated. lit, view: room for all views.
static void add_gains(sheen_align_state *st, size_t i, int c, lit_point *lit, size_t *view)
{
    const size_t N = st->n_views;
    double total = 0, mean = 0;
    size_t n = 0;
    for (size_t v = 0; v < N; v++) {
        lit[n] = lit_at(st, v, i, c);
        if (!(lit[n].weight > 0))
            continue;
        total += lit[n].weight;
        mean += lit[n].weight * lit[n].rest;
        view[n++] = v;
    }
    for (size_t k = 0; k < n; k++) {
        const double along = lit[k].weight * lit[k].z;
        double *row = st->A + view[k] * N;
        st->b[view[k]] += along * (lit[k].rest - mean / total);
        row[view[k]] += along * lit[k].z;
        for (size_t m = 0; m <= k; m++)
            row[view[m]] -= along * lit[m].weight / total * lit[m].z;
    }
}

// Gains of one channel: linear least squares for the logarithms' change.
static int solve_channel(sheen_align_state *st, int c, lit_point *lit, size_t *view)
{
    const size_t N = st->n_views;
    memset(st->A, 0, N * N * sizeof *st->A);
    memset(st->b, 0, N * sizeof *st->b);
    for (size_t i = (size_t)st->parity; i < st->n_points; i += 2)
        add_gains(st, i, c, lit, view);
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
sheen_status sheen_align_solve_gains(sheen_align_state *st, sheen_err *err)
{
    lit_point *lit = malloc((st->n_views + 1) * sizeof *lit);
    size_t *view = malloc((st->n_views + 1) * sizeof *view);
    sheen_align_set_gains(st);
    for (int c = 0; c < 3 && lit && view; c++) {
        double mean = 0;
        if (!solve_channel(st, c, lit, view))
            continue;
        for (size_t v = 0; v < st->n_views; v++)
            mean += st->views[v].log_gain[c] / (double)st->n_views;
        for (size_t v = 0; v < st->n_views; v++)
            st->views[v].log_gain[c] -= mean;
    }
    const int had_room = lit && view;
    free(lit);
    free(view);
    return had_room ? SHEEN_OK : sheen_fail_memory(err, 32.0 * (double)st->n_views, "exposures");
}

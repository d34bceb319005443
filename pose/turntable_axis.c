// SPDX-License-Identifier: Apache-2.0
// turntable_axis.c - axis and angles by Gauss-Newton on the poses.
//
// Unknowns: axis direction a and a point c on it (2 + 2, across the axis), the pose B of the board at angle 0 (6),
// one angle a view. With Q = exp(angle a):   R = Q R_B,   t = Q (t_B - c) + c. Every angle belongs to one view, so
// that angles are eliminated first (Schur's complement) and 10 x 10 is left.
#include "pose/turntable_axis.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/order.h"
#include "base/pose3.h"
#include "base/vec.h"
#include "calib/cholesky.h"
#include "pose/pose_tangent.h"

enum { COMMON = 10, MAX_STEPS = 40, MAX_ROUNDS = 6 };

static const double PI = 3.14159265358979323846;
static const double UNKNOWN_SIGMA = 1e-3; // radians, metres: where a pose comes without covariance
static const double MIN_TURN_RAD = 0.02;  // of all views together: a degree and a bit
static const double MEDIAN_CHI2 = 4.35;   // of five degrees of freedom
static const double REJECT_MISFIT = 5;    // times the median view's
static const double FLOOR_MISFIT = 4;     // in standard deviations

typedef struct problem {
    const sheen_turntable_pose *poses;
    sheen_Rt *Rt; // measured
    double *P;    // [n][36] information
    size_t n, first;
    double a[3], c[3], e[2][3]; // axis, point, and two directions across the axis
    sheen_Rt B;
    sheen_turntable_view *views;
} problem;

static double wrap(double angle_rad)
{
    const double x = remainder(angle_rad, 2 * PI);
    return x <= -PI ? x + 2 * PI : x;
}

static void across(double e[2][3], const double a[3])
{
    const int k = fabs(a[0]) < fabs(a[1])   ? (fabs(a[0]) < fabs(a[2]) ? 0 : 2)
                  : fabs(a[1]) < fabs(a[2]) ? 1
                                            : 2;
    const double unit[3] = {k == 0, k == 1, k == 2};
    sheen_cross(e[0], a, unit);
    sheen_normalize(e[0]);
    sheen_cross(e[1], a, e[0]);
}

static void turn_about(sheen_Rt *Q, const double a[3], double angle_rad)
{
    sheen_Rt_from_rt(Q, (const double[6]){a[0] * angle_rad, a[1] * angle_rad, a[2] * angle_rad, 0, 0, 0});
}

// The board's pose after a turn; Q as used.
static void predict(sheen_Rt *out, sheen_Rt *Q, const problem *p, double angle_rad)
{
    double arm[3];
    turn_about(Q, p->a, angle_rad);
    sheen_Rt_compose(out, Q, &p->B);
    sheen_sub(arm, p->B.t, p->c);
    sheen_Rt_point(out->t, Q, arm);
    for (int i = 0; i < 3; i++)
        out->t[i] += p->c[i];
}

// d(w, d)/d(common unknowns) and /d(angle) of the predicted pose.
static void jacobian(double J[COMMON][6], double J_angle[6], const problem *p, const sheen_Rt *Q,
                     const sheen_Rt *predicted)
{
    double arm[3], turned_arm[3], v[3];
    memset(J, 0, COMMON * sizeof *J);
    sheen_sub(arm, p->B.t, p->c);
    sheen_sub(turned_arm, predicted->t, p->c);
    memcpy(J_angle, p->a, sizeof p->a);
    sheen_cross(J_angle + 3, p->a, turned_arm);
    for (int k = 0; k < 2; k++) {
        // the axis turned by e: Q' = exp(e) Q exp(-e)
        sheen_Rt_direction(v, Q, p->e[k]);
        sheen_sub(J[k], p->e[k], v);
        double by[3];
        sheen_cross(by, p->e[k], arm);
        sheen_Rt_direction(by, Q, by);
        sheen_cross(J[k] + 3, p->e[k], turned_arm);
        sheen_sub(J[k] + 3, J[k] + 3, by);
        // the axis moved along e
        sheen_sub(J[2 + k] + 3, p->e[k], v);
    }
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++)
            J[4 + k][i] = J[7 + k][3 + i] = Q->R[i][k];
}

typedef struct normal {
    double U[COMMON * COMMON], b[COMMON];
} normal;

static double product(const double a[6], const double P[36], const double b[6])
{
    return sheen_pose_product(a, P, b);
}

// One view's share of the reduced equations; its own part stays in views[i] for the step of its angle.
static void add_view(normal *eq, double *angle_rhs, const problem *p, size_t i)
{
    sheen_Rt predicted, Q;
    sheen_turntable_view *view = &p->views[i];
    const double *P = p->P + 36 * i;
    double e[6], J[COMMON][6], J_angle[6], W[COMMON];
    predict(&predicted, &Q, p, view->angle_rad);
    jacobian(J, J_angle, p, &Q, &predicted);
    sheen_pose_difference(e, &p->Rt[i], &predicted);
    view->misfit = sqrt(product(e, P, e) / 5);
    const double V = product(J_angle, P, J_angle), g = product(J_angle, P, e);
    const bool free_angle = i != p->first;
    for (int u = 0; u < COMMON; u++) {
        W[u] = product(J[u], P, J_angle);
        view->axis_gradient[u] = free_angle ? -W[u] / V : 0;
    }
    view->own_variance = free_angle ? 1 / V : 0;
    *angle_rhs = free_angle ? g / V : 0;
    if (!view->used)
        return;
    for (int u = 0; u < COMMON; u++) {
        eq->b[u] += product(J[u], P, e) - (free_angle ? W[u] * g / V : 0);
        for (int v = 0; v <= u; v++)
            eq->U[COMMON * u + v] += product(J[u], P, J[v]) - (free_angle ? W[u] * W[v] / V : 0);
    }
}

static void apply(problem *p, const double step[COMMON])
{
    double turn[6] = {0};
    for (int i = 0; i < 3; i++) {
        turn[i] = step[0] * p->e[0][i] + step[1] * p->e[1][i];
        p->c[i] += step[2] * p->e[0][i] + step[3] * p->e[1][i];
    }
    sheen_Rt R;
    sheen_Rt_from_rt(&R, turn);
    sheen_Rt_direction(p->a, &R, p->a);
    sheen_normalize(p->a);
    across(p->e, p->a);
    sheen_pose_move(&p->B, &p->B, step + 4);
}

// Gauss-Newton to the end; L of the reduced equations is left in eq->U.
static sheen_status optimise(problem *p, normal *eq, double *rhs, sheen_err *err)
{
    for (int round = 0; round < MAX_STEPS; round++) {
        memset(eq, 0, sizeof *eq);
        for (size_t i = 0; i < p->n; i++)
            add_view(eq, &rhs[i], p, i);
        if (!sheen_cholesky(eq->U, COMMON))
            return sheen_fail(err, SHEEN_EDATA, "the poses do not determine the turntable's axis");
        sheen_cholesky_solve(eq->b, eq->U, COMMON);
        double largest = 0;
        for (int u = 0; u < COMMON; u++)
            largest = fmax(largest, fabs(eq->b[u]));
        if (!isfinite(largest))
            break;
        for (size_t i = 0; i < p->n; i++) {
            double step = rhs[i];
            for (int u = 0; u < COMMON; u++)
                step += p->views[i].axis_gradient[u] * eq->b[u];
            p->views[i].angle_rad = wrap(p->views[i].angle_rad + step);
            largest = fmax(largest, fabs(step));
        }
        if (largest < 1e-11)
            return SHEEN_OK;
        apply(p, eq->b);
        if (largest < 1e-9 && round > 2)
            return SHEEN_OK;
    }
    return sheen_fail(err, SHEEN_EDATA, "the poses turn about no common axis");
}

// The direction about which all turns are: the largest eigenvector of the sum of their Rodrigues vectors' outer
// products, from each view to the next and to the first.
static bool start_axis(problem *p)
{
    double M[3][3] = {{0}}, wd[6];
    for (size_t i = 1; i < p->n; i++)
        for (int far = 0; far < 2; far++) {
            sheen_pose_difference(wd, &p->Rt[i], &p->Rt[far ? 0 : i - 1]);
            for (int u = 0; u < 3; u++)
                for (int v = 0; v < 3; v++)
                    M[u][v] += wd[u] * wd[v];
        }
    const double size = M[0][0] + M[1][1] + M[2][2];
    if (!(size > MIN_TURN_RAD * MIN_TURN_RAD))
        return false;
    for (int round = 0; round < 8; round++) { // squared again and again, only the largest is left
        double next[3][3], trace = 0;
        for (int u = 0; u < 3; u++)
            trace += M[u][u];
        for (int u = 0; u < 3; u++)
            for (int v = 0; v < 3; v++) {
                next[u][v] = 0;
                for (int k = 0; k < 3; k++)
                    next[u][v] += M[u][k] * M[k][v] / (trace * trace);
            }
        memcpy(M, next, sizeof M);
    }
    const int k = M[0][0] >= M[1][1] && M[0][0] >= M[2][2] ? 0 : M[1][1] >= M[2][2] ? 1 : 2;
    memcpy(p->a, M[k], sizeof p->a);
    sheen_normalize(p->a);
    // away from the board's back; a board that stands upright: up in the picture
    const double z[3] = {p->Rt[0].R[0][2], p->Rt[0].R[1][2], p->Rt[0].R[2][2]};
    const double up = fabs(sheen_dot(z, p->a)) > 0.1 ? sheen_dot(z, p->a) : -p->a[1];
    for (int i = 0; i < 3 && up < 0; i++)
        p->a[i] = -p->a[i];
    across(p->e, p->a);
    return true;
}

// Angles about that direction, and the point that stays in place: (I - Q) c = t - Q t_B, nearest to the board.
static bool start_rest(problem *p)
{
    double A[9] = {0}, b[3] = {0}, wd[6];
    p->B = p->Rt[p->first];
    for (size_t i = 0; i < p->n; i++) {
        sheen_Rt Q;
        double right[3];
        sheen_pose_difference(wd, &p->Rt[i], &p->B);
        p->views[i].angle_rad = i == p->first ? 0 : wrap(sheen_dot(wd, p->a));
        turn_about(&Q, p->a, p->views[i].angle_rad);
        sheen_Rt_direction(right, &Q, p->B.t);
        sheen_sub(right, p->Rt[i].t, right);
        for (int u = 0; u < 3; u++)
            for (int k = 0; k < 3; k++) {
                const double ku = (k == u) - Q.R[k][u];
                b[u] += ku * right[k];
                for (int v = 0; v < 3; v++)
                    A[3 * u + v] += ku * ((k == v) - Q.R[k][v]);
            }
    }
    const double along = sheen_dot(p->a, p->B.t);
    for (int u = 0; u < 3; u++) {
        b[u] += p->a[u] * along;
        for (int v = 0; v < 3; v++)
            A[3 * u + v] += p->a[u] * p->a[v];
    }
    if (!sheen_cholesky(A, 3))
        return false;
    sheen_cholesky_solve(b, A, 3);
    memcpy(p->c, b, sizeof p->c);
    return true;
}

// Leaves out the views that stand out; true where the choice changed. sorted[n] is scratch.
static bool choose_views(problem *p, double *sorted)
{
    for (size_t i = 0; i < p->n; i++)
        sorted[i] = p->views[i].misfit;
    qsort(sorted, p->n, sizeof *sorted, sheen_ascending);
    const double limit = fmax(FLOOR_MISFIT, REJECT_MISFIT * sorted[p->n / 2] / sqrt(MEDIAN_CHI2 / 5));
    bool changed = false;
    for (size_t i = 0; i < p->n; i++) {
        const bool use = p->views[i].misfit <= limit;
        changed = changed || use != p->views[i].used;
        p->views[i].used = use;
    }
    if (!p->views[p->first].used) { // angles count from a view that fits
        for (size_t i = 0; i < p->n; i++)
            if (p->views[i].used) {
                const double zero = p->views[i].angle_rad;
                sheen_Rt Q;
                predict(&p->B, &Q, p, zero);
                p->first = i;
                for (size_t k = 0; k < p->n; k++)
                    p->views[k].angle_rad = wrap(p->views[k].angle_rad - zero);
                break;
            }
    }
    return changed;
}

static size_t count_used(const problem *p)
{
    size_t n = 0;
    for (size_t i = 0; i < p->n; i++)
        n += p->views[i].used;
    return n;
}

static sheen_status solve(problem *p, normal *eq, double *scratch, sheen_err *err)
{
    if (p->n < SHEEN_TURNTABLE_MIN_VIEWS)
        return sheen_fail(err, SHEEN_EDATA,
                          "%zu poses do not determine a turntable's axis, at least %d are needed", p->n,
                          (int)SHEEN_TURNTABLE_MIN_VIEWS);
    if (!start_axis(p) || !start_rest(p))
        return sheen_fail(err, SHEEN_EDATA, "the board hardly turned: its axis cannot be told");
    for (int round = 0; round < MAX_ROUNDS; round++) {
        const sheen_status s = optimise(p, eq, scratch, err);
        if (s)
            return s;
        if (round + 1 == MAX_ROUNDS || !choose_views(p, scratch))
            break;
    }
    const size_t n_used = count_used(p);
    if (n_used < SHEEN_TURNTABLE_MIN_VIEWS || 2 * n_used < p->n)
        return sheen_fail(err, SHEEN_EDATA, "only %zu of %zu poses turn about a common axis", n_used, p->n);
    return SHEEN_OK;
}

static void table_frame(sheen_turntable *out, const problem *p)
{
    sheen_Rt table, inverse, board;
    double arm[3], x[3], y[3];
    sheen_sub(arm, p->B.t, p->c);
    const double along = sheen_dot(arm, p->a);
    for (int column = 0; column < 2; column++) { // the board's x, or its y where that is along the axis
        for (int i = 0; i < 3; i++)
            x[i] = p->B.R[i][column];
        const double k = sheen_dot(x, p->a);
        for (int i = 0; i < 3; i++)
            x[i] -= k * p->a[i];
        if (sheen_normalize(x) > 0.3)
            break;
    }
    sheen_cross(y, p->a, x);
    for (int i = 0; i < 3; i++) {
        table.R[i][0] = x[i];
        table.R[i][1] = y[i];
        table.R[i][2] = p->a[i];
        table.t[i] = p->c[i] + along * p->a[i];
    }
    sheen_Rt_invert(&inverse, &table);
    sheen_Rt_compose(&board, &inverse, &p->B);
    sheen_rt_from_Rt(out->rt_cam_table, &table);
    sheen_rt_from_Rt(out->rt_table_board, &board);
}

// The larger standard deviation of two unknowns, in whatever direction between them.
static double larger_sigma(const double *C, int i)
{
    const double a = C[COMMON * i + i], b = C[COMMON * i + i + 1], d = C[COMMON * (i + 1) + i + 1];
    return sqrt((a + d) / 2 + hypot((a - d) / 2, b));
}

static void finish(sheen_turntable *out, const problem *p, const normal *eq)
{
    double chi2 = 0;
    out->n_used = count_used(p);
    out->n_views = p->n;
    out->first = p->first;
    for (size_t i = 0; i < p->n; i++)
        chi2 += p->views[i].used ? 5 * p->views[i].misfit * p->views[i].misfit : 0;
    const double freedom = 5 * (double)out->n_used + 1 - COMMON;
    out->scatter = sqrt(chi2 / freedom);
    const double k = fmax(1, out->scatter * out->scatter);
    sheen_cholesky_invert(out->covariance, eq->U, COMMON);
    for (int u = 0; u < COMMON * COMMON; u++)
        out->covariance[u] *= k;
    for (size_t i = 0; i < p->n; i++)
        p->views[i].own_variance *= k;
    out->sigma_axis_rad = larger_sigma(out->covariance, 0);
    out->sigma_origin_m = larger_sigma(out->covariance, 2);
    table_frame(out, p);
    out->views = p->views;
    for (size_t i = 0; i < p->n; i++)
        sheen_turntable_step(NULL, &out->views[i].sigma_rad, out, p->first, i);
}

static sheen_status prepare(problem *p, const sheen_turntable_pose *poses, size_t n, sheen_err *err)
{
    *p = (problem){.poses = poses, .n = n};
    if (n > SHEEN_TURNTABLE_MAX_VIEWS)
        return sheen_fail(err, SHEEN_EARG, "%zu poses are too many for one turntable", n);
    p->Rt = calloc(n + 1, sizeof *p->Rt);
    p->P = calloc(n + 1, 36 * sizeof *p->P);
    p->views = calloc(n + 1, sizeof *p->views);
    if (!p->Rt || !p->P || !p->views)
        return sheen_fail_memory(err, (double)n * (double)sizeof(sheen_turntable_view),
                                 "a turntable's views");
    for (size_t i = 0; i < n; i++) {
        double sum = 0;
        for (int k = 0; k < 6; k++)
            sum += poses[i].rt_cam_board[k];
        if (!isfinite(sum))
            return sheen_fail(err, SHEEN_EARG, "pose %zu is not finite", i);
        sheen_Rt_from_rt(&p->Rt[i], poses[i].rt_cam_board);
        if (!sheen_pose_information(p->P + 36 * i, poses[i].rt_cam_board, poses[i].covariance))
            for (size_t k = 0; k < 6; k++)
                p->P[36 * i + 7 * k] = 1 / (UNKNOWN_SIGMA * UNKNOWN_SIGMA);
        p->views[i].used = true;
    }
    return SHEEN_OK;
}

sheen_status sheen_turntable_solve(sheen_turntable *out, const sheen_turntable_pose *poses, size_t n_poses,
                                   sheen_err *err)
{
    problem p;
    normal eq;
    *out = (sheen_turntable){0};
    double *scratch = NULL;
    sheen_status s = prepare(&p, poses, n_poses, err);
    if (!s && !(scratch = malloc((n_poses + 1) * sizeof *scratch)))
        s = sheen_fail_memory(err, (double)n_poses * sizeof *scratch, "a turntable's views");
    if (!s)
        s = solve(&p, &eq, scratch, err);
    if (!s)
        finish(out, &p, &eq);
    else
        free(p.views);
    free(scratch);
    free(p.Rt);
    free(p.P);
    return s;
}

void sheen_turntable_release(sheen_turntable *table)
{
    free(table->views);
    *table = (sheen_turntable){0};
}

void sheen_turntable_step(double *angle_rad, double *sigma_rad, const sheen_turntable *table, size_t i,
                          size_t j)
{
    const sheen_turntable_view *a = &table->views[i], *b = &table->views[j];
    double variance = i == j ? 0 : a->own_variance + b->own_variance;
    for (int u = 0; u < COMMON; u++)
        for (int v = 0; v < COMMON; v++)
            variance += (b->axis_gradient[u] - a->axis_gradient[u]) * table->covariance[COMMON * u + v] *
                        (b->axis_gradient[v] - a->axis_gradient[v]);
    if (angle_rad)
        *angle_rad = wrap(b->angle_rad - a->angle_rad);
    if (sigma_rad)
        *sigma_rad = sqrt(variance);
}

// SPDX-License-Identifier: Apache-2.0
// outline_fit.c - Gauss-Newton on distances from the outline to the masks' borders.
#include "pose/outline_fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/order.h"
#include "base/vec.h"
#include "calib/cholesky.h"

enum { N = SHEEN_OUTLINE_UNKNOWNS };

static const double STEP_PX = 0.5;
static const double MIN_SCALE_PX = 0.15; // of the weights: never sharper than this
static const double CORRELATION_PX = 8;  // a border's errors over this length go together
static const double MIN_EDGE = 0.04;     // of brightness over two pixels, to be an edge at all
static const double DAMPING = 1e-6;      // keeps what nothing determines where it is
static const double DONE_M = 3e-6;
static const double MEDIAN_TO_SIGMA = 1.4826;

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

// Distance along the normal to the mask's border: outwards from inside the mask, inwards from outside.
static bool find_border(double *distance_px, const sheen_outline_view *v, const sheen_outline_sample *s,
                        double reach_px)
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

// Distance to the steepest step of brightness, nearer ones being preferred.
static bool find_edge(double *distance_px, const sheen_outline_view *v, const sheen_outline_sample *s,
                      double reach_px)
{
    enum { MAX = 64 };
    double step[MAX], best = 0;
    const int n = (int)fmin(MAX / 2 - 1, reach_px / STEP_PX), w = v->canvas.width_px, h = v->canvas.height_px;
    int at = -1;
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

typedef struct residual {
    double distance_px, length_px, J[N];
} residual;

typedef struct residuals {
    residual *list;
    size_t n, capacity;
    double length_px; // of all outlines where the mask is known, border found or not
} residuals;

static sheen_status add_residual(residuals *all, const sheen_outline_sample *s, double distance_px,
                                 const double pivot_board[3], const sheen_outline_fit_options *o,
                                 sheen_err *err)
{
    if (all->n == all->capacity) {
        const size_t capacity = 2 * all->capacity + 1024;
        residual *grown = realloc(all->list, capacity * sizeof *grown);
        if (!grown)
            return sheen_fail_memory(err, (double)capacity * sizeof *grown, "outlines");
        all->list = grown;
        all->capacity = capacity;
    }
    residual *r = &all->list[all->n++];
    double arm[3], g[3];
    r->distance_px = distance_px;
    r->length_px = s->length_px;
    for (int c = 0; c < 3; c++)
        g[c] = s->n_px[0] * s->dq_dboard[c] + s->n_px[1] * s->dq_dboard[3 + c];
    sheen_sub(arm, s->p_board, pivot_board);
    sheen_cross(r->J, arm, g);
    memcpy(r->J + 3, g, sizeof g);
    r->J[6] = sheen_dot(arm, g);
    for (int k = 0; k < N; k++)
        r->J[k] = o->free[k] ? r->J[k] : 0;
    return SHEEN_OK;
}

static sheen_status collect(residuals *all, const sheen_outline_mesh *mesh, const sheen_placement *placement,
                            const sheen_outline_views *in, const double pivot_board[3],
                            const sheen_outline_fit_options *o, sheen_err *err)
{
    all->n = 0;
    all->length_px = 0;
    for (size_t v = 0; v < in->n_views; v++) {
        const sheen_outline_view *view = &in->views[v];
        sheen_outline *outline = &in->outlines[v];
        sheen_status s = sheen_outline_draw(outline, mesh, placement, &view->canvas, o->spacing_px, err);
        for (size_t i = 0; !s && i < outline->n_samples; i++) {
            const sheen_outline_sample *at = &outline->samples[i];
            double distance_px;
            if (isnan(sample(view->mask, view->canvas.width_px, view->canvas.height_px, at->q_px[0],
                             at->q_px[1])))
                continue;
            all->length_px += at->length_px;
            if (o->edges ? view->light && find_edge(&distance_px, view, at, o->reach_px)
                         : find_border(&distance_px, view, at, o->reach_px))
                s = add_residual(all, at, distance_px, pivot_board, o, err);
        }
        if (s)
            return s;
    }
    return SHEEN_OK;
}

// A robust standard deviation of the distances.
static sheen_status spread_px(double *out, const residuals *all, sheen_err *err)
{
    double *sorted = malloc((all->n + 1) * sizeof *sorted);
    if (!sorted)
        return sheen_fail_memory(err, (double)all->n * sizeof *sorted, "outlines");
    for (size_t i = 0; i < all->n; i++)
        sorted[i] = fabs(all->list[i].distance_px);
    qsort(sorted, all->n, sizeof *sorted, sheen_ascending);
    *out = fmax(MIN_SCALE_PX, all->n ? MEDIAN_TO_SIGMA * sorted[all->n / 2] : 0);
    free(sorted);
    return SHEEN_OK;
}

// The weighted equations; rms of what the weights hold on to.
static void normal_equations(double H[N * N], double b[N], double *rms_px, const residuals *all,
                             double sigma_px)
{
    double sum = 0, weights = 0;
    const double far2 = 9 * sigma_px * sigma_px;
    memset(H, 0, N * N * sizeof *H);
    memset(b, 0, N * sizeof *b);
    for (size_t i = 0; i < all->n; i++) {
        const residual *r = &all->list[i];
        const double k = far2 / (far2 + r->distance_px * r->distance_px), w = k * k * r->length_px;
        weights += w;
        sum += w * r->distance_px * r->distance_px;
        for (int u = 0; u < N; u++) {
            b[u] += w * r->J[u] * r->distance_px;
            for (int v = 0; v <= u; v++)
                H[N * u + v] += w * r->J[u] * r->J[v];
        }
    }
    *rms_px = sqrt(sum / fmax(weights, 1e-9));
}

// Solves for the step; what is not free, or hardly determined, stays.
static bool solve(double step[N], const double H[N * N], const double b[N], const bool is_free[N])
{
    double A[N * N];
    memcpy(A, H, sizeof A);
    for (int u = 0; u < N; u++)
        A[N * u + u] = is_free[u] ? A[N * u + u] * (1 + DAMPING) + 1e-9 : 1;
    memcpy(step, b, N * sizeof *step);
    if (!sheen_cholesky(A, N))
        return false;
    sheen_cholesky_solve(step, A, N);
    return true;
}

static double limit(double x, double most)
{
    return x > most ? most : x < -most ? -most : x;
}

// p' = c + exp(w) e^l (p - c) + d, applied to the placement; returns how far it moves a point at the pivot's height.
static double apply(sheen_placement *placement, double step[N], const double pivot_board[3], double radius_m)
{
    sheen_Rt turn;
    double arm[3];
    for (int k = 0; k < 3; k++) {
        step[k] = limit(step[k], 0.3);
        step[3 + k] = limit(step[3 + k], radius_m);
    }
    step[6] = limit(step[6], 0.2);
    sheen_Rt_from_rt(&turn, (const double[6]){step[0], step[1], step[2], 0, 0, 0});
    sheen_sub(arm, placement->Rt_board_obj.t, pivot_board);
    sheen_Rt still = placement->Rt_board_obj;
    memset(still.t, 0, sizeof still.t);
    sheen_Rt_compose(&placement->Rt_board_obj, &turn, &still);
    sheen_Rt_direction(arm, &turn, arm);
    const double grow = exp(step[6]);
    for (int k = 0; k < 3; k++)
        placement->Rt_board_obj.t[k] = pivot_board[k] + grow * arm[k] + step[3 + k];
    placement->scale *= grow;
    return sheen_norm(step + 3) + radius_m * (sheen_norm(step) + fabs(step[6]));
}

static void pivot_of(double pivot_board[3], const sheen_placement *p, const double centre_obj[3],
                     bool on_board)
{
    double scaled[3];
    for (int k = 0; k < 3; k++)
        scaled[k] = p->scale * centre_obj[k];
    sheen_Rt_point(pivot_board, &p->Rt_board_obj, scaled);
    if (on_board)
        pivot_board[2] = 0;
}

// Half the longest side of the mesh, in board units.
static double radius_of(const sheen_outline_mesh *mesh, const sheen_placement *p, const double centre_obj[3])
{
    double r2 = 0;
    for (size_t i = 0; i < mesh->n_vertices; i++) {
        double d[3];
        for (size_t c = 0; c < 3; c++)
            d[c] = (double)mesh->p_obj[3 * i + c] - centre_obj[c];
        r2 = fmax(r2, sheen_dot(d, d));
    }
    return p->scale * sqrt(r2);
}

// Areas of cover and mask, where the mask is known.
static void compare_areas(sheen_outline_misfit *m, const sheen_outline_views *in, double length_px)
{
    double both = 0, either = 0, differ = 0;
    for (size_t v = 0; v < in->n_views; v++) {
        const size_t n = (size_t)in->views[v].canvas.width_px * (size_t)in->views[v].canvas.height_px;
        for (size_t i = 0; i < n; i++) {
            const double mask = (double)in->views[v].mask[i], cover = in->outlines[v].cover[i];
            if (!(mask >= 0))
                continue;
            both += mask * cover;
            either += mask > cover ? mask : cover;
            differ += mask > cover ? mask - cover : cover - mask;
        }
    }
    m->overlap = either > 0 ? both / either : 0;
    m->border_px = length_px > 0 ? differ / length_px : (double)INFINITY;
}

static void set_covariance(sheen_outline_misfit *m, const double H[N * N], const bool is_free[N])
{
    double A[N * N];
    memcpy(A, H, sizeof A);
    for (int u = 0; u < N; u++)
        A[N * u + u] += is_free[u] ? 1e-9 : 1;
    memset(m->covariance, 0, sizeof m->covariance);
    if (!sheen_cholesky(A, N)) {
        for (int u = 0; u < N; u++)
            m->covariance[N * u + u] = is_free[u] ? (double)INFINITY : 0;
        return;
    }
    sheen_cholesky_invert(m->covariance, A, N);
    for (int u = 0; u < N; u++)
        for (int v = 0; v < N; v++)
            m->covariance[N * u + v] *= is_free[u] && is_free[v] ? m->rms_px * m->rms_px * CORRELATION_PX : 0;
}

sheen_status sheen_outline_fit(sheen_placement *placement, sheen_outline_misfit *misfit,
                               const sheen_outline_mesh *mesh, const sheen_outline_views *views,
                               const double centre_obj[3], const sheen_outline_fit_options *options,
                               sheen_err *err)
{
    residuals all = {0};
    double H[N * N], b[N], step[N], pivot[3], sigma_px = 1;
    *misfit = (sheen_outline_misfit){.moved_m = INFINITY};
    const double radius_m = radius_of(mesh, placement, centre_obj);
    sheen_status s = SHEEN_OK;
    for (int round = 0; !s; round++) {
        pivot_of(pivot, placement, centre_obj, options->pivot_on_board);
        s = collect(&all, mesh, placement, views, pivot, options, err);
        if (!s && all.n < 2 * N)
            s = sheen_fail(err, SHEEN_EDATA, "the mesh's outline is nowhere near the masks");
        if (!s)
            s = spread_px(&sigma_px, &all, err);
        if (s)
            break;
        normal_equations(H, b, &misfit->rms_px, &all, sigma_px);
        if (round == options->max_steps || misfit->moved_m < DONE_M)
            break;
        if (!solve(step, H, b, options->free))
            break;
        misfit->moved_m = apply(placement, step, pivot, radius_m);
        if (!isfinite(misfit->moved_m) || !(placement->scale > 1e-9 && placement->scale < 1e9))
            s = sheen_fail(err, SHEEN_EDATA, "the mesh's outline leads away from the masks");
    }
    if (!s) {
        double found_px = 0;
        for (size_t i = 0; i < all.n; i++)
            found_px += all.list[i].length_px;
        misfit->found = all.length_px > 0 ? found_px / all.length_px : 0;
        compare_areas(misfit, views, all.length_px);
        set_covariance(misfit, H, options->free);
    }
    free(all.list);
    return s;
}

// SPDX-License-Identifier: Apache-2.0
// outline_fit.c - Gauss-Newton on distances from the outline to the masks' borders.
#include "pose/outline_fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/order.h"
#include "base/vec.h"
#include "calib/cholesky.h"
#include "pose/outline_border.h"
#include "pose/outline_residuals.h"

enum { N = SHEEN_OUTLINE_UNKNOWNS, MIN_GROUPS = 4, SECTORS = 8 };

static const double MIN_SCALE_PX = 0.15; // of the weights: never sharper than this
static const double OFFSET_PX = 1.5;     // masks are so much too wide or too narrow
static const double CORRELATION_PX = 8;  // of a border have one error: weighs what is expected of the offset
static const double DAMPING = 1e-6;      // keeps what nothing determines where it is
static const double DONE_M = 3e-6;
static const double MEDIAN_TO_SIGMA = 1.4826;

static sheen_status add_residual(sheen_outline_residuals *all, const sheen_outline_sample *s,
                                 double distance_px, size_t i_group, const double pivot_board[3],
                                 const sheen_outline_fit_options *o, sheen_err *err)
{
    if (all->n == all->capacity) {
        const size_t capacity = 2 * all->capacity + 1024;
        sheen_outline_residual *grown = realloc(all->list, capacity * sizeof *grown);
        if (!grown)
            return sheen_fail_memory(err, (double)capacity * sizeof *grown, "outlines");
        all->list = grown;
        all->capacity = capacity;
    }
    sheen_outline_residual *r = &all->list[all->n++];
    double arm[3], g[3];
    r->distance_px = distance_px;
    r->length_px = s->length_px;
    r->i_group = i_group;
    all->n_groups = i_group >= all->n_groups ? i_group + 1 : all->n_groups;
    for (int c = 0; c < 3; c++)
        g[c] = s->n_px[0] * s->dq_dboard[c] + s->n_px[1] * s->dq_dboard[3 + c];
    sheen_sub(arm, s->p_board, pivot_board);
    sheen_cross(r->J, arm, g);
    memcpy(r->J + 3, g, sizeof g);
    r->J[6] = sheen_dot(arm, g);
    r->J[7] = 1;
    for (int k = 0; k < N; k++)
        r->J[k] = o->free[k] ? r->J[k] : 0;
    return SHEEN_OK;
}

// Errors of a frame go together. Of few frames one looks at the sides of the outlines instead.
static size_t group_of(const sheen_outline_sample *s, size_t i_view, size_t n_views)
{
    return n_views >= MIN_GROUPS ? i_view
                                 : SECTORS * i_view + (s->n_px[0] > 0) + 2 * (size_t)(s->n_px[1] > 0) +
                                       4 * (size_t)(fabs(s->n_px[0]) > fabs(s->n_px[1]));
}

static sheen_status collect(sheen_outline_residuals *all, const sheen_outline_mesh *mesh,
                            const sheen_placement *placement, double offset_px, const sheen_outline_views *in,
                            const double pivot_board[3], const sheen_outline_fit_options *o, sheen_err *err)
{
    all->n = 0;
    all->length_px = 0;
    all->n_groups = 0;
    for (size_t v = 0; v < in->n_views; v++) {
        const sheen_outline_view *view = &in->views[v];
        sheen_outline *outline = &in->outlines[v];
        sheen_status s = sheen_outline_draw(outline, mesh, placement, &view->canvas, o->spacing_px, err);
        for (size_t i = 0; !s && i < outline->n_samples; i++) {
            const sheen_outline_sample *at = &outline->samples[i];
            double distance_px;
            if (!sheen_outline_mask_known(view, at))
                continue;
            all->length_px += at->length_px;
            if (o->edges ? sheen_outline_find_edge(&distance_px, view, at, o->reach_px)
                         : sheen_outline_find_border(&distance_px, view, at, o->reach_px))
                s = add_residual(all, at, distance_px - offset_px, group_of(at, v, in->n_views), pivot_board,
                                 o, err);
        }
        if (s)
            return s;
    }
    return SHEEN_OK;
}

// From a robust standard deviation of the distances.
static sheen_status set_weights(sheen_outline_residuals *all, sheen_err *err)
{
    double *sorted = malloc((all->n + 1) * sizeof *sorted);
    if (!sorted)
        return sheen_fail_memory(err, (double)all->n * sizeof *sorted, "outlines");
    for (size_t i = 0; i < all->n; i++)
        sorted[i] = fabs(all->list[i].distance_px);
    qsort(sorted, all->n, sizeof *sorted, sheen_ascending);
    const double sigma_px = fmax(MIN_SCALE_PX, all->n ? MEDIAN_TO_SIGMA * sorted[all->n / 2] : 0);
    free(sorted);
    all->far2_px2 = 9 * sigma_px * sigma_px;
    all->offset_sigma_px = OFFSET_PX;
    all->offset_weight = CORRELATION_PX * sigma_px * sigma_px / (OFFSET_PX * OFFSET_PX);
    return SHEEN_OK;
}

// The weighted equations; rms of what the weights hold on to.
static void normal_equations(double H[N * N], double b[N], sheen_outline_misfit *misfit,
                             const sheen_outline_residuals *all)
{
    double sum = 0, weights = 0;
    memset(H, 0, N * N * sizeof *H);
    memset(b, 0, N * sizeof *b);
    for (size_t i = 0; i < all->n; i++) {
        const sheen_outline_residual *r = &all->list[i];
        const double w = sheen_outline_weight(all, r);
        weights += w;
        sum += w * r->distance_px * r->distance_px;
        for (int u = 0; u < N; u++) {
            b[u] += w * r->J[u] * r->distance_px;
            for (int v = 0; v <= u; v++)
                H[N * u + v] += w * r->J[u] * r->J[v];
        }
    }
    H[N * N - 1] += all->offset_weight;
    b[SHEEN_OUTLINE_OFFSET] -= all->offset_weight * misfit->offset_px;
    misfit->rms_px = sqrt(sum / fmax(weights, 1e-9));
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

sheen_status sheen_outline_fit(sheen_placement *placement, sheen_outline_misfit *misfit,
                               const sheen_outline_mesh *mesh, const sheen_outline_views *views,
                               const double centre_obj[3], const sheen_outline_fit_options *options,
                               sheen_err *err)
{
    sheen_outline_residuals all = {0};
    double H[N * N], b[N], step[N], pivot[3];
    *misfit = (sheen_outline_misfit){.moved_m = INFINITY};
    const double radius_m = radius_of(mesh, placement, centre_obj);
    sheen_status s = SHEEN_OK;
    for (int round = 0; !s; round++) {
        pivot_of(pivot, placement, centre_obj, options->pivot_on_board);
        s = collect(&all, mesh, placement, misfit->offset_px, views, pivot, options, err);
        if (!s && all.n < 2 * N)
            s = sheen_fail(err, SHEEN_EDATA, "the mesh's outline is nowhere near the masks");
        if (!s)
            s = set_weights(&all, err);
        if (s)
            break;
        normal_equations(H, b, misfit, &all);
        if (round == options->max_steps || misfit->moved_m < DONE_M)
            break;
        if (!solve(step, H, b, options->free))
            break;
        misfit->moved_m = apply(placement, step, pivot, radius_m);
        misfit->offset_px += limit(step[7], 1);
        if (!isfinite(misfit->moved_m) || !(placement->scale > 1e-9 && placement->scale < 1e9))
            s = sheen_fail(err, SHEEN_EDATA, "the mesh's outline leads away from the masks");
    }
    if (!s) {
        double found_px = 0;
        for (size_t i = 0; i < all.n; i++)
            found_px += all.list[i].length_px;
        misfit->found = all.length_px > 0 ? found_px / all.length_px : 0;
        compare_areas(misfit, views, all.length_px);
        s = sheen_outline_covariance(misfit->covariance, H, &all, options->free, err);
    }
    free(all.list);
    return s;
}

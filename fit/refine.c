// SPDX-License-Identifier: Apache-2.0
// refine.c - section 4.3: sigma against (L_l, k_S) in turns, under the Lorentzian M-estimator, until both converge.
//
// The two halves of a turn:
//   * sigma: golden-section search of E over log(sigma), the lights held;
//   * (L_l, k_S): E over x_l = k_S omega L_l >= 0 by reweighted coordinate descent (nnls.c). k_S and L_l occur only as
//     this product, so they are one half, as in the paper; the gauge sum omega L = 1 separates them at the end.
// Turns alone creep along the valley in which a smaller sigma trades against wider lights. After every
// third one, sigma is therefore extrapolated by Aitken's delta-squared and the step is kept only if E falls.
#include "fit/refine.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fit/nnls.h"

// How far one sigma step may go, as a factor.
static const double max_step = 1.3;

typedef struct state {
    const sheen_samples *samples;
    const float *node_world;
    size_t n_nodes;
    sheen_refine_options o;
    sheen_light_matrix m;
    double *x, *x_before, *residual, *weight; // x[n_nodes] = k_S omega L_l
    double sigma_rad, scale, cost;
} state;

static void set_defaults(sheen_refine_options *o)
{
    if (!(o->sigma_tolerance > 0))
        o->sigma_tolerance = 1e-3;
    if (!(o->cost_tolerance > 0))
        o->cost_tolerance = 1e-4;
    if (o->max_turns <= 0)
        o->max_turns = 100;
    if (!(o->sigma_err_floor > 0))
        o->sigma_err_floor = 0.0015;
}

// Makes sure that the matrix reaches one step above sigma and not much further, and sets its values.
static sheen_status use_sigma(state *st, double sigma_rad, sheen_err *err)
{
    st->sigma_rad = sigma_rad;
    const double wanted = sigma_rad * max_step;
    if (!st->m.column_start || wanted > st->m.sigma_max_rad || wanted < 0.6 * st->m.sigma_max_rad) {
        sheen_light_matrix_release(&st->m);
        const sheen_status s = sheen_light_matrix_init(&st->m, st->samples, st->node_world, st->n_nodes,
                                                       wanted, st->o.n_threads, err);
        if (s)
            return s;
        if (st->o.hidden)
            sheen_light_matrix_hide(&st->m, st->node_world, st->o.hidden, st->o.hidden_self, st->o.n_threads);
    }
    sheen_light_matrix_set_sigma(&st->m, sigma_rad, st->o.n_threads);
    return SHEEN_OK;
}

static double cost_at(state *st, double sigma_rad)
{
    sheen_light_matrix_predict(&st->m, st->residual, st->x, sigma_rad);
    for (size_t s = 0; s < st->m.n_samples; s++)
        st->residual[s] = (double)st->samples->intensity[s] - st->residual[s];
    return sheen_loss_mean(st->o.loss, st->residual, st->m.n_samples, st->scale);
}

// Golden section over log(sigma) within one step of where it is.
static double search_sigma(state *st)
{
    const double golden = 0.6180339887498949;
    double lo = log(st->sigma_rad / max_step), hi = log(st->sigma_rad * max_step);
    double a = hi - golden * (hi - lo), b = lo + golden * (hi - lo);
    double cost_a = cost_at(st, exp(a)), cost_b = cost_at(st, exp(b));
    while (hi - lo > 0.3 * st->o.sigma_tolerance) {
        if (cost_a < cost_b) {
            hi = b;
            b = a;
            cost_b = cost_a;
            a = hi - golden * (hi - lo);
            cost_a = cost_at(st, exp(a));
        } else {
            lo = a;
            a = b;
            cost_a = cost_b;
            b = lo + golden * (hi - lo);
            cost_b = cost_at(st, exp(b));
        }
    }
    const double best = exp((lo + hi) / 2);
    return cost_at(st, best) < cost_at(st, st->sigma_rad) ? best : st->sigma_rad;
}

static void fit_lights(state *st, int max_rounds)
{
    const sheen_nnls_options o = {st->o.loss, st->scale, max_rounds, 4, 0.02 * st->o.cost_tolerance};
    st->cost = sheen_nnls(&st->m, st->samples->intensity, st->x, st->residual, st->weight, &o);
}

// Scale of the residuals that the present x and sigma leave. residual must be theirs.
static void measure_scale(state *st)
{
    const double scale = sheen_robust_scale(st->residual, st->m.n_samples, st->weight);
    st->scale = fmax(scale, st->o.sigma_err_floor);
}

// The initial hemisphere gives L_l up to a factor: the least-squares one starts k_S.
static void start_lights(state *st, const float *radiance0)
{
    for (size_t l = 0; l < st->n_nodes; l++)
        st->x[l] = (double)radiance0[l];
    sheen_light_matrix_predict(&st->m, st->residual, st->x, st->sigma_rad);
    double py = 0, pp = 0;
    for (size_t s = 0; s < st->m.n_samples; s++) {
        py += st->residual[s] * (double)st->samples->intensity[s];
        pp += st->residual[s] * st->residual[s];
    }
    const double k = pp > 0 && py > 0 ? py / pp : 0;
    for (size_t l = 0; l < st->n_nodes; l++)
        st->x[l] *= k;
    cost_at(st, st->sigma_rad);
    measure_scale(st);
}

static size_t count_lit(const state *st)
{
    size_t n = 0;
    for (size_t l = 0; l < st->n_nodes; l++)
        n += st->x[l] > 0;
    return n;
}

sheen_status sheen_refine_note(sheen_refine_result *out, const sheen_refine_turn *turn, sheen_err *err)
{
    sheen_refine_turn *grown = realloc(out->turns, (out->n_turns + 1) * sizeof *grown);
    if (!grown)
        return sheen_fail_memory(err, (double)((out->n_turns + 1) * sizeof *grown), "the fit's history");
    out->turns = grown;
    out->turns[out->n_turns++] = *turn;
    return SHEEN_OK;
}

static sheen_status note_turn(sheen_refine_result *out, const state *st, sheen_err *err)
{
    double k_s = 0;
    for (size_t l = 0; l < st->n_nodes; l++)
        k_s += st->x[l];
    const sheen_refine_turn turn = {st->sigma_rad, k_s, st->cost, count_lit(st)};
    return sheen_refine_note(out, &turn, err);
}

// Tries the limit that the last three sigmas head for, with the lights fitted to it. Keeps it if E is lower.
static sheen_status extrapolate(state *st, const sheen_refine_turn *last3, sheen_err *err)
{
    const double d1 = log(last3[1].sigma_rad / last3[0].sigma_rad),
                 d2 = log(last3[2].sigma_rad / last3[1].sigma_rad);
    if (d1 == d2 || d1 * d2 <= 0 || fabs(d2) >= fabs(d1))
        return SHEEN_OK;
    double further = -d2 * d2 / (d2 - d1);
    further = fmax(-log(max_step), fmin(log(max_step), further));
    const double sigma_before = st->sigma_rad, cost_before = st->cost;
    memcpy(st->x_before, st->x, st->n_nodes * sizeof *st->x);
    sheen_status s = use_sigma(st, sigma_before * exp(further), err);
    if (s)
        return s;
    fit_lights(st, 30);
    if (st->cost < cost_before)
        return SHEEN_OK;
    memcpy(st->x, st->x_before, st->n_nodes * sizeof *st->x);
    st->cost = cost_before;
    return use_sigma(st, sigma_before, err);
}

static sheen_status turn(state *st, sheen_refine_result *out, int i_turn, sheen_err *err)
{
    const double sigma_before = st->sigma_rad, cost_before = st->cost;
    sheen_status s = use_sigma(st, search_sigma(st), err);
    if (s)
        return s;
    fit_lights(st, 20);
    // The first turns change what an outlier is; then the scale stays, so that E compares between turns.
    const bool scale_settled = i_turn >= 5;
    if (!scale_settled) {
        measure_scale(st);
        st->cost = sheen_loss_mean(st->o.loss, st->residual, st->m.n_samples, st->scale);
    }
    if ((s = note_turn(out, st, err)))
        return s;
    out->converged = scale_settled && fabs(log(st->sigma_rad / sigma_before)) < st->o.sigma_tolerance &&
                     cost_before - st->cost < st->o.cost_tolerance * fabs(cost_before);
    if (!out->converged && scale_settled && out->n_turns % 3 == 0)
        s = extrapolate(st, out->turns + out->n_turns - 3, err);
    return s;
}

static sheen_status finish(sheen_refine_result *out, const state *st, double omega_sr, sheen_err *err)
{
    out->radiance = malloc((st->n_nodes + 1) * sizeof *out->radiance);
    if (!out->radiance)
        return sheen_fail_memory(err, 8.0 * (double)st->n_nodes, "lights");
    out->k_s = 0;
    for (size_t l = 0; l < st->n_nodes; l++)
        out->k_s += st->x[l];
    if (!(out->k_s > 0))
        return sheen_fail(err, SHEEN_EDATA,
                          "no light explains the highlights: check that mesh and poses belong "
                          "together");
    for (size_t l = 0; l < st->n_nodes; l++)
        out->radiance[l] = st->x[l] / (out->k_s * omega_sr);
    out->sigma_rad = st->sigma_rad;
    out->n_nodes_left = count_lit(st);
    out->sigma_err = st->scale;
    out->objective = st->cost;
    return SHEEN_OK;
}

static sheen_status allocate(state *st, sheen_err *err)
{
    st->x = malloc(st->n_nodes * sizeof *st->x);
    st->x_before = malloc(st->n_nodes * sizeof *st->x);
    st->residual = malloc(st->samples->count * sizeof *st->residual);
    st->weight = malloc(st->samples->count * sizeof *st->weight);
    if (!st->x || !st->x_before || !st->residual || !st->weight)
        return sheen_fail_memory(err, 16.0 * (double)(st->n_nodes + st->samples->count), "the fit");
    return SHEEN_OK;
}

sheen_status sheen_refine(sheen_refine_result *out, const sheen_samples *samples, const float *node_world,
                          const float *radiance0, size_t n_nodes, double omega_sr,
                          const sheen_refine_options *options, sheen_err *err)
{
    *out = (sheen_refine_result){0};
    if (!samples->count || !n_nodes)
        return sheen_fail(err, SHEEN_EDATA, "no highlight to estimate lights from");
    state st = {.samples = samples, .node_world = node_world, .n_nodes = n_nodes, .o = *options};
    set_defaults(&st.o);
    sheen_status s;
    if ((s = allocate(&st, err)) || (s = use_sigma(&st, st.o.sigma0_rad, err)))
        goto done;
    start_lights(&st, radiance0);
    fit_lights(&st, 20);
    measure_scale(&st);
    for (int i = 0; i < st.o.max_turns && !out->converged; i++)
        if ((s = sheen_progress_step(&st.o.progress, "lights and roughness", i, st.o.max_turns, err)) ||
            (s = turn(&st, out, i, err)))
            goto done;
    s = finish(out, &st, omega_sr, err);

done:
    sheen_light_matrix_release(&st.m);
    free(st.x);
    free(st.x_before);
    free(st.residual);
    free(st.weight);
    if (s)
        sheen_refine_result_release(out);
    return s;
}

void sheen_refine_result_release(sheen_refine_result *r)
{
    free(r->radiance);
    free(r->turns);
    *r = (sheen_refine_result){0};
}

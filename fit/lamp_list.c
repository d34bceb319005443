// SPDX-License-Identifier: Apache-2.0
// lamp_list.c - greedy births with a test, and a backward elimination.
#include "fit/lamp_list.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/image.h"
#include "base/vec.h"
#include "fit/lamp_start.h"
#include "fit/robust.h"

enum { MAX_BANS = 5, LAMP_PARAMETERS = 5 };
static const float lowest_sine = -0.05f, highest_nearness = 0.7f;
static const double worth_explaining = 0.2; // of what photographs left out are wrong by where a lamp shines
static const double scale_floor = 0.0015, scale_ceiling = 0.1;

typedef struct search {
    sheen_lamp_list *list;
    const sheen_lamp_samples *samples;
    sheen_lamp_list_options o;
    float *predicted, *trial; // [count]
    double *residual, *scratch;
    double *view_cost, *view_cost_trial; // [n_views]
    sheen_lamp_ban bans[MAX_BANS];
    size_t n_bans;
    sheen_geodesic geodesic;
} search;

static double residual_at(const search *q, const float *predicted, size_t i)
{
    return sheen_lamp_residual(&q->samples->at[i], (double)predicted[i]);
}

// Scale of what is not explained, over samples that are lit or said to be. A clipped one is a bound, whose residual is 0 wherever it
// holds: that says nothing of the noise.
static void measure_scale(search *q)
{
    size_t n = 0;
    for (size_t i = 0; i < q->samples->count; i++)
        if (!q->samples->at[i].clipped && (q->samples->at[i].lit || q->predicted[i] > q->o.threshold_lin))
            q->residual[n++] = residual_at(q, q->predicted, i);
    const double scale = sheen_robust_scale(q->residual, n, q->scratch);
    q->list->scale = fmin(scale_ceiling, fmax(scale_floor, scale));
    q->o.fit.scale = q->list->scale;
}

static double cost_by_view(double *by_view, const search *q, const float *predicted)
{
    double total = 0;
    memset(by_view, 0, q->samples->n_views * sizeof *by_view);
    for (size_t i = 0; i < q->samples->count; i++)
        by_view[q->samples->at[i].view] += (double)q->samples->at[i].weight *
                                           sheen_loss_rho(SHEEN_LOSS_LORENTZIAN, residual_at(q, predicted, i),
                                                          q->list->scale);
    for (size_t v = 0; v < q->samples->n_views; v++)
        total += by_view[v];
    return total;
}

static sheen_status predict(search *q, float *out, const sheen_lamp_list *list, sheen_err *err)
{
    return sheen_lamp_predict(out, list->lamps, list->n, &list->lobe, q->samples, &q->o.fit, err);
}

static sheen_status refine(search *q, sheen_lamp_list *list, int max_iterations, sheen_err *err)
{
    sheen_lamp_fit_options o = q->o.fit;
    o.max_iterations = max_iterations;
    sheen_lamp_fit_result result;
    const sheen_status s = sheen_lamp_fit(list->lamps, list->n, &list->lobe, q->samples, NULL, &o, &result,
                                          err);
    list->cost = result.cost;
    list->converged = result.converged;
    return s;
}

// What E must fall by for n parameters.
static double worth(const search *q, int n_parameters)
{
    return 0.5 * n_parameters * log((double)q->samples->count + 1);
}

// More views better than worse, by more than a change in the noise?
static int views_agree(const search *q)
{
    size_t better = 0, worse = 0;
    for (size_t v = 0; v < q->samples->n_views; v++) {
        const double gain = q->view_cost[v] - q->view_cost_trial[v];
        better += gain > 2;
        worse += gain < -2;
    }
    return better > worse;
}

// Of the lamps from `first` on: what each explains of photographs left out; all of it where there is no proof to ask.
static sheen_status measure_explained(double *explained, const search *q, const sheen_lamp_list *list,
                                      size_t first, sheen_err *err)
{
    for (size_t i = 0; i < list->n - first; i++)
        explained[i] = 1;
    return q->o.proof ? sheen_lamp_proof_explained(explained, q->o.proof, list->lamps, list->n, first,
                                                   &list->lobe, &q->o.fit, err)
                      : SHEEN_OK;
}

static void ban(search *q, const sheen_lamp *lamp)
{
    sheen_lamp_ban *b = &q->bans[q->n_bans++];
    memcpy(b->direction_world, lamp->direction_world, sizeof b->direction_world);
    b->cosine = cosf(3 * q->list->lobe.sigma_rad);
}

// E of the lamps there are.
static double alone_before(const search *q)
{
    return cost_by_view(q->view_cost, q, q->predicted);
}

// Still where it was found, and above the horizon? A lamp that wandered off explains something else.
static int stayed(const sheen_lamp *lamp, const sheen_lamp *start, const search *q)
{
    const float reach = 0.1f + 6 * q->list->lobe.sigma_rad + lamp->radius_rad;
    return sheen_dotf(lamp->direction_world, start->direction_world) > cosf(fminf(3, reach)) &&
           lamp->direction_world[2] > lowest_sine &&
           lamp->inverse_distance_per_m * q->samples->radius_m < highest_nearness;
}

// The hemisphere that new lamps are looked for on, for the lobe as it is now.
static sheen_status make_geodesic(search *q)
{
    const int frequency = sheen_lamp_start_frequency(q->list->lobe.sigma_rad);
    if (q->geodesic.frequency == frequency)
        return SHEEN_OK;
    sheen_geodesic_release(&q->geodesic);
    return sheen_geodesic_init(&q->geodesic, frequency, NULL);
}

// Tries one more lamp. *state: 1 it stayed, 0 it did not, -1 there is no candidate.
static sheen_status add_lamp(search *q, int *state, sheen_err *err)
{
    sheen_lamp_list trial = *q->list;
    sheen_lamp start;
    sheen_lamp_fit_result alone;
    for (size_t i = 0; i < q->samples->count; i++)
        q->trial[i] = (float)residual_at(q, q->predicted, i);
    if (make_geodesic(q))
        return sheen_fail_memory(err, 1e6, "spots of light");
    const sheen_lamp_start_options where = {q->list->lobe.sigma_rad, q->o.threshold_lin, q->bans, q->n_bans,
                                            q->o.fit.n_threads};
    *state = sheen_lamp_start(&start, &q->geodesic, q->samples, q->trial, &where);
    if (*state < 0)
        return sheen_fail_memory(err, 1e6, "spots of light");
    if (!*state) {
        *state = -1;
        return SHEEN_OK;
    }
    sheen_lamp_fit_options o = q->o.fit;
    o.max_iterations = 12;
    o.free_sigma = q->o.fit.free_sigma && trial.n == 0;
    o.free_radius = trial.n > 0;
    o.free_tail = o.free_fresnel = 0;
    trial.lamps[trial.n++] = start;
    sheen_status s = sheen_lamp_fit(&trial.lamps[trial.n - 1], 1, &trial.lobe, q->samples, q->predicted, &o,
                                    &alone, err);
    if (s)
        return s;
    if (alone_before(q) - alone.cost < worth(q, LAMP_PARAMETERS) ||
        !stayed(&trial.lamps[trial.n - 1], &start, q)) {
        *state = 0;
        ban(q, &start);
        return SHEEN_OK;
    }
    if ((s = refine(q, &trial, 3, err)) || (s = predict(q, q->trial, &trial, err)))
        return s;
    const double before = cost_by_view(q->view_cost, q, q->predicted),
                 after = cost_by_view(q->view_cost_trial, q, q->trial);
    double explained = 0;
    *state = before - after > 2 * worth(q, LAMP_PARAMETERS) && views_agree(q);
    if (*state && (s = measure_explained(&explained, q, &trial, trial.n - 1, err)))
        return s;
    if (!(explained > worth_explaining)) {
        *state = 0;
        ban(q, &start);
        return SHEEN_OK;
    }
    *q->list = trial;
    memcpy(q->predicted, q->trial, q->samples->count * sizeof *q->predicted);
    measure_scale(q);
    return SHEEN_OK;
}

static sheen_status find_lamps(search *q, sheen_err *err)
{
    const size_t most = q->o.max_lamps < SHEEN_LAMP_FIT_MAX ? q->o.max_lamps : SHEEN_LAMP_FIT_MAX;
    while (q->list->n < most && q->n_bans < MAX_BANS) {
        int state = 0;
        sheen_status s = sheen_progress_step(&q->o.progress, "lamps", (int)q->list->n, (int)most, err);
        if (s || (s = add_lamp(q, &state, err)))
            return s;
        if (state < 0)
            break;
    }
    return SHEEN_OK;
}

// One lamp for two: their sum, mean place, and extent.
static sheen_lamp joined(const sheen_lamp *a, const sheen_lamp *b)
{
    sheen_lamp out = {0};
    const float wa = sheen_luminance(a->rgb), wb = sheen_luminance(b->rgb), share = wa / (wa + wb + 1e-20f);
    float apart[3];
    sheen_subf(apart, a->direction_world, b->direction_world);
    for (int i = 0; i < 3; i++) {
        out.direction_world[i] = share * a->direction_world[i] + (1 - share) * b->direction_world[i];
        out.rgb[i] = a->rgb[i] + b->rgb[i];
    }
    sheen_normalizef(out.direction_world);
    out.inverse_distance_per_m = share * a->inverse_distance_per_m + (1 - share) * b->inverse_distance_per_m;
    // A disc's mean square extent along an axis is a quarter of its radius'
    const float spread2 = share * (1 - share) * sheen_dotf(apart, apart);
    out.radius_rad = sqrtf(share * a->radius_rad * a->radius_rad +
                           (1 - share) * b->radius_rad * b->radius_rad + 2 * spread2);
    return out;
}

static void remove_lamp(sheen_lamp_list *list, size_t i)
{
    memmove(&list->lamps[i], &list->lamps[i + 1], (list->n - i - 1) * sizeof *list->lamps);
    list->n--;
}

// E where n of a list's lamps are refined, all others and the lobe held.
static sheen_status cost_of_some(double *cost, search *q, const sheen_lamp_list *list, const size_t *which,
                                 size_t n, sheen_err *err)
{
    sheen_lamp_list others = *list;
    sheen_lamp lamps[SHEEN_LAMP_FIT_MAX];
    sheen_lamp_fit_options o = q->o.fit;
    sheen_lamp_fit_result result = {.cost = HUGE_VAL};
    o.max_iterations = 6;
    o.free_sigma = o.free_tail = o.free_fresnel = 0;
    for (size_t k = n; k-- > 0;) { // ascending: the last first
        lamps[k] = list->lamps[which[k]];
        remove_lamp(&others, which[k]);
    }
    sheen_status s = predict(q, q->trial, &others, err);
    if (!s)
        s = sheen_lamp_fit(lamps, n, &others.lobe, q->samples, q->trial, &o, &result, err);
    *cost = result.cost;
    return s;
}

// Takes `other`, in which the lamps `which` are new, for the list where E is then below `most`. What they reach by themselves is
// looked at first: where that is not within `far` of it, which is most often, all together would not come there either.
static sheen_status try_list(search *q, sheen_lamp_list *other, const size_t *which, size_t n, double most,
                             double far, int *kept, sheen_err *err)
{
    double cost;
    sheen_status s = cost_of_some(&cost, q, other, which, n, err);
    *kept = 0;
    if (s || cost > most + far || (s = refine(q, other, 5, err)))
        return s;
    *kept = other->cost < most;
    if (*kept)
        *q->list = *other;
    return SHEEN_OK;
}

static int is_too_near(const search *q, const sheen_lamp *lamp)
{
    return lamp->inverse_distance_per_m * q->samples->radius_m > highest_nearness;
}

static int is_out_of_place(const search *q, const sheen_lamp *lamp)
{
    return lamp->direction_world[2] < lowest_sine || is_too_near(q, lamp);
}

// What a wide light's shape asks for beyond a disc's, its distance gives where it can, until the lamp is in the object, from where all
// that it explains would go with it. From far it may explain nearly as much.
static sheen_status move_away(search *q, sheen_err *err)
{
    sheen_lamp_fit_options o = q->o.fit;
    sheen_lamp_fit_result result;
    int n_moved = 0;
    for (size_t i = 0; i < q->list->n; i++)
        if (is_too_near(q, &q->list->lamps[i])) {
            q->list->lamps[i].inverse_distance_per_m = 0;
            n_moved++;
        }
    if (!n_moved)
        return SHEEN_OK;
    o.free_distance = 0;
    o.max_iterations = 12;
    const sheen_status s = sheen_lamp_fit(q->list->lamps, q->list->n, &q->list->lobe, q->samples, NULL, &o,
                                          &result, err);
    q->list->cost = result.cost;
    q->list->converged = result.converged;
    return s;
}

// light: [count][n] of the lamps that there were. Takes lamp *i, whose light is in `column`, away where E hardly needs it; else goes
// on to the next.
static void remove_if_useless(search *q, const float *light, size_t n, size_t column, size_t *i)
{
    for (size_t k = 0; k < q->samples->count; k++)
        q->trial[k] = q->predicted[k] - light[k * n + column];
    const double loss = cost_by_view(q->view_cost_trial, q, q->trial) -
                        cost_by_view(q->view_cost, q, q->predicted);
    if (loss < worth(q, LAMP_PARAMETERS) || is_out_of_place(q, &q->list->lamps[*i])) {
        remove_lamp(q->list, *i);
        memcpy(q->predicted, q->trial, q->samples->count * sizeof *q->predicted);
    } else {
        (*i)++;
    }
}

// Lamps that wandered below the horizon or into the object, and those that E hardly needs, go.
static sheen_status remove_useless(search *q, sheen_err *err)
{
    const size_t n = q->list->n, count = q->samples->count;
    float *light = malloc((count * n + 1) * sizeof *light);
    sheen_status s = light ? sheen_lamp_light(light, q->list->lamps, n, &q->list->lobe, q->samples, &q->o.fit,
                                              err)
                           : sheen_fail_memory(err, 4.0 * (double)(count * n), "lamps");
    memset(q->predicted, 0, count * sizeof *q->predicted);
    for (size_t k = 0; k < count * n && !s; k++)
        q->predicted[k / n] += light[k];
    for (size_t column = 0, i = 0; column < n && !s; column++)
        remove_if_useless(q, light, n, column, &i);
    free(light);
    return s;
}

// Those that do not help to predict photographs left out go one at a time, the least first: of two for one light one has to stay.
static sheen_status remove_unproven(search *q, sheen_err *err)
{
    while (q->list->n) {
        double explained[SHEEN_LAMP_FIT_MAX];
        size_t least = 0;
        const sheen_status s = measure_explained(explained, q, q->list, 0, err);
        if (s)
            return s;
        for (size_t i = 1; i < q->list->n; i++)
            if (explained[i] < explained[least])
                least = i;
        if (explained[least] > worth_explaining)
            break;
        remove_lamp(q->list, least);
    }
    return SHEEN_OK;
}

static sheen_status prune(search *q, sheen_err *err)
{
    const size_t n = q->list->n;
    sheen_status s = remove_useless(q, err);
    if (!s)
        s = remove_unproven(q, err);
    return s || q->list->n == n || !q->list->n ? s : refine(q, q->list, 8, err);
}

static int close_together(const search *q, const sheen_lamp *a, const sheen_lamp *b)
{
    const float reach = 1.5f * q->list->lobe.sigma_rad + 0.5f * (a->radius_rad + b->radius_rad);
    return sheen_dotf(a->direction_world, b->direction_world) > cosf(fminf(3, reach));
}

static sheen_status join_neighbours(search *q, sheen_err *err)
{
    for (size_t a = 0; a < q->list->n; a++)
        for (size_t b = a + 1; b < q->list->n; b++) {
            int kept = 0;
            if (!close_together(q, &q->list->lamps[a], &q->list->lamps[b]))
                continue;
            sheen_lamp_list shorter = *q->list;
            shorter.lamps[a] = joined(&shorter.lamps[a], &shorter.lamps[b]);
            remove_lamp(&shorter, b);
            // E may rise by what the parameters that it saves are worth
            const double worth_one = worth(q, LAMP_PARAMETERS);
            const sheen_status s = try_list(q, &shorter, &a, 1, q->list->cost + worth_one, 6 * worth_one,
                                            &kept, err);
            if (s)
                return s;
            b -= (size_t)kept;
        }
    return SHEEN_OK;
}

// The four quarters of a wide lamp's disc.
static void quarter(sheen_lamp_list *list, size_t i)
{
    const sheen_lamp whole = list->lamps[i];
    const float up[3] = {0, 0, 1};
    float a[3], b[3];
    sheen_crossf(a, up, whole.direction_world);
    if (!(sheen_normalizef(a) > 0))
        a[0] = 1;
    sheen_crossf(b, whole.direction_world, a);
    for (int k = 0; k < 4; k++) {
        sheen_lamp *part = k ? &list->lamps[list->n++] : &list->lamps[i];
        *part = whole;
        for (int c = 0; c < 3; c++) {
            part->direction_world[c] += 0.5f * whole.radius_rad *
                                        ((k & 1 ? a[c] : -a[c]) + (k & 2 ? b[c] : -b[c]));
            part->rgb[c] = 0.25f * whole.rgb[c];
        }
        sheen_normalizef(part->direction_world);
        part->radius_rad = 0.5f * whole.radius_rad;
    }
}

// A wide lamp need not be round: where four discs explain it better by what their parameters are worth, they stay.
static sheen_status split_wide_lamps(search *q, sheen_err *err)
{
    const size_t n = q->list->n;
    for (size_t i = 0; i < n; i++) {
        int kept;
        sheen_lamp_list longer = *q->list;
        if (longer.lamps[i].radius_rad < 5 * longer.lobe.sigma_rad || longer.n + 3 > SHEEN_LAMP_FIT_MAX)
            continue;
        quarter(&longer, i);
        const size_t parts[4] = {i, longer.n - 3, longer.n - 2, longer.n - 1};
        const double worth_three = worth(q, 3 * LAMP_PARAMETERS);
        const sheen_status s = try_list(q, &longer, parts, 4, q->list->cost - worth_three, 2 * worth_three,
                                        &kept, err);
        if (s)
            return s;
    }
    return SHEEN_OK;
}

// Lamps narrower than the lobe are points where E hardly needs their widths: a width of its own takes from sigma what it adds, and
// photographs through one lobe from one height (a turntable's) cannot tell them apart.
static sheen_status try_points(search *q, sheen_err *err)
{
    sheen_lamp_list points = *q->list;
    sheen_lamp_fit_options fit = q->o.fit;
    sheen_lamp_fit_result result;
    int n_saved = 0;
    for (size_t i = 0; i < points.n; i++) {
        sheen_lamp *lamp = &points.lamps[i];
        if (!(lamp->radius_rad > 0) || lamp->radius_rad > points.lobe.sigma_rad)
            continue;
        lamp->radius_rad = 0;
        n_saved++;
    }
    if (!n_saved)
        return SHEEN_OK;
    fit.free_radius = 0;
    fit.max_iterations = 10;
    const sheen_status s = sheen_lamp_fit(points.lamps, points.n, &points.lobe, q->samples, NULL, &fit,
                                          &result, err);
    if (!s && result.cost < q->list->cost + worth(q, n_saved)) {
        *q->list = points;
        q->list->cost = result.cost;
    }
    return s;
}

static sheen_status run(search *q, sheen_err *err)
{
    sheen_status s = predict(q, q->predicted, q->list, err);
    if (s)
        return s;
    measure_scale(q);
    if (q->list->n) {
        if ((s = refine(q, q->list, 5, err)) || (s = predict(q, q->predicted, q->list, err)))
            return s;
        measure_scale(q);
    }
    if (q->o.find && (s = find_lamps(q, err)))
        return s;
    if (q->list->n) {
        if ((s = refine(q, q->list, q->o.last ? 25 : 8, err)) || (s = join_neighbours(q, err)) ||
            (s = split_wide_lamps(q, err)) || (s = move_away(q, err)) || (s = prune(q, err)) ||
            (q->o.last && (s = try_points(q, err))) ||
            (s = sheen_lamp_colours(q->list->lamps, q->list->n, &q->list->lobe, q->samples, &q->o.fit, err)))
            return s;
    }
    if ((s = predict(q, q->predicted, q->list, err)))
        return s;
    measure_scale(q);
    q->list->cost = cost_by_view(q->view_cost, q, q->predicted);
    memset(q->trial, 0, q->samples->count * sizeof *q->trial);
    q->list->dark_cost = cost_by_view(q->view_cost_trial, q, q->trial);
    return SHEEN_OK;
}

sheen_status sheen_lamp_list_fit(sheen_lamp_list *list, const sheen_lamp_samples *samples,
                                 const sheen_lamp_list_options *options, sheen_err *err)
{
    search q = {.list = list, .samples = samples, .o = *options};
    const size_t n = samples->count + 1;
    q.predicted = calloc(n, sizeof *q.predicted);
    q.trial = calloc(n, sizeof *q.trial);
    q.residual = calloc(n, sizeof *q.residual);
    q.scratch = calloc(n, sizeof *q.scratch);
    q.view_cost = calloc(samples->n_views + 1, sizeof *q.view_cost);
    q.view_cost_trial = calloc(samples->n_views + 1, sizeof *q.view_cost_trial);
    sheen_status s = q.predicted && q.trial && q.residual && q.scratch && q.view_cost && q.view_cost_trial
                         ? run(&q, err)
                         : sheen_fail_memory(err, 24.0 * (double)n, "samples");
    sheen_geodesic_release(&q.geodesic);
    free(q.predicted);
    free(q.trial);
    free(q.residual);
    free(q.scratch);
    free(q.view_cost);
    free(q.view_cost_trial);
    return s;
}

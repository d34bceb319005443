// SPDX-License-Identifier: Apache-2.0
// align_proof.c - may refined poses and gains be believed?
//
// Photographs can be made to agree on a mesh that is off, or under highlights wider than the paint's detail, by sliding them over the
// surface: points left out then agree as well as those used. What is refined has to earn it. Where it is better, photographs come to agree
// far better than before, while one that is left as it was given is predicted by the others about as well as it was: its own error is
// then the only one between them. The product of both ratios tells.
//
// Poses: exact scenes with poses 0.75 to 2 px off have 0.25 to 0.71; true poses under lobes of 0.1 rad 1.12 to 1.3; a hull, a desk's rough
// mesh, a mesh with waves that the object has not, 0.8 to 1.5. Photographs disagree the more the farther off they are, and so what is gained
// has to grow with the way: where there is no paint at all (a metal), they slide by 4 to 7 px until highlights meet, for 0.62 to 0.66.
//
// Gains: where exposures really drift 0.36 to 0.89 for 0.1 EV, 0.08 to 0.46 for 0.5 EV, the higher the wider the lobe. What all views mirror
// differently looks like gains (a bright photograph of a metal as over-exposed, by up to 1.3 EV): 0.99 to 1.05, in rooms 0.94 to 0.99.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fit/align_state.h"
#include "fit/robust.h"

static const double usual_px = 2;          // that photographs are off where no more is known
static const double least_agreement = 0.7; // what the product may be at most of poses that went no farther
static const double no_harm = 0.9;     // and of poses that went no farther than they are known to be wrong
static const double worth_gains = 0.9; // and of gains

double sheen_align_moved_px(const sheen_align_pose *v)
{
    double px2 = 0;
    for (size_t k = 0; k < 6; k++)
        px2 += pow(v->moved[k] * v->px_per[k], 2);
    return sqrt(px2);
}

// The two states between which is decided. shown: what photographs show of the points, [channels][n_views][n_points], NaN: nothing.
typedef struct proof {
    size_t channels, n; // n: observations
    sheen_align_pose *given, *present;
    float *given_shown, *present_shown;
    double *room;
} proof;

static sheen_status proof_init(proof *p, size_t channels, const sheen_align_state *st,
                               const sheen_align_pose *given, sheen_err *err)
{
    const size_t n = st->n_views * st->n_points, poses = st->n_views * sizeof *p->given;
    *p = (proof){.channels = channels,
                 .n = n,
                 .given = malloc(poses + 1),
                 .present = malloc(poses + 1),
                 .given_shown = malloc((n + 1) * channels * sizeof *p->given_shown),
                 .present_shown = malloc((n + 1) * channels * sizeof *p->present_shown),
                 .room = malloc((n + 1) * 2 * sizeof *p->room)};
    if (!p->given || !p->present || !p->given_shown || !p->present_shown || !p->room)
        return sheen_fail_memory(err, (double)(16 + 8 * channels) * (double)n, "the alignment's proof");
    memcpy(p->given, given, poses);
    memcpy(p->present, st->views, poses);
    return SHEEN_OK;
}

static void proof_release(proof *p)
{
    free(p->given);
    free(p->present);
    free(p->given_shown);
    free(p->present_shown);
    free(p->room);
}

// One channel: luminances. Three: red, green and blue. Both over the gain, without what is predicted.
static void take_shown(float *shown, size_t channels, const sheen_align_state *st)
{
    for (size_t c = 0; c < channels; c++)
        for (size_t v = 0; v < st->n_views; v++)
            for (size_t i = 0; i < st->n_points; i++) {
                const sheen_align_observation *o = sheen_align_at(st, v, i);
                const size_t k = v * st->n_points + i;
                *shown++ = !o->valid       ? (float)NAN
                           : channels == 1 ? o->y
                                           : o->rgb[c] * (float)st->views[v].per_gain[c] -
                                                 st->points->predicted[3 * k + c];
            }
}

// Robust scale by which what a photograph shows of the points left out differs from what the others predict. own, others: what it
// shows as the one that is predicted, and as one that predicts.
static double channel_error(const sheen_align_state *st, const float *own, const float *others, double *room)
{
    size_t n = 0;
    for (size_t i = 1; i < st->n_points; i += 2) {
        double total = 0, sum = 0;
        for (size_t v = 0; v < st->n_views; v++) {
            const sheen_align_observation *o = sheen_align_at(st, v, i);
            if (!o->valid)
                continue;
            total += (double)o->weight;
            sum += (double)o->weight * (double)others[v * st->n_points + i];
        }
        for (size_t v = 0; v < st->n_views; v++) {
            const sheen_align_observation *o = sheen_align_at(st, v, i);
            const size_t k = v * st->n_points + i;
            if (!o->valid || !isfinite(own[k]))
                continue;
            const double rest = total - (double)o->weight;
            if (rest > 1e-3 * total)
                room[n++] = (double)own[k] - (sum - (double)o->weight * (double)others[k]) / rest;
        }
    }
    return sheen_robust_scale(room, n, room + n);
}

static double prediction_error(const proof *p, const sheen_align_state *st, const float *own,
                               const float *others)
{
    double sum2 = 0;
    for (size_t c = 0; c < p->channels; c++)
        sum2 += pow(channel_error(st, own + c * p->n, others + c * p->n, p->room), 2);
    return sqrt(sum2);
}

// agreement: the ratios' product, of the present state and the given one. With `moved`, points are looked up anew for either.
static sheen_status compare(double *agreement, proof *p, sheen_align_state *st, int moved, sheen_err *err)
{
    sheen_status s = SHEEN_OK;
    memcpy(st->views, p->given, st->n_views * sizeof *p->given);
    if (moved && (s = sheen_align_observe(st, err)))
        return s;
    sheen_align_measure(st);
    take_shown(p->given_shown, p->channels, st);
    const double before = prediction_error(p, st, p->given_shown, p->given_shown);

    memcpy(st->views, p->present, st->n_views * sizeof *p->present);
    if (moved && (s = sheen_align_observe(st, err)))
        return s;
    sheen_align_measure(st);
    take_shown(p->present_shown, p->channels, st);
    const double after = prediction_error(p, st, p->present_shown, p->present_shown);
    const double one_given = prediction_error(p, st, p->given_shown, p->present_shown);
    *agreement = before > 0 ? after / before * (one_given / before) : 1;
    return SHEEN_OK;
}

sheen_status sheen_align_poses_believable(int *believable, sheen_align_state *st,
                                          const sheen_align_pose *given, sheen_err *err)
{
    proof p;
    double deviations2 = 0, usual2 = 0, agreement = 1;
    for (size_t v = 0; v < st->n_views; v++) {
        const double moved_px = sheen_align_moved_px(&st->views[v]), prior_px = st->views[v].prior_px;
        deviations2 += pow(moved_px / prior_px, 2) / (double)st->n_views;
        usual2 += pow(moved_px / fmax(prior_px, usual_px), 2) / (double)st->n_views;
    }
    sheen_status s = proof_init(&p, 1, st, given, err);
    for (size_t v = 0; v < st->n_views && !s; v++) // poses alone differ
        memcpy(p.given[v].log_gain, p.present[v].log_gain, sizeof p.given[v].log_gain);
    if (!s)
        s = compare(&agreement, &p, st, 1, err);
    *believable = agreement < (deviations2 <= 1 ? no_harm : least_agreement / fmax(1, sqrt(usual2)));
    proof_release(&p);
    return s;
}

sheen_status sheen_align_gains_believable(int *believable, sheen_align_state *st,
                                          const sheen_align_pose *given, sheen_err *err)
{
    proof p;
    double agreement = 1;
    sheen_status s = proof_init(&p, 3, st, given, err);
    if (!s)
        s = compare(&agreement, &p, st, 0, err);
    *believable = agreement < worth_gains;
    proof_release(&p);
    return s;
}

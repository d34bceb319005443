// SPDX-License-Identifier: Apache-2.0
// align_proof.c - may refined poses be believed?
//
// Photographs can be made to agree on a mesh that is off, or under highlights wider than the paint's detail, by sliding them over the
// surface: points left out then agree as well as those used. Poses have to earn it, more so where they went farther than they
// may be wrong. Where they are better, photographs come to agree far better than before, while one that stays where it was given is
// predicted by the others about as well as it was: its own error is then the only one between them. Exact scenes with poses 0.75 to
// 2 px off have 0.25 to 0.71 for the product of both ratios; true poses under lobes of 0.1 rad 1.12 to 1.3; a hull, a desk's rough
// mesh, a mesh with waves that the object has not, 0.8 to 1.5.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fit/align_state.h"
#include "fit/robust.h"

static const double least_agreement = 0.7; // what the product may be at most
static const double no_harm = 0.9;         // and of poses that went no farther than they may be wrong

double sheen_align_moved_px(const sheen_align_pose *v)
{
    double px2 = 0;
    for (size_t k = 0; k < 6; k++)
        px2 += pow(v->moved[k] * v->px_per[k], 2);
    return sqrt(px2);
}

// Robust scale by which luminances of points left out differ from what the other photographs predict. y: [n_views][n_points], NaN
// where there is none; NULL: those observed. room: 2 n_views n_points.
static double prediction_error(const sheen_align_state *st, const float *y, double *room)
{
    size_t n = 0;
    for (size_t i = 1; i < st->n_points; i += 2) {
        double total = 0, sum = 0;
        for (size_t v = 0; v < st->n_views; v++) {
            const sheen_align_observation *o = sheen_align_at(st, v, i);
            if (!o->valid)
                continue;
            total += (double)o->weight;
            sum += (double)o->weight * (double)o->y;
        }
        for (size_t v = 0; v < st->n_views; v++) {
            const sheen_align_observation *o = sheen_align_at(st, v, i);
            const double others = total - (double)o->weight,
                         own = y ? (double)y[v * st->n_points + i] : (double)o->y;
            if (o->valid && isfinite(own) && others > 1e-3 * total)
                room[n++] = own - (sum - (double)o->weight * (double)o->y) / others;
        }
    }
    return sheen_robust_scale(room, n, room + n);
}

static sheen_status look(sheen_align_state *st, sheen_err *err)
{
    const sheen_status s = sheen_align_observe(st, err);
    if (!s)
        sheen_align_measure(st);
    return s;
}

// agreement: the ratios' product, of the present poses and the given ones.
static sheen_status compare(double *agreement, sheen_align_state *st, const sheen_align_pose *given, float *y,
                            double *room, sheen_err *err)
{
    sheen_align_pose *present = malloc((st->n_views + 1) * sizeof *present);
    if (!present)
        return sheen_fail_memory(err, (double)(st->n_views * sizeof *present), "poses");
    memcpy(present, st->views, st->n_views * sizeof *present);
    memcpy(st->views, given, st->n_views * sizeof *given);
    for (size_t v = 0; v < st->n_views; v++) // but by the gains found
        memcpy(st->views[v].log_gain, present[v].log_gain, sizeof present[v].log_gain);
    double before = 0;
    sheen_status s = look(st, err);
    if (!s) {
        before = prediction_error(st, NULL, room);
        for (size_t i = 0; i < st->n_views * st->n_points; i++)
            y[i] = st->seen[i].valid ? st->seen[i].y : NAN;
    }
    memcpy(st->views, present, st->n_views * sizeof *present);
    free(present);
    if (!s && !(s = look(st, err)))
        *agreement = prediction_error(st, NULL, room) / before * (prediction_error(st, y, room) / before);
    return s;
}

sheen_status sheen_align_believable(int *believable, sheen_align_state *st, const sheen_align_pose *given,
                                    sheen_err *err)
{
    const size_t n = st->n_views * st->n_points;
    double deviations2 = 0, agreement = 0;
    for (size_t v = 0; v < st->n_views; v++)
        deviations2 += pow(sheen_align_moved_px(&st->views[v]) / st->views[v].prior_px, 2);
    float *y = calloc(n + 1, sizeof *y);
    double *room = malloc((n + 1) * 2 * sizeof *room);
    const sheen_status s = y && room ? compare(&agreement, st, given, y, room, err)
                                     : sheen_fail_memory(err, 20.0 * (double)n, "the poses' proof");
    *believable = agreement < (deviations2 <= (double)st->n_views ? no_harm : least_agreement);
    free(y);
    free(room);
    return s;
}

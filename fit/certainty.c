// SPDX-License-Identifier: Apache-2.0
// certainty.c - groups lights into lamps, and inverts the normal matrix of sigma, strengths and directions.
#include "fit/certainty.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "base/vec.h"
#include "calib/cholesky.h"
#include "fit/certainty_cells.h"
#include "fit/certainty_view.h"
#include "fit/robust.h"

enum { MOST_LAMPS = 48, PIXELS = 60000, MOST = 1 + 3 * MOST_LAMPS + SHEEN_GLOSS_MAX };

static const double shown_share = 0.3; // of a lamp's brightest pixel: then a photograph shows its highlight

typedef struct lamp {
    double v_world[3], strength, across[2][3], radius_rad; // radius: of its lights about its middle
    size_t n_lights;
} lamp;

typedef struct work {
    const sheen_paper_fit *f;
    const sheen_model *m;
    sheen_lights l;  // the model's nodes, or the points of its lamps
    float *per_m;    // [l.count] 1 / distance, from the lamps' origin; NULL: nodes, all far
    double radius_m; // of the object
    sheen_Rt Rt_world_obj;
    uint32_t *lamp_of; // [l.count] index of lamp; UINT32_MAX: none
    lamp *lamps;
    size_t n_lamps, step, n_parameters;
    int reference;        // the most shining cluster of k_S, in whose share the lamps' strengths are
    double *A, *J, scale; // n_parameters squared; one row
    sheen_score_cells cells;
    double slope, weight; // sums of the loss' second derivative, and of its weights
    double turn2,
        light2; // sums of the squared turn of the normal over a pixel times the squared light, and of that
} work;

// Parameters: log sigma; log strength and two angles of each lamp; log share of each cluster of k_S but the reference.
static size_t of_lamp(size_t i_lamp)
{
    return 1 + 3 * i_lamp;
}

static size_t of_cluster(const work *w, int k)
{
    return of_lamp(w->n_lamps) + (size_t)(k - (k > w->reference));
}

static void count_parameters(work *w)
{
    const sheen_gloss *g = &w->m->gloss;
    w->reference = 0;
    for (int k = 1; k < g->n; k++)
        if (g->share[k] > g->share[w->reference])
            w->reference = k;
    w->n_parameters = of_lamp(w->n_lamps) + (size_t)(g->n ? g->n - 1 : 0);
}

static float angle_between(const sheen_lights *l, size_t a, const double v[3])
{
    const double d[3] = {(double)l->dx[a], (double)l->dy[a], (double)l->dz[a]};
    return (float)acos(fmax(-1, fmin(1, sheen_dot(d, v))));
}

// Brightest light first, then all that are within a lobe's width of it and not yet taken; and again.
static void group(work *w)
{
    const sheen_lights *l = &w->l;
    const double reach_rad = fmax(3 * w->m->sigma_rad, 0.05);
    memset(w->lamp_of, 0xff, l->count * sizeof *w->lamp_of);
    while (w->n_lamps < MOST_LAMPS) {
        size_t best = SIZE_MAX;
        for (size_t i = 0; i < l->count; i++)
            if (w->lamp_of[i] == UINT32_MAX && (best == SIZE_MAX || l->weight[i] > l->weight[best]))
                best = i;
        if (best == SIZE_MAX || !(l->weight[best] > 0))
            return;
        lamp *g = &w->lamps[w->n_lamps];
        const double v[3] = {(double)l->dx[best], (double)l->dy[best], (double)l->dz[best]};
        for (size_t i = 0; i < l->count; i++) {
            if (w->lamp_of[i] != UINT32_MAX || !((double)angle_between(l, i, v) < reach_rad))
                continue;
            const double d[3] = {(double)l->dx[i], (double)l->dy[i], (double)l->dz[i]};
            w->lamp_of[i] = (uint32_t)w->n_lamps;
            g->strength += w->m->k_s * (double)l->weight[i];
            g->n_lights++;
            for (int k = 0; k < 3; k++)
                g->v_world[k] += (double)l->weight[i] * d[k];
        }
        sheen_normalize(g->v_world);
        const double any[3] = {fabs(g->v_world[0]) < 0.7, fabs(g->v_world[0]) >= 0.7, 0};
        sheen_cross(g->across[0], g->v_world, any);
        sheen_normalize(g->across[0]);
        sheen_cross(g->across[1], g->v_world, g->across[0]);
        w->n_lamps++;
    }
}

static int brighter(const void *a, const void *b)
{
    const sheen_lamp_certainty *x = a, *y = b;
    return (x->strength < y->strength) - (x->strength > y->strength);
}

static void measure_radii(work *w)
{
    for (size_t i = 0; i < w->l.count; i++)
        if (w->lamp_of[i] != UINT32_MAX) {
            lamp *g = &w->lamps[w->lamp_of[i]];
            const double parallax_rad = w->per_m ? (double)w->per_m[i] * w->radius_m : 0;
            g->radius_rad = fmax(g->radius_rad, (double)angle_between(&w->l, i, g->v_world) + parallax_rad);
        }
}

// Light of one lamp at a pixel, its lights moved by a small angle along `shift` (NULL: not), at another sigma.
static double lamp_light(const work *w, size_t i_lamp, const sheen_residual_pixel *p, const double *shift,
                         double sigma_rad)
{
    const sheen_lights *l = &w->l;
    const double k = -0.5 / (sigma_rad * sigma_rad);
    double sum = 0, x_m[3];
    const double p_obj[3] = {(double)p->p_obj[0], (double)p->p_obj[1], (double)p->p_obj[2]};
    float x[3];
    sheen_Rt_point(x_m, &w->Rt_world_obj, p_obj);
    for (int c = 0; c < 3; c++)
        x[c] = (float)(x_m[c] - w->m->lamp_origin_world[c]);
    for (size_t i = 0; i < l->count; i++) {
        if (w->lamp_of[i] != i_lamp)
            continue;
        float v[3] = {l->dx[i], l->dy[i], l->dz[i]};
        for (int c = 0; c < 3; c++)
            v[c] += (shift ? (float)shift[c] : 0) - (w->per_m ? w->per_m[i] * x[c] : 0);
        sheen_normalizef(v);
        const double a2 = (double)sheen_lobe_alpha2(p->n_world, p->v_world, v);
        if (a2 < 25 * sigma_rad * sigma_rad)
            sum += (double)l->weight[i] * exp(a2 * k);
    }
    return sum * w->m->k_s * (double)sheen_lobe_inverse_cos(p->n_world, p->v_world);
}

// Share of k_S at a pixel, and the row's part of the clusters, for a light of 1.
static double linearize_gloss(work *w, const sheen_residual_pixel *p)
{
    const sheen_gloss *g = &w->m->gloss;
    float root[3], weight[SHEEN_GLOSS_MAX];
    double share = 0;
    if (!g->n)
        return 1;
    for (int c = 0; c < 3; c++)
        root[c] = (float)p->texture_root[c] / 255;
    sheen_gloss_weights(weight, g, root);
    for (int k = 0; k < g->n; k++) {
        const double part = (double)(weight[k] * g->share[k]);
        share += part;
        if (k != w->reference)
            w->J[of_cluster(w, k)] = part;
    }
    return share;
}

// Fills the row of the Jacobian. Returns the light.
static double linearize(work *w, const sheen_residual_pixel *p, double (*peak)[MOST_LAMPS], size_t view)
{
    const size_t N = w->n_parameters;
    const double s = w->m->sigma_rad, h = 0.05 * s;
    float mirror[3];
    double total = 0;
    memset(w->J, 0, N * sizeof *w->J);
    const double gloss = linearize_gloss(w, p);
    sheen_mirrorf(mirror, p->n_world, p->v_world);
    const double r[3] = {(double)mirror[0], (double)mirror[1], (double)mirror[2]};
    for (size_t i = 0; i < w->n_lamps; i++) {
        const lamp *g = &w->lamps[i];
        if (sheen_dot(r, g->v_world) < cos(fmin(3.1, g->radius_rad + 8 * s)))
            continue;
        const double light = lamp_light(w, i, p, NULL, s);
        if (!(light > 1e-4))
            continue;
        double shift[3];
        total += light;
        peak[view][i] = fmax(peak[view][i], light / (double)sheen_lobe_inverse_cos(p->n_world, p->v_world));
        w->J[0] += gloss * (lamp_light(w, i, p, NULL, 1.02 * s) - lamp_light(w, i, p, NULL, s / 1.02)) /
                   (2 * log(1.02));
        w->J[of_lamp(i)] = gloss * light;
        for (int a = 0; a < 2; a++) {
            for (int c = 0; c < 3; c++)
                shift[c] = h * g->across[a][c];
            w->J[of_lamp(i) + 1 + (size_t)a] = gloss * (lamp_light(w, i, p, shift, s) - light) / h;
        }
    }
    for (size_t a = of_lamp(w->n_lamps); a < N; a++)
        w->J[a] *= total;
    return gloss * total;
}

// A pixel counts once, however many it stands for: the fit, too, took samples of about this number.
static void add_row(work *w, const sheen_residual_pixel *p, double residual)
{
    const size_t N = w->n_parameters;
    const double of_loss = sheen_loss_weight(SHEEN_LOSS_LORENTZIAN, residual, w->scale),
                 weight = of_loss / (w->scale * w->scale), z = residual / w->scale;
    w->weight += of_loss;
    w->slope += of_loss * of_loss * (1 - 0.5 * z * z);
    sheen_score_cells_add(&w->cells, p->p_obj, weight * residual, w->J);
    for (size_t a = 0; a < N; a++)
        for (size_t b = 0; b <= a && w->J[a] != 0; b++)
            w->A[a * N + b] += weight * w->J[a] * w->J[b];
}

// White is a lower bound.
static double held_residual(const sheen_residual_pixel *p, double light)
{
    const double r = (double)sheen_luminance(p->rgb) - light;
    return p->clipped && r < 0 ? 0 : r;
}

// How much the normal turns from a pixel to the next one in its row, where it shines.
static void add_footprint(work *w, const sheen_residual *r, size_t i, double light)
{
    const sheen_residual_pixel *p = &r->pixels[i], *next = p + 1;
    float turn[3];
    if (i + 1 == r->count || next->y_px != p->y_px || next->x_px != p->x_px + 1)
        return;
    sheen_subf(turn, next->n_world, p->n_world);
    w->turn2 += light * light * (double)sheen_dotf(turn, turn);
    w->light2 += light * light;
}

static void add_pixels(work *w, double (*peak)[MOST_LAMPS])
{
    size_t n = 0;
    for (size_t v = 0; v < w->f->n_views; v++)
        n += w->f->residuals[v].count;
    w->step = 1 + n / PIXELS;
    for (size_t v = 0; v < w->f->n_views; v++)
        for (size_t i = 0; i < w->f->residuals[v].count; i += w->step) {
            const sheen_residual_pixel *p = &w->f->residuals[v].pixels[i];
            const double light = linearize(w, p, peak, v);
            if (light > 0)
                add_row(w, p, held_residual(p, light));
            add_footprint(w, &w->f->residuals[v], i, light);
        }
}

static void say(sheen_certainty *c, const char *fmt, ...) SHEEN_PRINTF(2, 3);
static void say(sheen_certainty *c, const char *fmt, ...)
{
    if (c->n_sentences == SHEEN_CERTAINTY_SENTENCES)
        return;
    va_list args;
    va_start(args, fmt);
    vsnprintf(c->sentences[c->n_sentences++], SHEEN_CERTAINTY_SENTENCE_BYTES, fmt, args);
    va_end(args);
}

// A pixel is a mean over its surface, on which the normal turns: highlights are wider by that and their peaks lower, which the fit takes for
// roughness. The share by which sigma comes out too large; strengths come out too small by twice as much.
static double footprint_share(const work *w)
{
    const double sigma2 = w->m->sigma_rad * w->m->sigma_rad;
    return w->light2 > 0 ? w->turn2 / w->light2 / 12 / (2 * sigma2) : 0;
}

// Variances: the larger one of what independent residuals would leave and of what the surface's cells show (few cells show little).
static void find_variances(double *variance, double *of_k_s, const work *w, const double *inverse)
{
    const size_t N = w->n_parameters;
    double total = 0, along, v[MOST] = {0};
    for (size_t i = 0; i < w->n_lamps; i++)
        total += w->lamps[i].strength;
    for (size_t i = 0; i < w->n_lamps; i++)
        v[of_lamp(i)] = w->lamps[i].strength / total;
    sheen_score_cells_variance(variance, &along, &w->cells, inverse, v);
    const double curved = w->weight > 0 ? fmax(0.3, w->slope / w->weight) : 1;
    *of_k_s = 0;
    for (size_t a = 0; a < N; a++) {
        variance[a] = fmax(inverse[a * (N + 1)], variance[a] / (curved * curved));
        for (size_t b = 0; b < N; b++)
            *of_k_s += v[a] * v[b] * inverse[a * N + b];
    }
    const double wider = footprint_share(w);
    *of_k_s = fmax(*of_k_s, along / (curved * curved)) + 4 * wider * wider;
    variance[0] += wider * wider;
    for (size_t i = 0; i < w->n_lamps; i++)
        variance[of_lamp(i)] += 4 * wider * wider;
}

// The figures from the inverse of the normal matrix; what has no information has no figure.
static void invert(sheen_certainty *c, work *w)
{
    const size_t N = w->n_parameters;
    const sheen_gloss *g = &w->m->gloss;
    double *inverse = malloc(N * N * sizeof *inverse), variance[MOST], of_k_s = (double)NAN;
    for (size_t a = 0; a < N; a++)
        w->A[a * (N + 1)] += 1e-6; // nothing at all is known of a lamp that no pixel shows
    for (size_t a = 0; a < MOST; a++)
        variance[a] = (double)NAN;
    if (inverse && sheen_cholesky(w->A, (int)N)) {
        sheen_cholesky_invert(inverse, w->A, (int)N);
        find_variances(variance, &of_k_s, w, inverse);
    }
    free(inverse);
    c->sigma_share = sqrt(variance[0]);
    c->k_s_share = sqrt(of_k_s);
    for (size_t i = 0; i < w->n_lamps; i++) {
        sheen_lamp_certainty *o = &c->lamps[i];
        const double *own = variance + of_lamp(i);
        memcpy(o->v_world, w->lamps[i].v_world, sizeof o->v_world);
        o->strength = w->lamps[i].strength;
        o->n_lights = w->lamps[i].n_lights;
        o->strength_share = sqrt(own[0]);
        o->direction_rad = sqrt((own[1] + own[2]) / 2);
    }
    c->n_gloss = g->n;
    for (int k = 0; k < g->n; k++)
        c->gloss_share[k] = k == w->reference ? 0 : sqrt(variance[of_cluster(w, k)]);
}

static void count_views(sheen_certainty *c, double (*peak)[MOST_LAMPS], size_t n_views)
{
    for (size_t i = 0; i < c->n_lamps; i++) {
        double most = 0;
        for (size_t v = 0; v < n_views; v++)
            most = fmax(most, peak[v][i]);
        for (size_t v = 0; v < n_views; v++)
            c->lamps[i].n_views += peak[v][i] > shown_share * most;
    }
}

static void count_texels(sheen_certainty *c, const sheen_texture *t)
{
    const size_t n = t->n_triangles * sheen_texels_per_triangle(t->texels_per_edge);
    for (size_t i = 0; i < n; i++) {
        c->unseen_share += !t->n_views[i];
        c->once_share += t->n_views[i] == 1;
    }
    c->unseen_share /= n ? (double)n : 1;
    c->once_share /= n ? (double)n : 1;
}

static double azimuth_deg(const double v[3])
{
    const double a = atan2(v[1], v[0]) * 57.29577951308232;
    return a < 0 ? a + 360 : a;
}

static void put_in_words(sheen_certainty *c, bool lights_refuted)
{
    double total = 0;
    for (size_t i = 0; i < c->n_lamps; i++)
        total += c->lamps[i].strength;
    for (size_t i = 0; i < c->n_lamps && c->n_sentences < 4; i++) {
        const sheen_lamp_certainty *l = &c->lamps[i];
        if (l->strength > 0.03 * total && l->n_views < 2)
            say(c,
                "the highlight of the light at azimuth %.0f, elevation %.0f degrees was seen in %s: "
                "roughness and "
                "size of the light cannot be told apart, nor can its distance be known",
                azimuth_deg(l->v_world), asin(fmax(-1, fmin(1, l->v_world[2]))) * 57.29577951308232,
                l->n_views ? "one photograph only" : "no photograph in full");
    }
    if (lights_refuted)
        say(c,
            "the lights that were found do not help to predict photographs that are left out: the model is "
            "its texture alone");
    else if (!c->n_lamps)
        say(c, "no highlight was found that the photographs agree on: the surface is taken to be matte");
    else if (!(c->sigma_share < 0.1))
        say(c, "the roughness is known to %.0f %% only: few pixels lie on the flanks of highlights",
            fmin(999, 100 * c->sigma_share));
    if (c->unseen_share > 0.02)
        say(c,
            "%.0f %% of the surface was seen by no photograph: its colour, where it has one, is that of its "
            "surroundings",
            100 * c->unseen_share);
    if (c->once_share > 0.05)
        say(c,
            "%.0f %% of the surface was seen by one photograph only: a highlight there stays in the texture",
            100 * c->once_share);
    if (c->advised)
        say(c, "a further photograph from azimuth %.0f, elevation %.0f degrees would help most",
            c->advice_azimuth_deg, c->advice_elevation_deg);
}

// The model's nodes and the points of its lamps as one list.
static sheen_status list_lights(work *w, sheen_err *err)
{
    const sheen_model *m = w->m;
    sheen_lamp_points points;
    sheen_status s = sheen_lamp_points_init(&points, m->lamps, m->n_lamps, (float)m->sigma_rad, err);
    if (s)
        return s;
    const size_t n = m->lights.count + points.n_points;
    float **arrays[5] = {&w->l.dx, &w->l.dy, &w->l.dz, &w->l.weight, &w->per_m};
    for (int k = 0; k < 5 && !s; k++)
        if (!(*arrays[k] = calloc(n + 1, sizeof(float))))
            s = sheen_fail_memory(err, 20.0 * (double)n, "lights");
    for (size_t i = 0; i < m->lights.count && !s; i++) {
        w->l.dx[i] = m->lights.dx[i];
        w->l.dy[i] = m->lights.dy[i];
        w->l.dz[i] = m->lights.dz[i];
        w->l.weight[i] = m->lights.weight[i];
    }
    w->l.count = s ? 0 : n;
    for (size_t j = 0; j < m->n_lamps && !s; j++)
        for (size_t k = points.first[j]; k < points.first[j + 1]; k++) {
            const size_t i = m->lights.count + k;
            float d[3] = {points.dx[k], points.dy[k], points.dz[k]};
            const float length = sheen_normalizef(d);
            w->l.dx[i] = d[0];
            w->l.dy[i] = d[1];
            w->l.dz[i] = d[2];
            w->per_m[i] = points.inverse_distance[k] / length;
            w->l.weight[i] = m->k_s > 0 ? points.share[k] * sheen_luminance(m->lamps[j].rgb) / (float)m->k_s
                                        : 0;
        }
    sheen_lamp_points_release(&points);
    return s;
}

static void release_lights(work *w)
{
    free(w->l.dx);
    free(w->l.dy);
    free(w->l.dz);
    free(w->l.weight);
    free(w->per_m);
}

sheen_status sheen_certainty_find(sheen_certainty *out, const sheen_paper_fit *f, const sheen_mesh *mesh,
                                  const sheen_photos *photos, sheen_moving moving, sheen_err *err)
{
    *out = (sheen_certainty){0};
    work w = {.f = f, .m = &f->model, .scale = fmax(0.0015, f->refined.sigma_err)};
    if (f->model.n_lamps) { // near ones are seen elsewhere from each point
        float centre_obj[3], radius_m;
        sheen_mesh_sphere(mesh, centre_obj, &radius_m);
        w.radius_m = (double)radius_m;
        sheen_Rt_from_rt(&w.Rt_world_obj, photos->photos[0].rt_world_obj);
    }
    sheen_status s = list_lights(&w, err);
    double(*peak)[MOST_LAMPS] = calloc(f->n_views + 1, sizeof *peak);
    w.lamp_of = malloc((w.l.count + 1) * sizeof *w.lamp_of);
    w.lamps = calloc(MOST_LAMPS, sizeof *w.lamps);
    w.A = calloc((size_t)MOST * MOST, sizeof *w.A);
    w.J = calloc(MOST, sizeof *w.J);
    out->lamps = calloc(MOST_LAMPS, sizeof *out->lamps);
    if (s)
        goto done;
    if (!peak || !w.lamp_of || !w.lamps || !w.A || !w.J || !out->lamps) {
        s = sheen_fail_memory(err, 8.0 * MOST * MOST, "uncertainties");
        goto done;
    }
    group(&w);
    measure_radii(&w);
    count_parameters(&w);
    if ((s = sheen_score_cells_init(&w.cells, f->residuals, f->n_views, w.n_parameters, err)))
        goto done;
    add_pixels(&w, peak);
    invert(out, &w);
    out->n_lamps = w.n_lamps;
    count_views(out, peak, f->n_views);
    qsort(out->lamps, out->n_lamps, sizeof *out->lamps, brighter);
    count_texels(out, &f->model.texture);
    if (moving == SHEEN_MOVING_CAMERA)
        s = sheen_certainty_advise(out, &f->model, mesh, photos, err);
    put_in_words(out, f->lights_refuted);

done:
    free(peak);
    release_lights(&w);
    free(w.lamp_of);
    free(w.lamps);
    free(w.A);
    free(w.J);
    sheen_score_cells_release(&w.cells);
    if (s)
        sheen_certainty_release(out);
    return s;
}

void sheen_certainty_release(sheen_certainty *c)
{
    free(c->lamps);
    *c = (sheen_certainty){0};
}

// SPDX-License-Identifier: Apache-2.0
// lamp_fit.c - damped Gauss-Newton steps on reweighted normal equations, with one-sided differences.
//
// A lamp has five parameters: two angles, inverse distance, squared radius (in which a point's derivative does not vanish),
// and Y; the lobe has three. Derivatives come from lamps taken apart anew with one parameter moved, so that the forward model
// is the renderer's own. Shadows are asked for once, where a lamp could matter, and kept. Sums go over pieces of a fixed size in
// their order, so that the result does not depend on the number of threads.
#include "fit/lamp_fit.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/image.h"
#include "base/parallel.h"
#include "base/vec.h"
#include "calib/cholesky.h"

enum { PIECE = 512, PER_LAMP = 5, SHARED = 3, MOVED = 4 };
enum { ALONG_A, ALONG_B, DISTANCE, RADIUS, STRENGTH };

// A lamp's derivative below this light is not worth its time.
static const float negligible_lin = 1e-4f;
// Lamps that stay where they are cast a shadow on a sample to which they add this much.
static const float worth_a_ray_lin = 2e-5f;
static const float narrow_share = 0.4f;                        // of sigma
static const float max_radius_rad = 0.4f, max_nearness = 0.8f; // object's radius over the lamp's distance

typedef struct steps {
    float angle, per_m, radius2, sigma, tail, fresnel;
} steps;

typedef struct fit {
    sheen_lamp *lamps;
    size_t n;
    sheen_lobe_shape lobe;
    const sheen_lamp_samples *samples;
    const float *other;
    sheen_lamp_fit_options o;
    uint8_t *hidden; // [count][n]
    uint8_t *near;   // [count] 1: some lamp may matter to the sample
    uint32_t *index; // [n_near] samples of the fit: the others' residuals do not change
    size_t n_near;
    double rest_cost; // E of the others
    size_t n_pieces;
    double *piece_cost;
    // Of one iteration:
    sheen_lamp_points points, moved[MOVED];
    steps step;
    int n_parameters;
    double *pieces; // [n_pieces][n_parameters^2 + n_parameters]: normal equations, by piece
} fit;

static float luminance_of(const sheen_lamp *lamp)
{
    return sheen_luminance(lamp->rgb);
}

// Moves a lamp by `by` in each of its parameters, held to what is possible.
static void move_lamp(sheen_lamp *lamp, const double by[PER_LAMP], float radius_m)
{
    float a[3], b[3];
    sheen_axes_aboutf(a, b, lamp->direction_world);
    for (int i = 0; i < 3; i++)
        lamp->direction_world[i] += (float)by[ALONG_A] * a[i] + (float)by[ALONG_B] * b[i];
    sheen_normalizef(lamp->direction_world);
    const float most = max_nearness / radius_m;
    lamp->inverse_distance_per_m = fminf(most, fmaxf(0, lamp->inverse_distance_per_m + (float)by[DISTANCE]));
    const float r2 = lamp->radius_rad * lamp->radius_rad + (float)by[RADIUS];
    lamp->radius_rad = fminf(max_radius_rad, sqrtf(fmaxf(0, r2)));
    const float Y = luminance_of(lamp), next = fmaxf(0.02f * Y, Y + (float)by[STRENGTH]);
    for (int c = 0; c < 3 && Y > 0; c++)
        lamp->rgb[c] *= next / Y;
}

// Does the normal change across the pixel by as much as shows in a lobe this narrow?
static int is_spread(const sheen_lamp_sample *s, const sheen_lobe_shape *lobe)
{
    const float change2 = sheen_dotf(s->n_step[0], s->n_step[0]) + sheen_dotf(s->n_step[1], s->n_step[1]);
    return change2 > narrow_share * narrow_share * lobe->sigma_rad * lobe->sigma_rad;
}

// Of lamps begin .. begin + n at a sample, its gloss in it: the mean over the pixel's quarters where that matters.
static void respond(float *response, const sheen_lamp_points *points, size_t begin, size_t n,
                    const sheen_lobe_shape *lobe, const sheen_lamp_sample *s)
{
    if (!is_spread(s, lobe)) {
        sheen_lamp_responses(response, points, begin, n, lobe, s->x_m, s->n_world, s->v_world);
        for (size_t l = 0; l < n; l++)
            response[l] *= s->gloss;
        return;
    }
    memset(response, 0, n * sizeof *response);
    for (int k = 0; k < 4; k++) {
        const float right = k & 1 ? 0.25f : -0.25f, below = k & 2 ? 0.25f : -0.25f;
        float normal[3], part[SHEEN_LAMP_FIT_MAX];
        for (int c = 0; c < 3; c++)
            normal[c] = s->n_world[c] + right * s->n_step[0][c] + below * s->n_step[1][c];
        sheen_normalizef(normal);
        sheen_lamp_responses(part, points, begin, n, lobe, s->x_m, normal, s->v_world);
        for (size_t l = 0; l < n; l++)
            response[l] += 0.25f * s->gloss * part[l];
    }
}

static void towards(float out[3], const sheen_lamp *lamp, const float x_m[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = lamp->direction_world[k] - lamp->inverse_distance_per_m * x_m[k];
    sheen_normalizef(out);
}

static void hide_piece(void *self, size_t begin, size_t end)
{
    fit *f = self;
    // Wide enough for where the lamps may go
    sheen_lobe_shape wide = f->lobe;
    wide.sigma_rad *= 2.5f;
    for (size_t piece = begin; piece < end; piece++)
        for (size_t i = piece * PIECE; i < (piece + 1) * PIECE && i < f->samples->count; i++) {
            const sheen_lamp_sample *s = &f->samples->at[i];
            float response[SHEEN_LAMP_FIT_MAX];
            respond(response, &f->points, 0, f->n, &wide, s);
            for (size_t l = 0; l < f->n; l++) {
                float to_lamp[3];
                if (response[l] * luminance_of(&f->lamps[l]) < negligible_lin)
                    continue;
                f->near[i] = 1;
                towards(to_lamp, &f->lamps[l], s->x_m);
                if (f->o.hidden)
                    f->hidden[i * f->n + l] = (uint8_t)f->o.hidden(f->o.hidden_self, s, to_lamp);
            }
        }
}

static double predict(const fit *f, size_t i, const float *response)
{
    double sum = f->other ? (double)f->other[i] : 0;
    const uint8_t *hidden = f->hidden + i * f->n;
    for (size_t l = 0; l < f->n; l++)
        if (!hidden[l])
            sum += (double)(luminance_of(&f->lamps[l]) * response[l]);
    return sum;
}

static double rho(const fit *f, double r)
{
    return log1p(0.5 * r * r / (f->o.scale * f->o.scale));
}

static void cost_pieces(void *self, size_t begin, size_t end)
{
    fit *f = self;
    for (size_t piece = begin; piece < end; piece++) {
        double sum = 0;
        for (size_t k = piece * PIECE; k < (piece + 1) * PIECE && k < f->n_near; k++) {
            const size_t i = f->index[k];
            const sheen_lamp_sample *s = &f->samples->at[i];
            float response[SHEEN_LAMP_FIT_MAX];
            respond(response, &f->points, 0, f->n, &f->lobe, s);
            sum += (double)s->weight * rho(f, sheen_lamp_residual(s, predict(f, i, response)));
        }
        f->piece_cost[piece] = sum;
    }
}

static sheen_status cost_of(double *cost, fit *f, sheen_err *err)
{
    sheen_lamp_points_release(&f->points);
    const sheen_status s = sheen_lamp_points_init(&f->points, f->lamps, f->n, f->lobe.sigma_rad, err);
    if (s)
        return s;
    sheen_parallel_for(f->n_pieces, 1, f->o.n_threads, cost_pieces, f);
    *cost = f->rest_cost;
    for (size_t i = 0; i < f->n_pieces; i++)
        *cost += f->piece_cost[i];
    return SHEEN_OK;
}

// The lamps once more for each parameter, that one moved by its step.
static sheen_status move_all(fit *f, sheen_err *err)
{
    static const int parameter[MOVED] = {ALONG_A, ALONG_B, DISTANCE, RADIUS};
    const float sigma = f->lobe.sigma_rad;
    f->step = (steps){.angle = 0.02f * sigma,
                      .per_m = 0.02f * sigma / f->samples->radius_m,
                      .radius2 = 0.05f * sigma * sigma,
                      .sigma = 0.01f * sigma,
                      .tail = 0.01f,
                      .fresnel = 0.5f};
    const double by[MOVED] = {(double)f->step.angle, (double)f->step.angle, (double)f->step.per_m,
                              (double)f->step.radius2};
    for (int k = 0; k < MOVED; k++) {
        sheen_lamp lamps[SHEEN_LAMP_FIT_MAX];
        for (size_t l = 0; l < f->n; l++) {
            double move[PER_LAMP] = {0};
            move[parameter[k]] = by[k];
            lamps[l] = f->lamps[l];
            // Both sides of the difference are to have the same points
            if (parameter[k] == RADIUS)
                move[RADIUS] += lamps[l].radius_rad > sigma ? (double)f->step.radius2 : 0;
            move_lamp(&lamps[l], move, f->samples->radius_m);
        }
        sheen_lamp_points_release(&f->moved[k]);
        const sheen_status s = sheen_lamp_points_init(&f->moved[k], lamps, f->n, sigma, err);
        if (s)
            return s;
    }
    return SHEEN_OK;
}

// One sample's derivatives: parameters that matter to it, and how its prediction changes with them. Returns how many.
static int derivatives(const fit *f, size_t i, const float *response, int *parameter, double *slope)
{
    const sheen_lamp_sample *s = &f->samples->at[i];
    const float by[MOVED] = {f->step.angle, f->step.angle, f->step.per_m, f->step.radius2};
    const uint8_t *hidden = f->hidden + i * f->n;
    int n = 0;
    for (size_t l = 0; l < f->n; l++) {
        const float Y = luminance_of(&f->lamps[l]);
        if (hidden[l] || (double)(response[l] * Y) < 0.05 * f->o.scale)
            continue;
        const int first = PER_LAMP * (int)l;
        for (int k = 0; k < MOVED; k++) {
            float moved;
            if ((k == DISTANCE && !f->o.free_distance) || (k == RADIUS && !f->o.free_radius))
                continue;
            respond(&moved, &f->moved[k], l, 1, &f->lobe, s);
            const float step = k == RADIUS && f->lamps[l].radius_rad > f->lobe.sigma_rad ? 2 * by[k] : by[k];
            parameter[n] = first + k;
            slope[n++] = (double)(Y * (moved - response[l]) / step);
        }
        parameter[n] = first + STRENGTH;
        slope[n++] = (double)response[l];
    }
    if (!n)
        return 0;
    const int is_free[SHARED] = {f->o.free_sigma, f->o.free_tail, f->o.free_fresnel};
    const double before = predict(f, i, response);
    for (int k = 0; k < SHARED; k++) {
        float moved[SHEEN_LAMP_FIT_MAX];
        sheen_lobe_shape lobe = f->lobe;
        if (!is_free[k])
            continue;
        const float step = k == 0 ? f->step.sigma : k == 1 ? f->step.tail : f->step.fresnel;
        *(k == 0 ? &lobe.sigma_rad : k == 1 ? &lobe.tail : &lobe.fresnel) += step;
        respond(moved, &f->points, 0, f->n, &lobe, s);
        parameter[n] = PER_LAMP * (int)f->n + k;
        slope[n++] = (predict(f, i, moved) - before) / (double)step;
    }
    return n;
}

static void accumulate_pieces(void *self, size_t begin, size_t end)
{
    fit *f = self;
    const size_t P = (size_t)f->n_parameters;
    for (size_t piece = begin; piece < end; piece++) {
        double *A = f->pieces + piece * (P * P + P), *g = A + P * P;
        memset(A, 0, (P * P + P) * sizeof *A);
        for (size_t k = piece * PIECE; k < (piece + 1) * PIECE && k < f->n_near; k++) {
            const size_t i = f->index[k];
            const sheen_lamp_sample *s = &f->samples->at[i];
            float response[SHEEN_LAMP_FIT_MAX];
            int parameter[PER_LAMP * SHEEN_LAMP_FIT_MAX + SHARED];
            double slope[PER_LAMP * SHEEN_LAMP_FIT_MAX + SHARED];
            respond(response, &f->points, 0, f->n, &f->lobe, s);
            const double r = sheen_lamp_residual(s, predict(f, i, response));
            if (r == 0)
                continue;
            const double w = (double)s->weight / (1 + 0.5 * r * r / (f->o.scale * f->o.scale));
            const int n = derivatives(f, i, response, parameter, slope);
            for (int a = 0; a < n; a++) {
                double *row = A + (size_t)parameter[a] * P;
                for (int b = 0; b <= a; b++)
                    row[parameter[b]] += w * slope[a] * slope[b];
                g[parameter[a]] += w * slope[a] * r;
            }
        }
    }
}

// step[n_parameters] of the damped normal equations; false where they cannot be solved.
static int solve(double *step, const fit *f, double *A, const double *sum, double damping)
{
    const int P = f->n_parameters;
    memcpy(A, sum, (size_t)P * (size_t)P * sizeof *A);
    memcpy(step, sum + (size_t)P * (size_t)P, (size_t)P * sizeof *step);
    for (int k = 0; k < P; k++) {
        double *d = &A[k * P + k];
        *d = *d > 0 ? *d * (1 + damping) : 1; // nothing is known of it: it stays
    }
    if (!sheen_cholesky(A, P))
        return 0;
    sheen_cholesky_solve(step, A, P);
    return 1;
}

static void take_step(fit *f, const double *step)
{
    for (size_t l = 0; l < f->n; l++)
        move_lamp(&f->lamps[l], step + PER_LAMP * l, f->samples->radius_m);
    const double *shared = step + PER_LAMP * f->n;
    const float sigma = f->lobe.sigma_rad;
    f->lobe.sigma_rad = fminf(1.5f * sigma, fmaxf(sigma / 1.5f, sigma + (float)shared[0]));
    f->lobe.sigma_rad = fminf(0.6f, fmaxf(0.002f, f->lobe.sigma_rad));
    f->lobe.tail = fminf(1, fmaxf(0, f->lobe.tail + (float)shared[1]));
    f->lobe.fresnel = fminf(99, fmaxf(0, f->lobe.fresnel + (float)shared[2]));
}

static sheen_status iterate(fit *f, double *A, double *step, double *cost, double *damping, int *moved,
                            sheen_err *err)
{
    const size_t P = (size_t)f->n_parameters, size = P * P + P;
    sheen_lamp lamps[SHEEN_LAMP_FIT_MAX];
    const sheen_lobe_shape lobe = f->lobe;
    sheen_status s = move_all(f, err);
    if (s)
        return s;
    memcpy(lamps, f->lamps, f->n * sizeof *lamps);
    sheen_parallel_for(f->n_pieces, 1, f->o.n_threads, accumulate_pieces, f);
    if (!f->n_pieces)
        memset(f->pieces, 0, size * sizeof *f->pieces);
    for (size_t piece = 1; piece < f->n_pieces; piece++)
        for (size_t k = 0; k < size; k++)
            f->pieces[k] += f->pieces[piece * size + k];
    *moved = 0;
    for (int trial = 0; trial < 6 && !*moved; trial++) {
        double now = HUGE_VAL;
        if (solve(step, f, A, f->pieces, *damping)) {
            take_step(f, step);
            if ((s = cost_of(&now, f, err)))
                return s;
        }
        if (now < *cost) {
            *moved = *cost - now > 1e-4 * *cost ? 2 : 1;
            *cost = now;
            *damping = fmax(1e-6, *damping / 5);
        } else {
            memcpy(f->lamps, lamps, f->n * sizeof *lamps);
            f->lobe = lobe;
            *damping *= 8;
        }
    }
    return *moved ? SHEEN_OK : cost_of(cost, f, err);
}

static sheen_status prepare(fit *f, sheen_err *err)
{
    assert(f->n <= SHEEN_LAMP_FIT_MAX);
    f->n_pieces = (f->samples->count + PIECE - 1) / PIECE;
    f->n_parameters = PER_LAMP * (int)f->n + SHARED;
    f->hidden = calloc(f->samples->count * f->n + 1, 1);
    f->piece_cost = calloc(f->n_pieces + 1, sizeof *f->piece_cost);
    if (!f->hidden || !f->piece_cost)
        return sheen_fail_memory(err, (double)(f->samples->count * f->n), "lamps");
    f->near = calloc(f->samples->count + 1, 1);
    f->index = malloc((f->samples->count + 1) * sizeof *f->index);
    if (!f->near || !f->index)
        return sheen_fail_memory(err, 5.0 * (double)f->samples->count, "samples");
    const sheen_status s = sheen_lamp_points_init(&f->points, f->lamps, f->n, f->lobe.sigma_rad, err);
    if (s)
        return s;
    sheen_parallel_for(f->n_pieces, 1, f->o.n_threads, hide_piece, f);
    for (size_t i = 0; i < f->samples->count; i++)
        if (f->near[i])
            f->index[f->n_near++] = (uint32_t)i;
        else
            f->rest_cost += (double)f->samples->at[i].weight *
                            rho(f,
                                sheen_lamp_residual(&f->samples->at[i], f->other ? (double)f->other[i] : 0));
    f->n_pieces = (f->n_near + PIECE - 1) / PIECE;
    return SHEEN_OK;
}

static void release(fit *f)
{
    sheen_lamp_points_release(&f->points);
    for (int k = 0; k < MOVED; k++)
        sheen_lamp_points_release(&f->moved[k]);
    free(f->hidden);
    free(f->near);
    free(f->index);
    free(f->piece_cost);
    free(f->pieces);
}

sheen_status sheen_lamp_fit(sheen_lamp *lamps, size_t n, sheen_lobe_shape *lobe,
                            const sheen_lamp_samples *samples, const float *other,
                            const sheen_lamp_fit_options *options, sheen_lamp_fit_result *out, sheen_err *err)
{
    fit f = {.lamps = lamps, .n = n, .lobe = *lobe, .samples = samples, .other = other, .o = *options};
    *out = (sheen_lamp_fit_result){0};
    double damping = 1e-3, *A = NULL, *step = NULL;
    sheen_status s = prepare(&f, err);
    const size_t P = (size_t)f.n_parameters;
    f.pieces = malloc((f.n_pieces + 1) * (P * P + P) * sizeof *f.pieces);
    A = malloc(P * P * sizeof *A);
    step = malloc(P * sizeof *step);
    if (!s && (!f.pieces || !A || !step))
        s = sheen_fail_memory(err, (double)(f.n_pieces * P * P * 8), "normal equations");
    if (s || (s = cost_of(&out->cost, &f, err)))
        goto done;
    int calm = 0;
    for (int i = 0; i < options->max_iterations && calm < 2; i++) {
        int moved;
        if ((s = iterate(&f, A, step, &out->cost, &damping, &moved, err)))
            goto done;
        calm = moved == 2 ? 0 : moved ? calm + 1 : 2;
    }
    out->converged = calm >= 2;
    *lobe = f.lobe;

done:
    free(A);
    free(step);
    release(&f);
    return s;
}

typedef struct light_job {
    const sheen_lamp *lamps;
    size_t n;
    const sheen_lobe_shape *lobe;
    const sheen_lamp_samples *samples;
    const sheen_lamp_fit_options *o;
    sheen_lamp_points points;
    float *light;     // [count][n], or
    float *predicted; // [count], their sum
} light_job;

// A sample's light[n]: where a lamp adds what is worth a ray, the mesh is asked.
static void light_at(float *light, const light_job *j, const sheen_lamp_sample *s)
{
    respond(light, &j->points, 0, j->n, j->lobe, s);
    for (size_t l = 0; l < j->n; l++) {
        float to_lamp[3];
        light[l] *= luminance_of(&j->lamps[l]);
        if (!j->o->hidden || light[l] < worth_a_ray_lin)
            continue;
        towards(to_lamp, &j->lamps[l], s->x_m);
        if (j->o->hidden(j->o->hidden_self, s, to_lamp))
            light[l] = 0;
    }
}

static void light_samples(void *self, size_t begin, size_t end)
{
    const light_job *j = self;
    for (size_t i = begin; i < end; i++) {
        float own[SHEEN_LAMP_FIT_MAX], sum = 0;
        light_at(j->light ? j->light + i * j->n : own, j, &j->samples->at[i]);
        for (size_t l = 0; l < j->n && !j->light; l++)
            sum += own[l];
        if (!j->light)
            j->predicted[i] = sum;
    }
}

static sheen_status light_all(light_job *j, sheen_err *err)
{
    assert(j->n <= SHEEN_LAMP_FIT_MAX);
    const sheen_status s = sheen_lamp_points_init(&j->points, j->lamps, j->n, j->lobe->sigma_rad, err);
    if (!s)
        sheen_parallel_for(j->samples->count, PIECE, j->o->n_threads, light_samples, j);
    sheen_lamp_points_release(&j->points);
    return s;
}

sheen_status sheen_lamp_light(float *light, const sheen_lamp *lamps, size_t n, const sheen_lobe_shape *lobe,
                              const sheen_lamp_samples *samples, const sheen_lamp_fit_options *options,
                              sheen_err *err)
{
    light_job j = {.lamps = lamps, .n = n, .lobe = lobe, .samples = samples, .o = options};
    j.light = light;
    return light_all(&j, err);
}

sheen_status sheen_lamp_predict(float *predicted, const sheen_lamp *lamps, size_t n,
                                const sheen_lobe_shape *lobe, const sheen_lamp_samples *samples,
                                const sheen_lamp_fit_options *options, sheen_err *err)
{
    light_job j = {.lamps = lamps, .n = n, .lobe = lobe, .samples = samples, .o = options};
    j.predicted = predicted;
    return light_all(&j, err);
}

// Gram matrix and right sides of the colours' least squares.
static void add_colour_sample(double *gram, double *right, const fit *f, size_t i)
{
    const sheen_lamp_sample *s = &f->samples->at[i];
    float response[SHEEN_LAMP_FIT_MAX];
    if (s->clipped)
        return;
    respond(response, &f->points, 0, f->n, &f->lobe, s);
    const double r = (double)s->Y - predict(f, i, response);
    const double w = (double)s->weight / (1 + 0.5 * r * r / (f->o.scale * f->o.scale));
    for (size_t l = 0; l < f->n; l++) {
        if (f->hidden[i * f->n + l])
            continue;
        const double a = w * (double)response[l];
        for (size_t k = 0; k < f->n; k++)
            gram[l * f->n + k] += f->hidden[i * f->n + k] ? 0 : a * (double)response[k];
        for (size_t c = 0; c < 3; c++)
            right[c * f->n + l] += a * (double)s->rgb[c];
    }
}

static void solve_colours(sheen_lamp *lamps, size_t n, const double *gram, const double *right)
{
    double x[3][SHEEN_LAMP_FIT_MAX];
    for (size_t c = 0; c < 3; c++) {
        for (size_t l = 0; l < n; l++)
            x[c][l] = (double)lamps[l].rgb[c];
        for (int sweep = 0; sweep < 60; sweep++)
            for (size_t l = 0; l < n; l++) {
                double slope = right[c * n + l];
                for (size_t k = 0; k < n; k++)
                    slope -= gram[l * n + k] * x[c][k];
                if (gram[l * n + l] > 0)
                    x[c][l] = fmax(0, x[c][l] + slope / gram[l * n + l]);
            }
    }
    for (size_t l = 0; l < n; l++) {
        const float rgb[3] = {(float)x[0][l], (float)x[1][l], (float)x[2][l]}, Y = luminance_of(&lamps[l]);
        if (sheen_luminance(rgb) > 0)
            for (int c = 0; c < 3; c++)
                lamps[l].rgb[c] = rgb[c] * Y / sheen_luminance(rgb);
    }
}

sheen_status sheen_lamp_colours(sheen_lamp *lamps, size_t n, const sheen_lobe_shape *lobe,
                                const sheen_lamp_samples *samples, const sheen_lamp_fit_options *options,
                                sheen_err *err)
{
    fit f = {.lamps = lamps, .n = n, .lobe = *lobe, .samples = samples, .o = *options};
    double *gram = calloc(n * n + 1, sizeof *gram), *right = calloc(3 * n + 1, sizeof *right);
    sheen_status s = gram && right ? prepare(&f, err)
                                   : sheen_fail_memory(err, 8.0 * (double)(n * n), "lamps");
    if (!s) {
        for (size_t i = 0; i < samples->count; i++)
            add_colour_sample(gram, right, &f, i);
        solve_colours(lamps, n, gram, right);
    }
    free(gram);
    free(right);
    release(&f);
    return s;
}

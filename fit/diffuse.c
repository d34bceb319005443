// SPDX-License-Identifier: Apache-2.0
// diffuse.c - alternating least squares for ambient light, F0 and the diffuse colour.
#include "fit/diffuse.h"

#include <math.h>
#include <string.h>

#include "base/parallel.h"
#include "calib/cholesky.h"

enum { MAX_VIEWS = SHEEN_REFINED_MAX_VIEWS, TERMS = SHEEN_AMBIENT_TERMS, PART_TEXELS = 30000, PIECES = 64 };

static const double noise_lin = 0.01;    // of a photograph's sample, resampling included
static const double lights_doubt = 0.15; // share by which a predicted highlight may be wrong
static const double outlier_lin = 0.02;  // scale of the robust weights
static const double settled_lin =
    1e-5; // a mean that moves by less stays: a thirtieth of the least step of 8-bit sRGB

// One texel in one view.
typedef struct sample {
    double observed[3];  // I - S
    double mirrored[3];  // M without the room
    double basis[TERMS]; // of the room, 0 where the mirror direction does not lead there
    double schlick;      // (1 - cos)^5
    double gloss;        // of the texel
    double weight;
} sample;

static void take(sample *s, const sheen_texel_view *view, const sheen_view_light *l, size_t texel,
                 int with_room)
{
    const float *above = l->above_world + 3 * texel;
    for (size_t c = 0; c < 3; c++) {
        s->observed[c] = (double)view->rgb[3 * texel + c] - (double)l->lights_rgb[3 * texel + c];
        s->mirrored[c] = (double)l->mirrored_rgb[3 * texel + c];
    }
    memset(s->basis, 0, sizeof s->basis);
    if (with_room && above[2] > 0)
        sheen_ambient_basis(s->basis, above);
    const double u = 1 - (double)l->cosine[texel];
    s->schlick = u * u * u * u * u;
    s->gloss = l->gloss ? (double)l->gloss[texel] : 1;
    const double doubt = lights_doubt * (double)sheen_luminance(l->lights_rgb + 3 * texel);
    s->weight = (double)l->cosine[texel] / (noise_lin * noise_lin + doubt * doubt) * noise_lin * noise_lin;
}

// with_room: 1 where what the room adds counts.
static size_t gather(sample out[MAX_VIEWS], const sheen_texel_view *views, const sheen_view_light *lights,
                     size_t n_views, size_t texel, int with_room)
{
    size_t n = 0;
    for (size_t v = 0; v < n_views && n < MAX_VIEWS; v++)
        if (views[v].seen[texel])
            take(&out[n++], &views[v], &lights[v], texel, with_room);
    return n;
}

static double room(const sample *s, const sheen_surroundings *e, int c)
{
    double sum = 0;
    for (int k = 0; k < TERMS; k++)
        sum += s->basis[k] * e->ambient_rgb[k][c];
    return sum > 0 ? sum : 0;
}

static double fresnel(const sample *s, const sheen_surroundings *e)
{
    if (!e->present)
        return 0;
    return s->gloss * (e->f0 + (1 - e->f0) * s->schlick);
}

// I - S - F M.
static void diffuse_of(double d[3], const sample *s, const sheen_surroundings *e)
{
    const double F = fresnel(s, e);
    for (int c = 0; c < 3; c++)
        d[c] = s->observed[c] - F * (s->mirrored[c] + room(s, e, c));
}

void sheen_diffuse_and_lights(double rgb[3], const sheen_surroundings *surroundings,
                              const sheen_texel_view *view, const sheen_view_light *light, size_t texel)
{
    sample s;
    take(&s, view, light, texel, surroundings->present);
    diffuse_of(rgb, &s, surroundings);
    for (size_t c = 0; c < 3; c++)
        rgb[c] += (double)light->lights_rgb[3 * texel + c];
}

static double luminance(const double rgb[3])
{
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

// The sample that has half of the weight below it, by luminance: where most views are right the rest cannot pull it.
static size_t median_of(const double *y, const sample *s, size_t n)
{
    uint8_t order[MAX_VIEWS] = {0};
    double total = 0, below = 0;
    for (size_t i = 0; i < n; i++) {
        size_t k = i;
        for (; k && y[order[k - 1]] > y[i]; k--)
            order[k] = order[k - 1];
        order[k] = (uint8_t)i;
        total += s[i].weight;
    }
    for (size_t k = 0; k < n; k++)
        if ((below += s[order[k]].weight) >= 0.5 * total)
            return order[k];
    return order[n - 1];
}

static double lorentzian(double residual)
{
    const double z = residual / outlier_lin;
    return 1 / (1 + 0.5 * z * z);
}

// Weights with the Lorentzian's, from the median on: each sample's luminance against the weighted mean of all, which is found in
// `rounds` turns after the first or where it moves no more.
static void reweight(double w[MAX_VIEWS], double mean[3], const sample *s, size_t n,
                     const sheen_surroundings *e, int rounds)
{
    double d[MAX_VIEWS][3], y[MAX_VIEWS], total = 0;
    mean[0] = mean[1] = mean[2] = 0;
    if (!n)
        return;
    for (size_t i = 0; i < n; i++) {
        diffuse_of(d[i], &s[i], e);
        y[i] = luminance(d[i]);
    }
    double level = y[median_of(y, s, n)], before;
    int round = 0;
    do {
        double sum = 0;
        total = 0;
        for (size_t i = 0; i < n; i++) {
            w[i] = s[i].weight * lorentzian(y[i] - level);
            total += w[i];
            sum += w[i] * y[i];
        }
        before = level;
        level = sum / total;
    } while (++round <= rounds && fabs(level - before) > settled_lin);
    for (size_t i = 0; i < n; i++)
        for (int c = 0; c < 3; c++)
            mean[c] += w[i] * d[i][c] / total;
}

typedef struct normal_equations {
    double A[TERMS * TERMS], b[3][TERMS]; // of the ambient terms
    double f0_above, f0_below;
} normal_equations;

// Ambient terms: y = I - S - F M = D + F basis.a; D falls out with the weighted means.
static void add_ambient(normal_equations *q, const sample *s, const double *w, size_t n,
                        const sheen_surroundings *e)
{
    double mean_x[TERMS] = {0}, mean_y[3] = {0, 0, 0}, total = 0;
    for (size_t i = 0; i < n; i++) {
        const double F = fresnel(&s[i], e);
        total += w[i];
        for (int k = 0; k < TERMS; k++)
            mean_x[k] += w[i] * F * s[i].basis[k];
        for (int c = 0; c < 3; c++)
            mean_y[c] += w[i] * (s[i].observed[c] - F * s[i].mirrored[c]);
    }
    for (size_t i = 0; i < n; i++) {
        const double F = fresnel(&s[i], e);
        double x[TERMS];
        for (int k = 0; k < TERMS; k++)
            x[k] = F * s[i].basis[k] - mean_x[k] / total;
        for (int k = 0; k < TERMS; k++) {
            for (int m = 0; m <= k; m++)
                q->A[k * TERMS + m] += w[i] * x[k] * x[m];
            for (int c = 0; c < 3; c++)
                q->b[c][k] += w[i] * x[k] * (s[i].observed[c] - F * s[i].mirrored[c] - mean_y[c] / total);
        }
    }
}

// F0: y = I - S - gloss schlick M = D + F0 gloss (1 - schlick) M, with M the whole of it.
static void add_f0(normal_equations *q, const sample *s, const double *w, size_t n,
                   const sheen_surroundings *e)
{
    for (int c = 0; c < 3; c++) {
        double mean_x = 0, mean_y = 0, total = 0;
        for (size_t i = 0; i < n; i++) {
            const double M = s[i].gloss * (s[i].mirrored[c] + room(&s[i], e, c));
            total += w[i];
            mean_x += w[i] * (1 - s[i].schlick) * M;
            mean_y += w[i] * (s[i].observed[c] - s[i].schlick * M);
        }
        for (size_t i = 0; i < n; i++) {
            const double M = s[i].gloss * (s[i].mirrored[c] + room(&s[i], e, c));
            const double x = (1 - s[i].schlick) * M - mean_x / total;
            q->f0_above += w[i] * x * (s[i].observed[c] - s[i].schlick * M - mean_y / total);
            q->f0_below += w[i] * x * x;
        }
    }
}

static void solve(sheen_surroundings *e, normal_equations *q)
{
    double trace = 0;
    for (int k = 0; k < TERMS; k++)
        trace += q->A[k * TERMS + k];
    for (int k = 0; k < TERMS; k++) // little is known of directions that are mirrored seldom: towards 0
        q->A[k * TERMS + k] += 1e-3 * trace / TERMS + 1e-12;
    if (!sheen_cholesky(q->A, TERMS))
        return;
    for (int c = 0; c < 3; c++) {
        sheen_cholesky_solve(q->b[c], q->A, TERMS);
        for (int k = 0; k < TERMS; k++)
            e->ambient_rgb[k][c] = q->b[c][k];
    }
}

// Every step-th texel, in PIECES pieces whose sums are added in their order.
typedef struct part {
    const sheen_surroundings *surroundings;
    const sheen_texel_view *views;
    const sheen_view_light *lights;
    size_t n_views, n_texels, step;
    int ambient; // 1: its terms; 0: F0
    normal_equations equations[PIECES];
    double cost[PIECES], weight[PIECES];
} part;

static part part_of(const sheen_surroundings *surroundings, const sheen_texel_view *views,
                    const sheen_view_light *lights, size_t n_views)
{
    const size_t n_texels = n_views ? views[0].n_texels : 0;
    return (part){.surroundings = surroundings,
                  .views = views,
                  .lights = lights,
                  .n_views = n_views,
                  .n_texels = n_texels,
                  .step = 1 + n_texels / PART_TEXELS};
}

static void add_pieces(void *self, size_t begin, size_t end)
{
    part *p = self;
    for (size_t piece = begin; piece < end; piece++) {
        normal_equations *q = &p->equations[piece];
        *q = (normal_equations){0};
        for (size_t t = piece * p->step; t < p->n_texels; t += PIECES * p->step) {
            sample s[MAX_VIEWS];
            double w[MAX_VIEWS], mean[3];
            const size_t n = gather(s, p->views, p->lights, p->n_views, t, p->surroundings->present);
            if (n < 2)
                continue;
            reweight(w, mean, s, n, p->surroundings, 2);
            if (p->ambient)
                add_ambient(q, s, w, n, p->surroundings);
            else
                add_f0(q, s, w, n, p->surroundings);
        }
    }
}

static normal_equations sum_of(const part *p)
{
    normal_equations sum = {0};
    for (int piece = 0; piece < PIECES; piece++) {
        const normal_equations *q = &p->equations[piece];
        for (int k = 0; k < TERMS * TERMS; k++)
            sum.A[k] += q->A[k];
        for (int c = 0; c < 3; c++)
            for (int k = 0; k < TERMS; k++)
                sum.b[c][k] += q->b[c][k];
        sum.f0_above += q->f0_above;
        sum.f0_below += q->f0_below;
    }
    return sum;
}

void sheen_surroundings_fit(sheen_surroundings *surroundings, int with_ambient, const sheen_texel_view *views,
                            const sheen_view_light *lights, size_t n_views, int n_threads)
{
    part p = part_of(surroundings, views, lights, n_views);
    double f0_before = -1;
    for (int round = 0; round < 8; round++) {
        p.ambient = round % 2 == 0 && with_ambient;
        sheen_parallel_for(PIECES, 1, n_threads, add_pieces, &p);
        normal_equations q = sum_of(&p);
        if (p.ambient)
            solve(surroundings, &q);
        else if (q.f0_below > 0)
            surroundings->f0 = fmin(1, fmax(0, q.f0_above / q.f0_below));
        if (round % 2 && fabs(surroundings->f0 - f0_before) < 1e-3 * f0_before)
            return;
        f0_before = surroundings->f0;
    }
}

static void add_cost(double *cost, double *weight, const part *p, size_t t)
{
    sample s[MAX_VIEWS];
    double w[MAX_VIEWS], mean[3], d[3], all = 0;
    const size_t n = gather(s, p->views, p->lights, p->n_views, t, p->surroundings->present);
    if (n < 3)
        return;
    reweight(w, mean, s, n, p->surroundings, 2);
    for (size_t i = 0; i < n; i++)
        all += w[i];
    for (size_t i = 0; i < n; i++) {
        // Against the mean of the others
        diffuse_of(d, &s[i], p->surroundings);
        const double z = (luminance(d) - luminance(mean)) * all / ((all - w[i]) * outlier_lin);
        *cost += s[i].weight * log1p(0.5 * z * z);
        *weight += s[i].weight;
    }
}

static void cost_pieces(void *self, size_t begin, size_t end)
{
    part *p = self;
    for (size_t piece = begin; piece < end; piece++)
        for (size_t t = piece * p->step; t < p->n_texels; t += PIECES * p->step)
            add_cost(&p->cost[piece], &p->weight[piece], p, t);
}

double sheen_diffuse_cost(const sheen_surroundings *surroundings, const sheen_texel_view *views,
                          const sheen_view_light *lights, size_t n_views, int n_threads)
{
    part p = part_of(surroundings, views, lights, n_views);
    double sum = 0, total = 0;
    sheen_parallel_for(PIECES, 1, n_threads, cost_pieces, &p);
    for (int piece = 0; piece < PIECES; piece++) {
        sum += p.cost[piece];
        total += p.weight[piece];
    }
    return total > 0 ? sum / total : 0;
}

typedef struct job {
    sheen_texture *texture;
    float *deviation;
    const sheen_surroundings *surroundings;
    const sheen_texel_view *views;
    const sheen_view_light *lights;
    size_t n_views;
} job;

// Standard deviation of the mean's luminance: by the samples' scatter about it, and not less than by their noise.
static float deviation_of(const sample *s, const double *w, const double mean[3], size_t n,
                          const sheen_surroundings *e)
{
    double total = 0, scatter2 = 0, d[3];
    for (size_t i = 0; i < n; i++) {
        diffuse_of(d, &s[i], e);
        const double r = luminance(d) - luminance(mean);
        total += w[i];
        scatter2 += w[i] * w[i] * r * r;
    }
    if (n < 2)
        return NAN;
    const double by_scatter2 = scatter2 / (total * total) * (double)n / (double)(n - 1);
    return (float)sqrt(fmax(by_scatter2, noise_lin * noise_lin / total));
}

static void fit_texels(void *self, size_t begin, size_t end)
{
    const job *j = self;
    for (size_t t = begin; t < end; t++) {
        sample s[MAX_VIEWS];
        double w[MAX_VIEWS], mean[3];
        const size_t n = gather(s, j->views, j->lights, j->n_views, t, j->surroundings->present);
        if (j->deviation)
            j->deviation[t] = NAN;
        if (!n)
            continue;
        reweight(w, mean, s, n, j->surroundings, 5);
        if (j->deviation)
            j->deviation[t] = deviation_of(s, w, mean, n, j->surroundings);
        for (size_t c = 0; c < 3; c++)
            j->texture->rgb[3 * t + c] = mean[c] > 0 ? (float)mean[c] : 0;
    }
}

void sheen_diffuse_fit(sheen_texture *texture, float *deviation, const sheen_surroundings *surroundings,
                       const sheen_texel_view *views, const sheen_view_light *lights, size_t n_views,
                       int n_threads)
{
    job j = {texture, NULL, surroundings, views, lights, n_views};
    j.deviation = deviation;
    sheen_parallel_for(n_views ? views[0].n_texels : 0, 4096, n_threads, fit_texels, &j);
}

// SPDX-License-Identifier: Apache-2.0
// composite_proof.c - two passes over texels: how far each photograph's fellows bear the lights out, and what they predict.
#include "fit/composite_proof.h"

#include <math.h>
#include <stdlib.h>

#include "base/image.h"
#include "base/parallel.h"

enum { MOST_VIEWS = SHEEN_REFINED_MAX_VIEWS, PIECES = 64, MOST_SAMPLES = 200000 };

static const double white_lin = 0.97; // a photograph at its upper end: a lower bound

// A texel in one photograph: luminances as photographed and of what changes with the view.
typedef struct sample {
    size_t view;
    double I, L, weight;
} sample;

// Sums over pairs of samples: all, and those with one of this photograph.
typedef struct slope {
    double xy, xx;
} slope;

typedef struct proof {
    const sheen_surroundings *surroundings;
    const sheen_texel_view *views;
    const sheen_view_light *lights;
    size_t n_views, step;
    slope *pairs;  // [PIECES][n_views + 1] by photograph, and of all
    double *share; // [n_views] g
    double with_lights[PIECES], alone[PIECES], weight[PIECES];
} proof;

static size_t gather(sample out[MOST_VIEWS], const proof *p, size_t texel)
{
    size_t n = 0;
    for (size_t v = 0; v < p->n_views && n < MOST_VIEWS; v++) {
        double rgb[3];
        if (!p->views[v].seen[texel])
            continue;
        const float *seen = p->views[v].rgb + 3 * texel;
        sheen_diffuse_and_lights(rgb, p->surroundings, &p->views[v], &p->lights[v], texel);
        const float still[3] = {(float)rgb[0], (float)rgb[1], (float)rgb[2]};
        const double I = (double)sheen_luminance(seen);
        out[n++] = (sample){.view = v,
                            .I = I,
                            .L = I - (double)sheen_luminance(still) +
                                 (double)sheen_luminance(p->lights[v].lights_rgb + 3 * texel),
                            .weight = (double)p->lights[v].cosine[texel]};
    }
    return n;
}

static int at_white(const sample *s)
{
    return s->I >= white_lin;
}

// Clipped ones say little of a slope.
static void add_pairs(slope *pairs, const sample *s, size_t n, size_t n_views)
{
    for (size_t a = 0; a < n; a++)
        for (size_t b = 0; b < a; b++) {
            const double x = s[a].L - s[b].L, w = s[a].weight * s[b].weight / (double)n;
            if (at_white(&s[a]) || at_white(&s[b]))
                continue;
            const slope one = {w * x * (s[a].I - s[b].I), w * x * x};
            const size_t where[3] = {s[a].view, s[b].view, n_views};
            for (int k = 0; k < 3; k++) {
                pairs[where[k]].xy += one.xy;
                pairs[where[k]].xx += one.xx;
            }
        }
}

static void slope_pieces(void *self, size_t begin, size_t end)
{
    const proof *p = self;
    for (size_t piece = begin; piece < end; piece++)
        for (size_t t = piece * p->step; t < p->views[0].n_texels; t += PIECES * p->step) {
            sample s[MOST_VIEWS];
            const size_t n = gather(s, p, t);
            add_pairs(p->pairs + piece * (p->n_views + 1), s, n, p->n_views);
        }
}

static void find_shares(proof *p)
{
    const size_t n = p->n_views;
    slope *sum = p->pairs; // of the first piece
    for (size_t piece = 1; piece < PIECES; piece++)
        for (size_t v = 0; v <= n; v++) {
            sum[v].xy += p->pairs[piece * (n + 1) + v].xy;
            sum[v].xx += p->pairs[piece * (n + 1) + v].xx;
        }
    for (size_t v = 0; v < n; v++) {
        const double xy = sum[n].xy - sum[v].xy, xx = sum[n].xx - sum[v].xx;
        // Two photographs, each without fellows: as the model has it
        p->share[v] = xx > 1e-9 * sum[n].xx ? fmin(1, fmax(0, xy / xx)) : n < 3;
    }
}

// Weighted median of I - share L over all samples but one.
static double median_of_others(const sample *s, size_t n, size_t without, double share)
{
    double value[MOST_VIEWS], weight[MOST_VIEWS], total = 0, below = 0;
    size_t count = 0;
    for (size_t i = 0; i < n; i++) {
        if (i == without)
            continue;
        const double y = s[i].I - share * s[i].L;
        size_t k = count++;
        for (; k && value[k - 1] > y; k--) {
            value[k] = value[k - 1];
            weight[k] = weight[k - 1];
        }
        value[k] = y;
        weight[k] = s[i].weight;
        total += s[i].weight;
    }
    for (size_t k = 0; k < count; k++)
        if ((below += weight[k]) >= 0.5 * total)
            return k + 1 < count && below <= 0.5 * total * (1 + 1e-9) ? (value[k] + value[k + 1]) / 2
                                                                      : value[k];
    return count ? value[count - 1] : 0;
}

static double wrong2(const sample *s, size_t n, size_t i, double share)
{
    const double predicted = median_of_others(s, n, i, share) + share * s[i].L;
    const double off = fmin(1, fmax(0, predicted)) - fmin(1, s[i].I);
    return at_white(&s[i]) && off > 0 ? 0 : off * off;
}

static void predict_pieces(void *self, size_t begin, size_t end)
{
    proof *p = self;
    for (size_t piece = begin; piece < end; piece++)
        for (size_t t = piece * p->step; t < p->views[0].n_texels; t += PIECES * p->step) {
            sample s[MOST_VIEWS];
            const size_t n = gather(s, p, t);
            for (size_t i = 0; i < n && n > 1; i++) {
                p->with_lights[piece] += s[i].weight * wrong2(s, n, i, p->share[s[i].view]);
                p->alone[piece] += s[i].weight * wrong2(s, n, i, 0);
                p->weight[piece] += s[i].weight;
            }
        }
}

static size_t count_samples(const proof *p)
{
    size_t n = 0;
    for (size_t v = 0; v < p->n_views; v++)
        for (size_t t = 0; t < p->views[v].n_texels; t++)
            n += p->views[v].seen[t];
    return n;
}

sheen_status sheen_composite_prove(sheen_composite_proof *out, const sheen_surroundings *surroundings,
                                   const sheen_texel_view *views, const sheen_view_light *lights,
                                   size_t n_views, int n_threads, sheen_err *err)
{
    proof p = {.surroundings = surroundings, .views = views, .lights = lights, .n_views = n_views};
    double weight = 0;
    *out = (sheen_composite_proof){0};
    p.step = 1 + count_samples(&p) / MOST_SAMPLES;
    p.pairs = calloc(PIECES * (n_views + 1), sizeof *p.pairs);
    p.share = calloc(n_views + 1, sizeof *p.share);
    const sheen_status s = p.pairs && p.share
                               ? SHEEN_OK
                               : sheen_fail_memory(err, 16.0 * PIECES * (double)n_views, "photographs");
    if (!s && n_views) {
        sheen_parallel_for(PIECES, 1, n_threads, slope_pieces, &p);
        find_shares(&p);
        sheen_parallel_for(PIECES, 1, n_threads, predict_pieces, &p);
        for (int piece = 0; piece < PIECES; piece++) {
            out->with_lights += p.with_lights[piece];
            out->texture_alone += p.alone[piece];
            weight += p.weight[piece];
        }
        out->with_lights /= weight > 0 ? weight : 1;
        out->texture_alone /= weight > 0 ? weight : 1;
    }
    free(p.pairs);
    free(p.share);
    return s;
}

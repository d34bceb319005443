// SPDX-License-Identifier: Apache-2.0
// light_matrix.c - builds and evaluates the sparse matrix of eq. (7), by columns.
#include "fit/light_matrix.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/vec.h"
#include "render/lobe.h"

typedef struct build {
    sheen_light_matrix *m;
    const sheen_samples *samples;
    const float *mirror_world; // [n_samples][3]
    const float *node_world;
    float min_dot; // cosine of the largest angle between a node and the mirror direction that is in reach
    float max_alpha2;
    int filling;
} build;

// Counts a column's pairs, or fills them in once the columns' places are known. The half angle alpha is at least
// half the angle between light and mirror direction, so the dot product rejects nearly all pairs.
static void build_columns(void *self, size_t begin, size_t end)
{
    const build *b = self;
    for (size_t l = begin; l < end; l++) {
        const float *light = b->node_world + 3 * l;
        size_t k = b->filling ? b->m->column_start[l] : 0;
        for (size_t s = 0; s < b->samples->count; s++) {
            if (sheen_dotf(light, b->mirror_world + 3 * s) < b->min_dot)
                continue;
            const float a2 = sheen_lobe_alpha2(b->samples->n_world + 3 * s, b->samples->v_world + 3 * s,
                                               light);
            if (!(a2 <= b->max_alpha2))
                continue;
            if (b->filling) {
                b->m->sample[k] = (uint32_t)s;
                b->m->alpha2[k] = a2;
            }
            k++;
        }
        if (!b->filling)
            b->m->column_start[l + 1] = k;
    }
}

static sheen_status allocate_pairs(sheen_light_matrix *m, sheen_err *err)
{
    for (size_t l = 0; l < m->n_nodes; l++)
        m->column_start[l + 1] += m->column_start[l];
    m->n_pairs = m->column_start[m->n_nodes];
    m->sample = malloc((m->n_pairs + 1) * sizeof *m->sample);
    m->alpha2 = malloc((m->n_pairs + 1) * sizeof *m->alpha2);
    m->value = malloc((m->n_pairs + 1) * sizeof *m->value);
    if (!m->sample || !m->alpha2 || !m->value)
        return sheen_fail_memory(err, 12.0 * (double)m->n_pairs, "pairs of samples and lights");
    return SHEEN_OK;
}

sheen_status sheen_light_matrix_init(sheen_light_matrix *m, const sheen_samples *samples,
                                     const float *node_world, size_t n_nodes, double sigma_max_rad,
                                     int n_threads, sheen_err *err)
{
    *m = (sheen_light_matrix){
        .n_samples = samples->count, .n_nodes = n_nodes, .sigma_max_rad = sigma_max_rad};
    const float reach = SHEEN_LOBE_REACH_SIGMA * (float)sigma_max_rad;
    sheen_status s = SHEEN_OK;
    float *mirror_world = malloc((3 * samples->count + 1) * sizeof *mirror_world);
    m->column_start = calloc(n_nodes + 1, sizeof *m->column_start);
    m->inverse_cos = malloc((samples->count + 1) * sizeof *m->inverse_cos);
    if (!mirror_world || !m->column_start || !m->inverse_cos) {
        s = sheen_fail_memory(err, 16.0 * (double)samples->count, "samples");
        goto done;
    }
    for (size_t i = 0; i < samples->count; i++) {
        sheen_mirrorf(mirror_world + 3 * i, samples->n_world + 3 * i, samples->v_world + 3 * i);
        m->inverse_cos[i] = sheen_lobe_inverse_cos(samples->n_world + 3 * i, samples->v_world + 3 * i);
    }
    build b = {.m = m,
               .samples = samples,
               .mirror_world = mirror_world,
               .node_world = node_world,
               .min_dot = 2 * reach < 3.14f ? cosf(2 * reach) - 1e-5f : -2.0f,
               .max_alpha2 = reach * reach};
    sheen_parallel_for(n_nodes, 8, n_threads, build_columns, &b);
    if ((s = allocate_pairs(m, err)))
        goto done;
    b.filling = 1;
    sheen_parallel_for(n_nodes, 8, n_threads, build_columns, &b);

done:
    free(mirror_world);
    if (s)
        sheen_light_matrix_release(m);
    return s;
}

typedef struct hiding {
    sheen_light_matrix *m;
    const float *node_world;
    int (*hidden)(void *self, size_t i_sample, const float l_world[3]);
    void *self;
    float max_alpha2;
} hiding;

static void hide_columns(void *self, size_t begin, size_t end)
{
    const hiding *h = self;
    for (size_t l = begin; l < end; l++)
        for (size_t k = h->m->column_start[l]; k < h->m->column_start[l + 1]; k++)
            if (h->m->alpha2[k] < h->max_alpha2 && h->hidden(h->self, h->m->sample[k], h->node_world + 3 * l))
                h->m->alpha2[k] = HUGE_VALF; // exp of it is 0 at any sigma
}

void sheen_light_matrix_hide(sheen_light_matrix *m, const float *node_world,
                             int (*hidden)(void *self, size_t i_sample, const float l_world[3]), void *self,
                             int n_threads)
{
    const float reach = 3 * (float)m->sigma_max_rad;
    hiding h = {m, node_world, hidden, self, reach * reach};
    sheen_parallel_for(m->n_nodes, 4, n_threads, hide_columns, &h);
}

void sheen_light_matrix_release(sheen_light_matrix *m)
{
    free(m->column_start);
    free(m->sample);
    free(m->alpha2);
    free(m->value);
    free(m->inverse_cos);
    *m = (sheen_light_matrix){0};
}

typedef struct evaluation {
    sheen_light_matrix *m;
    float minus_half_inverse_variance;
} evaluation;

static void evaluate(void *self, size_t begin, size_t end)
{
    const evaluation *e = self;
    for (size_t k = begin; k < end; k++)
        e->m->value[k] = expf(e->m->alpha2[k] * e->minus_half_inverse_variance) *
                         e->m->inverse_cos[e->m->sample[k]];
}

void sheen_light_matrix_set_sigma(sheen_light_matrix *m, double sigma_rad, int n_threads)
{
    evaluation e = {m, (float)(-0.5 / (sigma_rad * sigma_rad))};
    sheen_parallel_for(m->n_pairs, 65536, n_threads, evaluate, &e);
}

void sheen_light_matrix_predict(const sheen_light_matrix *m, double *intensity, const double *x,
                                double sigma_rad)
{
    const float k = (float)(-0.5 / (sigma_rad * sigma_rad));
    memset(intensity, 0, m->n_samples * sizeof *intensity);
    for (size_t l = 0; l < m->n_nodes; l++) {
        if (!(x[l] > 0))
            continue;
        for (size_t i = m->column_start[l]; i < m->column_start[l + 1]; i++)
            intensity[m->sample[i]] += x[l] * (double)expf(m->alpha2[i] * k);
    }
    for (size_t s = 0; s < m->n_samples; s++)
        intensity[s] *= (double)m->inverse_cos[s];
}

// SPDX-License-Identifier: Apache-2.0
// fill_holes.c - means at vertices, spread ring by ring and then smoothed where nothing is known (Laplace's equation).
#include "fit/fill_holes.h"

#include <stdlib.h>
#include <string.h>

enum { SMOOTHING_ROUNDS = 40 };

typedef struct vertex {
    float rgb[3], weight; // weight > 0: has a colour
    uint8_t known;        // from seen texels: it stays
} vertex;

static void barycentric(float b[3], int i, int j, int last)
{
    b[1] = (float)i / (float)last;
    b[2] = (float)j / (float)last;
    b[0] = 1 - b[1] - b[2];
}

static void gather_seen(vertex *vertices, const sheen_texture *t, const sheen_mesh *mesh)
{
    const int last = t->texels_per_edge - 1;
    size_t texel = 0;
    for (size_t f = 0; f < t->n_triangles; f++)
        for (int j = 0; j <= last; j++)
            for (int i = 0; i + j <= last; i++, texel++) {
                float b[3];
                if (!t->n_views[texel])
                    continue;
                barycentric(b, i, j, last);
                for (int k = 0; k < 3; k++) {
                    vertex *v = &vertices[mesh->triangles[3 * f + (size_t)k]];
                    const float w = b[k] * b[k];
                    for (int c = 0; c < 3; c++)
                        v->rgb[c] += w * t->rgb[3 * texel + (size_t)c];
                    v->weight += w;
                }
            }
}

static void normalize(vertex *vertices, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        vertex *v = &vertices[i];
        for (int c = 0; c < 3 && v->weight > 0; c++)
            v->rgb[c] /= v->weight;
        v->known = v->weight > 0;
        v->weight = v->known ? 1 : 0;
    }
}

// Every vertex without a colour of its own takes the mean of its neighbours that have one. Returns how many had none before.
static size_t spread(vertex *vertices, vertex *next, const sheen_mesh *mesh)
{
    size_t n_new = 0;
    memset(next, 0, mesh->n_vertices * sizeof *next);
    for (size_t f = 0; f < mesh->n_triangles; f++)
        for (size_t k = 0; k < 3; k++) {
            vertex *to = &next[mesh->triangles[3 * f + k]];
            for (size_t m = 1; m < 3; m++) {
                const vertex *from = &vertices[mesh->triangles[3 * f + (k + m) % 3]];
                if (!(from->weight > 0))
                    continue;
                for (int c = 0; c < 3; c++)
                    to->rgb[c] += from->rgb[c];
                to->weight += 1;
            }
        }
    for (size_t i = 0; i < mesh->n_vertices; i++) {
        vertex *v = &vertices[i];
        if (v->known || !(next[i].weight > 0))
            continue;
        n_new += v->weight > 0 ? 0 : 1;
        v->weight = 1;
        for (int c = 0; c < 3; c++)
            v->rgb[c] = next[i].rgb[c] / next[i].weight;
    }
    return n_new;
}

static void fill_texels(sheen_texture *t, const vertex *vertices, const sheen_mesh *mesh)
{
    const int last = t->texels_per_edge - 1;
    size_t texel = 0;
    for (size_t f = 0; f < t->n_triangles; f++)
        for (int j = 0; j <= last; j++)
            for (int i = 0; i + j <= last; i++, texel++) {
                float b[3];
                if (t->n_views[texel])
                    continue;
                barycentric(b, i, j, last);
                for (size_t c = 0; c < 3; c++) {
                    float sum = 0;
                    for (size_t k = 0; k < 3; k++)
                        sum += b[k] * vertices[mesh->triangles[3 * f + k]].rgb[c];
                    t->rgb[3 * texel + c] = sum;
                }
            }
}

// Pieces of the mesh that nothing was seen of: the mean of the rest.
static void fill_rest(vertex *vertices, size_t n)
{
    double sum[3] = {0, 0, 0}, count = 0;
    for (size_t i = 0; i < n; i++) {
        if (!vertices[i].known)
            continue;
        for (int c = 0; c < 3; c++)
            sum[c] += (double)vertices[i].rgb[c];
        count += 1;
    }
    for (size_t i = 0; i < n; i++)
        for (int c = 0; c < 3 && count > 0 && !(vertices[i].weight > 0); c++)
            vertices[i].rgb[c] = (float)(sum[c] / count);
}

sheen_status sheen_fill_holes(sheen_texture *t, const sheen_mesh *mesh, sheen_err *err)
{
    const size_t n = mesh->n_vertices;
    vertex *vertices = calloc(n + 1, sizeof *vertices), *next = calloc(n + 1, sizeof *next);
    sheen_status s = SHEEN_OK;
    if (!vertices || !next) {
        s = sheen_fail_memory(err, 40.0 * (double)n, "the colours of vertices");
        goto done;
    }
    gather_seen(vertices, t, mesh);
    normalize(vertices, n);
    while (spread(vertices, next, mesh)) {
    }
    for (int i = 0; i < SMOOTHING_ROUNDS; i++)
        spread(vertices, next, mesh);
    fill_rest(vertices, n);
    fill_texels(t, vertices, mesh);

done:
    free(vertices);
    free(next);
    return s;
}

// SPDX-License-Identifier: Apache-2.0
// outline_mesh.c - a mesh as vertices, triangles and edges: same places become one vertex, edges are found by
// sorting the triangles' sides.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "pose/outline.h"

static const uint32_t NONE = UINT32_MAX;

void sheen_outline_mesh_release(sheen_outline_mesh *mesh)
{
    free(mesh->p_obj);
    free(mesh->triangles);
    free(mesh->edges);
    *mesh = (sheen_outline_mesh){0};
}

// A vertex and the cell (or exact place) that it lies in.
typedef struct keyed {
    int64_t key[3];
    uint32_t index;
} keyed;

static int by_key(const void *a, const void *b)
{
    const keyed *x = a, *y = b;
    for (int k = 0; k < 3; k++)
        if (x->key[k] != y->key[k])
            return x->key[k] < y->key[k] ? -1 : 1;
    return (x->index > y->index) - (x->index < y->index);
}

typedef struct side {
    uint32_t low, high, triangle;
} side;

static int by_vertices(const void *a, const void *b)
{
    const side *x = a, *y = b;
    if (x->low != y->low)
        return x->low < y->low ? -1 : 1;
    if (x->high != y->high)
        return x->high < y->high ? -1 : 1;
    return (x->triangle > y->triangle) - (x->triangle < y->triangle);
}

// Sides that occur twice are one edge of two triangles, two by two.
static sheen_status find_edges(sheen_outline_mesh *mesh, sheen_err *err)
{
    const size_t n = 3 * mesh->n_triangles;
    side *sides = malloc((n + 1) * sizeof *sides);
    mesh->edges = malloc((n + 1) * 4 * sizeof *mesh->edges);
    if (!sides || !mesh->edges) {
        free(sides);
        return sheen_fail_memory(err, (double)n * (sizeof *sides + 16), "a mesh's edges");
    }
    for (size_t i = 0; i < n; i++) {
        const uint32_t a = mesh->triangles[i], b = mesh->triangles[i % 3 == 2 ? i - 2 : i + 1];
        sides[i] = (side){a < b ? a : b, a < b ? b : a, (uint32_t)(i / 3)};
    }
    qsort(sides, n, sizeof *sides, by_vertices);
    for (size_t i = 0; i < n;) {
        const bool pair = i + 1 < n && sides[i + 1].low == sides[i].low && sides[i + 1].high == sides[i].high;
        const uint32_t edge[4] = {sides[i].low, sides[i].high, sides[i].triangle,
                                  pair ? sides[i + 1].triangle : NONE};
        memcpy(mesh->edges + 4 * mesh->n_edges++, edge, sizeof edge);
        i += pair ? 2 : 1;
    }
    free(sides);
    return SHEEN_OK;
}

// Merges the vertices of equal keys into their mean. keys[n_vertices] is sorted here.
static sheen_status merge(sheen_outline_mesh *out, keyed *keys, size_t n_vertices, const float *p_obj,
                          const uint32_t *triangles, size_t n_triangles, sheen_err *err)
{
    *out = (sheen_outline_mesh){0};
    uint32_t *to = malloc((n_vertices + 1) * sizeof *to);
    out->p_obj = malloc((3 * n_vertices + 3) * sizeof *out->p_obj);
    out->triangles = calloc(3 * n_triangles + 3, sizeof *out->triangles);
    if (!to || !out->p_obj || !out->triangles) {
        free(to);
        sheen_outline_mesh_release(out);
        return sheen_fail_memory(err, (double)n_vertices * 16 + (double)n_triangles * 12, "a mesh");
    }
    qsort(keys, n_vertices, sizeof *keys, by_key);
    for (size_t i = 0; i < n_vertices;) {
        double sum[3] = {0};
        size_t end = i;
        for (; end < n_vertices && !memcmp(keys[end].key, keys[i].key, sizeof keys[i].key); end++) {
            to[keys[end].index] = (uint32_t)out->n_vertices;
            for (size_t c = 0; c < 3; c++)
                sum[c] += (double)p_obj[3 * (size_t)keys[end].index + c];
        }
        for (size_t c = 0; c < 3; c++)
            out->p_obj[3 * out->n_vertices + c] = (float)(sum[c] / (double)(end - i));
        out->n_vertices++;
        i = end;
    }
    for (size_t i = 0; i < n_triangles; i++) {
        const uint32_t *t = triangles + 3 * i;
        const uint32_t v[3] = {to[t[0]], to[t[1]], to[t[2]]};
        if (v[0] != v[1] && v[1] != v[2] && v[2] != v[0])
            memcpy(out->triangles + 3 * out->n_triangles++, v, sizeof v);
    }
    free(to);
    const sheen_status s = find_edges(out, err);
    if (s)
        sheen_outline_mesh_release(out);
    return s;
}

sheen_status sheen_outline_mesh_make(sheen_outline_mesh *out, const sheen_mesh *mesh, sheen_err *err)
{
    keyed *keys = malloc((mesh->n_vertices + 1) * sizeof *keys);
    if (!keys)
        return sheen_fail_memory(err, (double)mesh->n_vertices * sizeof *keys, "a mesh");
    for (size_t i = 0; i < mesh->n_vertices; i++) {
        keys[i].index = (uint32_t)i;
        for (size_t c = 0; c < 3; c++) {
            const float p = mesh->p_obj[3 * i + c] + 0.0f; // -0 becomes 0
            int32_t bits;
            memcpy(&bits, &p, sizeof bits);
            keys[i].key[c] = bits;
        }
    }
    const sheen_status s = merge(out, keys, mesh->n_vertices, mesh->p_obj, mesh->triangles, mesh->n_triangles,
                                 err);
    free(keys);
    return s;
}

sheen_status sheen_outline_mesh_coarsen(sheen_outline_mesh *out, const sheen_outline_mesh *mesh, int cells,
                                        sheen_err *err)
{
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, size = 0;
    for (size_t i = 0; i < mesh->n_vertices; i++)
        for (size_t c = 0; c < 3; c++) {
            low[c] = fmin(low[c], (double)mesh->p_obj[3 * i + c]);
            high[c] = fmax(high[c], (double)mesh->p_obj[3 * i + c]);
        }
    for (int c = 0; c < 3; c++)
        size = fmax(size, high[c] - low[c]);
    keyed *keys = malloc((mesh->n_vertices + 1) * sizeof *keys);
    if (!keys)
        return sheen_fail_memory(err, (double)mesh->n_vertices * sizeof *keys, "a mesh");
    for (size_t i = 0; i < mesh->n_vertices; i++) {
        keys[i].index = (uint32_t)i;
        for (size_t c = 0; c < 3; c++)
            keys[i].key[c] = (int64_t)floor(cells * ((double)mesh->p_obj[3 * i + c] - low[c]) / size);
    }
    const sheen_status s = merge(out, keys, mesh->n_vertices, mesh->p_obj, mesh->triangles, mesh->n_triangles,
                                 err);
    free(keys);
    return s;
}

// SPDX-License-Identifier: Apache-2.0
// mesh_repair.c - hash tables of places, faces and edges; a flood over edges; signed volumes.
#include "base/mesh_repair.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"

#define NONE UINT32_MAX

typedef struct edge {
    uint32_t a, b;            // places, a < b
    uint32_t side[2];         // 3 * triangle + corner at which the edge starts
    uint8_t forward[2], uses; // does the triangle go from a to b; 3 and more: no two-sided edge
} edge;

typedef struct repair {
    sheen_mesh *mesh;
    uint32_t *place; // [n_vertices] first vertex at the same position
    uint32_t *slots; // hash table, n_slots is a power of 2
    size_t n_slots;
    edge *edges; // [3 n_triangles]
    size_t n_edges;
    uint32_t *edge_of; // [3 n_triangles] index of a corner's edge
    uint8_t *turned;   // [n_triangles] relative to the file
    uint32_t *part;    // [n_triangles]
    uint32_t *stack;   // [n_triangles]
} repair;

static size_t mix(uint64_t x)
{
    x ^= x >> 31;
    x *= UINT64_C(0x9e3779b97f4a7c15);
    x ^= x >> 29;
    x *= UINT64_C(0xbf58476d1ce4e5b9);
    return (size_t)(x ^ (x >> 32));
}

static uint64_t bits_of(const float p[3])
{
    uint32_t b[3];
    float q[3];
    for (int k = 0; k < 3; k++)
        q[k] = p[k] + 0.0f; // -0 is 0
    memcpy(b, q, sizeof b);
    return ((uint64_t)b[0] * 73856093u) ^ ((uint64_t)b[1] << 21) ^ ((uint64_t)b[2] << 42) ^ b[2];
}

static void empty_slots(repair *r)
{
    memset(r->slots, 0xff, r->n_slots * sizeof *r->slots);
}

static void find_places(repair *r)
{
    empty_slots(r);
    for (uint32_t v = 0; v < r->mesh->n_vertices; v++) {
        const float *p = r->mesh->p_obj + 3 * (size_t)v;
        size_t i = mix(bits_of(p)) & (r->n_slots - 1);
        for (;; i = (i + 1) & (r->n_slots - 1)) {
            if (r->slots[i] == NONE) {
                r->slots[i] = v;
                break;
            }
            const float *q = r->mesh->p_obj + 3 * (size_t)r->slots[i];
            if (p[0] == q[0] && p[1] == q[1] && p[2] == q[2])
                break;
        }
        r->place[v] = r->slots[i];
    }
}

static void sorted_places(uint32_t out[3], const repair *r, size_t triangle)
{
    for (size_t k = 0; k < 3; k++)
        out[k] = r->place[r->mesh->triangles[3 * triangle + k]];
    for (int pass = 0; pass < 2; pass++)
        for (int k = 0; k < 2; k++)
            if (out[k] > out[k + 1]) {
                const uint32_t t = out[k];
                out[k] = out[k + 1];
                out[k + 1] = t;
            }
}

// Keeps the first of equal faces; returns how many went.
static size_t drop_doubles(repair *r)
{
    size_t n = 0;
    empty_slots(r);
    for (size_t t = 0; t < r->mesh->n_triangles; t++) {
        uint32_t mine[3], other[3];
        sorted_places(mine, r, t);
        if (mine[0] == mine[1] || mine[1] == mine[2])
            continue; // without area
        size_t i = mix(((uint64_t)mine[0] << 42) ^ ((uint64_t)mine[1] << 21) ^ mine[2]) & (r->n_slots - 1);
        bool is_double = false;
        for (; r->slots[i] != NONE && !is_double; i = (i + 1) & (r->n_slots - 1)) {
            sorted_places(other, r, r->slots[i]);
            is_double = !memcmp(mine, other, sizeof mine);
        }
        if (is_double)
            continue;
        r->slots[i] = (uint32_t)n;
        memmove(r->mesh->triangles + 3 * n++, r->mesh->triangles + 3 * t, 3 * sizeof *r->mesh->triangles);
    }
    const size_t dropped = r->mesh->n_triangles - n;
    r->mesh->n_triangles = n;
    return dropped;
}

static void find_edges(repair *r)
{
    empty_slots(r);
    for (uint32_t c = 0; c < 3 * r->mesh->n_triangles; c++) {
        const uint32_t next = c % 3 == 2 ? c - 2 : c + 1;
        const uint32_t from = r->place[r->mesh->triangles[c]], to = r->place[r->mesh->triangles[next]];
        const uint32_t a = from < to ? from : to, b = from < to ? to : from;
        size_t i = mix(((uint64_t)a << 32) | b) & (r->n_slots - 1);
        while (r->slots[i] != NONE && (r->edges[r->slots[i]].a != a || r->edges[r->slots[i]].b != b))
            i = (i + 1) & (r->n_slots - 1);
        if (r->slots[i] == NONE) {
            r->slots[i] = (uint32_t)r->n_edges;
            r->edges[r->n_edges++] = (edge){.a = a, .b = b};
        }
        edge *e = &r->edges[r->slots[i]];
        if (e->uses < 2) {
            e->side[e->uses] = c;
            e->forward[e->uses] = from < to;
        }
        e->uses = e->uses < 3 ? (uint8_t)(e->uses + 1) : 3;
        r->edge_of[c] = r->slots[i];
    }
}

// Gives the part of triangle `first` its number, and turns its triangles to agree with `first`.
static void flood(repair *r, uint32_t first)
{
    size_t n = 0;
    r->stack[n++] = first;
    r->part[first] = first;
    while (n) {
        const uint32_t t = r->stack[--n];
        for (uint32_t k = 0; k < 3; k++) {
            const edge *e = &r->edges[r->edge_of[3 * t + k]];
            if (e->uses != 2)
                continue;
            const int mine = e->side[0] == 3 * t + k ? 0 : 1;
            const uint32_t other = e->side[1 - mine] / 3;
            if (r->part[other] != NONE)
                continue;
            r->part[other] = first;
            // Neighbours pass their common edge in opposite directions
            r->turned[other] = r->turned[t] ^ (e->forward[0] == e->forward[1]);
            r->stack[n++] = other;
        }
    }
}

// Signed volume of the tetrahedron to `middle`, and the triangle's area.
static double volume_of(double *area, const sheen_mesh *mesh, size_t triangle, const float middle[3])
{
    double p[3][3], c[3], e1[3], e2[3];
    for (size_t k = 0; k < 3; k++)
        for (size_t i = 0; i < 3; i++)
            p[k][i] = (double)mesh->p_obj[3 * (size_t)mesh->triangles[3 * triangle + k] + i] -
                      (double)middle[i];
    sheen_sub(e1, p[1], p[0]);
    sheen_sub(e2, p[2], p[0]);
    sheen_cross(c, e1, e2);
    *area = sheen_norm(c) / 2;
    sheen_cross(c, p[1], p[2]);
    return sheen_dot(p[0], c) / 6;
}

typedef struct part {
    double volume, absolute, area; // absolute: sum of the volumes' sizes
    size_t n, n_turned, n_rims;    // rims: edges with a triangle on one side only
} part;

// Decides for every part which way is out: by its volume where it is all but closed and not flat, else by the majority.
static sheen_status orient(repair *r, sheen_err *err)
{
    const size_t n = r->mesh->n_triangles;
    part *parts = calloc(n + 1, sizeof *parts);
    if (!parts)
        return sheen_fail_memory(err, (double)(n * sizeof *parts), "the mesh's parts");
    for (size_t t = 0; t < n; t++) {
        // About a corner of the part itself, so that where the part lies does not matter
        const float *at = r->mesh->p_obj + 3 * (size_t)r->mesh->triangles[3 * (size_t)r->part[t]];
        part *p = &parts[r->part[t]];
        double area;
        const double v = volume_of(&area, r->mesh, t, at);
        p->volume += r->turned[t] ? -v : v;
        p->absolute += fabs(v);
        p->area += area;
        p->n++;
        p->n_turned += r->turned[t];
        for (size_t k = 0; k < 3; k++)
            p->n_rims += r->edges[r->edge_of[3 * t + k]].uses == 1;
    }
    for (size_t t = 0; t < n; t++) {
        const part *p = &parts[r->part[t]];
        const bool has_volume = 10 * p->n_rims < 3 * p->n && fabs(p->volume) > 0.3 * p->absolute &&
                                p->absolute > 2e-3 * p->area * sqrt(p->area);
        const bool over = has_volume ? p->volume < 0 : 2 * p->n_turned > p->n;
        r->turned[t] = r->turned[t] != over;
    }
    free(parts);
    return SHEEN_OK;
}

static size_t turn_over(repair *r)
{
    size_t n = 0;
    for (size_t t = 0; t < r->mesh->n_triangles; t++) {
        uint32_t *c = r->mesh->triangles + 3 * t;
        if (!r->turned[t])
            continue;
        const uint32_t second = c[1];
        c[1] = c[2];
        c[2] = second;
        n++;
    }
    return n;
}

// Normals against those of the triangles about each vertex.
static sheen_status mend_normals(size_t *n_mended, sheen_mesh *mesh, sheen_err *err)
{
    const size_t size_bytes = 3 * mesh->n_vertices * sizeof *mesh->n_obj;
    float *given = calloc(1, size_bytes + 1);
    size_t n_away = 0, n_far = 0;
    *n_mended = 0;
    if (!given)
        return sheen_fail_memory(err, (double)size_bytes, "normals");
    memcpy(given, mesh->n_obj, size_bytes);
    sheen_mesh_compute_normals(mesh);
    for (size_t v = 0; v < mesh->n_vertices; v++) {
        const float cosine = sheen_dotf(given + 3 * v, mesh->n_obj + 3 * v);
        n_away += cosine > 0 ? 0 : 1;
        n_far += cosine > 0.5f ? 0 : 1;
    }
    if (5 * n_far > mesh->n_vertices) {
        *n_mended = mesh->n_vertices;
    } else {
        for (size_t v = 0; v < mesh->n_vertices; v++)
            if (sheen_dotf(given + 3 * v, mesh->n_obj + 3 * v) > 0)
                memcpy(mesh->n_obj + 3 * v, given + 3 * v, 3 * sizeof *given);
        *n_mended = n_away;
    }
    free(given);
    return SHEEN_OK;
}

static sheen_status allocate(repair *r, sheen_err *err)
{
    const size_t n = r->mesh->n_triangles, v = r->mesh->n_vertices, most = 3 * n > v ? 3 * n : v;
    for (r->n_slots = 16; r->n_slots < 2 * most; r->n_slots *= 2) {
    }
    r->place = malloc((v + 1) * sizeof *r->place);
    r->slots = malloc(r->n_slots * sizeof *r->slots);
    r->edges = malloc((3 * n + 1) * sizeof *r->edges);
    r->edge_of = malloc((3 * n + 1) * sizeof *r->edge_of);
    r->turned = calloc(n + 1, 1);
    r->part = malloc((n + 1) * sizeof *r->part);
    r->stack = malloc((n + 1) * sizeof *r->stack);
    if (!r->place || !r->slots || !r->edges || !r->edge_of || !r->turned || !r->part || !r->stack)
        return sheen_fail_memory(err, 100.0 * (double)n, "the mesh's edges");
    memset(r->part, 0xff, (n + 1) * sizeof *r->part);
    return SHEEN_OK;
}

sheen_status sheen_mesh_repair(sheen_mesh_repairs *out, sheen_mesh *mesh, sheen_err *err)
{
    repair r = {.mesh = mesh};
    *out = (sheen_mesh_repairs){0};
    sheen_status s = allocate(&r, err);
    if (!s) {
        find_places(&r);
        out->n_doubles = drop_doubles(&r);
        find_edges(&r);
        for (uint32_t t = 0; t < mesh->n_triangles; t++)
            if (r.part[t] == NONE)
                flood(&r, t);
        if (!(s = orient(&r, err))) {
            out->n_turned = turn_over(&r);
            s = mend_normals(&out->n_normals, mesh, err);
        }
    }
    free(r.place);
    free(r.slots);
    free(r.edges);
    free(r.edge_of);
    free(r.turned);
    free(r.part);
    free(r.stack);
    return s;
}

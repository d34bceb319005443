// SPDX-License-Identifier: Apache-2.0
// normal_grid.c - numbers the nodes of a lattice on a mesh, and solves its normal equations without writing them down.
#include "fit/normal_grid.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_ITERATIONS = 40 };

static const double small_enough = 1e-6; // of the squared residual at the start

typedef struct side {
    uint32_t low, high; // vertices
    uint32_t triangle;
    uint8_t corner; // it begins at
} side;

static int compare_sides(const void *a, const void *b)
{
    const side *p = a, *q = b;
    if (p->low != q->low)
        return p->low < q->low ? -1 : 1;
    if (p->high != q->high)
        return p->high < q->high ? -1 : 1;
    return p->triangle < q->triangle ? -1 : p->triangle > q->triangle;
}

// Lattice point number k (1 .. T-2) of a triangle's side, from corner c to the next.
static size_t texel_of_side(int T, int c, int k)
{
    const int last = T - 1;
    return c == 0   ? sheen_texel_index(T, k, 0)
           : c == 1 ? sheen_texel_index(T, last - k, k)
                    : sheen_texel_index(T, 0, last - k);
}

// Points inside of sides: the triangles that share one share them. Returns the next free number.
static size_t number_sides(sheen_normal_grid *g, side *sides, const sheen_mesh *mesh, size_t next)
{
    const int T = g->texels_per_edge;
    const size_t per_triangle = sheen_texels_per_triangle(T), n = 3 * mesh->n_triangles;
    for (size_t f = 0; f < mesh->n_triangles; f++)
        for (uint8_t c = 0; c < 3; c++) {
            const uint32_t a = mesh->triangles[3 * f + c], b = mesh->triangles[3 * f + (c + 1u) % 3];
            sides[3 * f + c] = (side){a < b ? a : b, a < b ? b : a, (uint32_t)f, c};
        }
    qsort(sides, n, sizeof *sides, compare_sides);
    for (size_t i = 0; i < n; i++) {
        const side *s = &sides[i];
        if (i && (s->low != sides[i - 1].low || s->high != sides[i - 1].high))
            next += (size_t)(T - 2);
        const int forwards = mesh->triangles[3 * s->triangle + s->corner] == s->low;
        for (int k = 1; k < T - 1; k++) {
            const size_t number = next + (size_t)((forwards ? k : T - 1 - k) - 1);
            g->node[s->triangle * per_triangle + texel_of_side(T, s->corner, k)] = (uint32_t)number;
        }
    }
    return next + (size_t)(T - 2);
}

static void add_link(sheen_normal_grid *g, const uint32_t *node, size_t a, size_t b)
{
    g->link[2 * g->n_links] = node[a];
    g->link[2 * g->n_links++ + 1] = node[b];
}

static void link_triangle(sheen_normal_grid *g, size_t triangle)
{
    const int T = g->texels_per_edge;
    const uint32_t *node = g->node + triangle * sheen_texels_per_triangle(T);
    for (int j = 0; j < T - 1; j++)
        for (int i = 0; i + j < T - 1; i++) {
            const size_t here = sheen_texel_index(T, i, j), right = sheen_texel_index(T, i + 1, j),
                         up = sheen_texel_index(T, i, j + 1);
            add_link(g, node, here, right);
            add_link(g, node, here, up);
            add_link(g, node, right, up);
        }
}

sheen_status sheen_normal_grid_init(sheen_normal_grid *g, const sheen_mesh *mesh, int texels_per_edge,
                                    sheen_err *err)
{
    const int T = texels_per_edge;
    const size_t n_triangles = mesh->n_triangles, per_triangle = sheen_texels_per_triangle(T);
    const size_t n_links = n_triangles * 3 * sheen_texels_per_triangle(T - 1);
    *g = (sheen_normal_grid){.texels_per_edge = T, .n_triangles = n_triangles};
    if (n_triangles * per_triangle > UINT32_MAX / 2)
        return sheen_fail(err, SHEEN_EARG, "%zu triangles of %zu texels are too many for a normal map",
                          n_triangles, per_triangle);
    side *sides = malloc(3 * n_triangles * sizeof *sides);
    g->node = malloc(n_triangles * per_triangle * sizeof *g->node);
    g->link = malloc(2 * n_links * sizeof *g->link);
    if (!sides || !g->node || !g->link) {
        free(sides);
        sheen_normal_grid_release(g);
        return sheen_fail_memory(err, 8.0 * (double)(n_links + n_triangles * per_triangle), "a normal map");
    }
    size_t next = number_sides(g, sides, mesh, mesh->n_vertices);
    free(sides);
    for (size_t f = 0; f < n_triangles; f++) {
        uint32_t *node = g->node + f * per_triangle;
        for (int j = 1; j < T - 1; j++)
            for (int i = 1; i + j < T - 1; i++)
                node[sheen_texel_index(T, i, j)] = (uint32_t)next++;
        node[0] = mesh->triangles[3 * f];
        node[sheen_texel_index(T, T - 1, 0)] = mesh->triangles[3 * f + 1];
        node[sheen_texel_index(T, 0, T - 1)] = mesh->triangles[3 * f + 2];
        link_triangle(g, f);
    }
    g->n_nodes = next;
    return SHEEN_OK;
}

void sheen_normal_grid_release(sheen_normal_grid *g)
{
    free(g->node);
    free(g->link);
    *g = (sheen_normal_grid){0};
}

typedef struct system {
    const sheen_normal_grid *grid;
    const sheen_normal_row *rows;
    size_t n_rows, n; // n: 3 numbers a node
    float stiffness, pull;
} system_of;

static void times_H(float out[3], const float H[6], const float x[3])
{
    out[0] = H[0] * x[0] + H[1] * x[1] + H[3] * x[2];
    out[1] = H[1] * x[0] + H[2] * x[1] + H[4] * x[2];
    out[2] = H[3] * x[0] + H[4] * x[1] + H[5] * x[2];
}

static void at_row(float out[3], const sheen_normal_row *row, const float *x)
{
    out[0] = out[1] = out[2] = 0;
    for (int k = 0; k < 3; k++)
        for (int c = 0; c < 3; c++)
            out[c] += row->weight[k] * x[3 * (size_t)row->node[k] + (size_t)c];
}

static void spread_row(float *y, const sheen_normal_row *row, const float value[3])
{
    for (int k = 0; k < 3; k++)
        for (int c = 0; c < 3; c++)
            y[3 * (size_t)row->node[k] + (size_t)c] += row->weight[k] * value[c];
}

static void multiply(float *y, const system_of *s, const float *x)
{
    for (size_t i = 0; i < s->n; i++)
        y[i] = s->pull * x[i];
    for (size_t i = 0; i < s->grid->n_links; i++) {
        const size_t a = 3 * (size_t)s->grid->link[2 * i], b = 3 * (size_t)s->grid->link[2 * i + 1];
        for (size_t c = 0; c < 3; c++) {
            const float pull = s->stiffness * (x[a + c] - x[b + c]);
            y[a + c] += pull;
            y[b + c] -= pull;
        }
    }
    for (size_t i = 0; i < s->n_rows; i++) {
        float at[3], force[3];
        at_row(at, &s->rows[i], x);
        times_H(force, s->rows[i].H, at);
        spread_row(y, &s->rows[i], force);
    }
}

// Residual of the equations at x = d, and the diagonal for the preconditioner.
static void start(float *residual, float *diagonal, const system_of *s, const float *d, float *scratch)
{
    multiply(scratch, s, d);
    for (size_t i = 0; i < s->n; i++) {
        residual[i] = -scratch[i];
        diagonal[i] = s->pull;
    }
    for (size_t i = 0; i < 2 * s->grid->n_links; i++)
        for (size_t c = 0; c < 3; c++)
            diagonal[3 * (size_t)s->grid->link[i] + c] += s->stiffness;
    for (size_t i = 0; i < s->n_rows; i++) {
        const sheen_normal_row *row = &s->rows[i];
        float at[3], force[3]; // the row speaks of changes: b + H d0 on the right
        at_row(at, row, d);
        times_H(force, row->H, at);
        for (int c = 0; c < 3; c++)
            force[c] += row->b[c];
        spread_row(residual, row, force);
        const float own[3] = {row->H[0], row->H[2], row->H[5]};
        for (int k = 0; k < 3; k++)
            for (int c = 0; c < 3; c++)
                diagonal[3 * (size_t)row->node[k] + (size_t)c] += row->weight[k] * row->weight[k] * own[c];
    }
}

static double dot(const float *a, const float *b, size_t n)
{
    double sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += (double)a[i] * (double)b[i];
    return sum;
}

static void conjugate_gradients(float *d, const system_of *s, float *room)
{
    const size_t n = s->n;
    float *residual = room, *diagonal = room + n, *direction = room + 2 * n, *product = room + 3 * n,
          *scaled = room + 4 * n;
    start(residual, diagonal, s, d, product);
    for (size_t i = 0; i < n; i++)
        direction[i] = scaled[i] = residual[i] / diagonal[i];
    double before = dot(residual, scaled, n);
    const double enough = small_enough * before;
    for (int k = 0; k < MAX_ITERATIONS && before > enough; k++) {
        multiply(product, s, direction);
        const float step = (float)(before / dot(direction, product, n));
        for (size_t i = 0; i < n; i++) {
            d[i] += step * direction[i];
            residual[i] -= step * product[i];
            scaled[i] = residual[i] / diagonal[i];
        }
        const double after = dot(residual, scaled, n);
        const float share = (float)(after / before);
        for (size_t i = 0; i < n; i++)
            direction[i] = scaled[i] + share * direction[i];
        before = after;
    }
}

sheen_status sheen_normal_grid_solve(float *d, const sheen_normal_grid *g, const sheen_normal_row *rows,
                                     size_t n_rows, const sheen_normal_prior *prior, sheen_err *err)
{
    const system_of s = {.grid = g,
                         .rows = rows,
                         .n_rows = n_rows,
                         .n = 3 * g->n_nodes,
                         .stiffness = (float)prior->stiffness,
                         .pull = (float)(prior->stiffness / (prior->reach * prior->reach))};
    float *room = malloc(5 * s.n * sizeof *room);
    if (!room)
        return sheen_fail_memory(err, (double)(5 * s.n * sizeof *room), "a normal map's equations");
    conjugate_gradients(d, &s, room);
    free(room);
    return SHEEN_OK;
}

// SPDX-License-Identifier: Apache-2.0
// normal_grid.c - numbers the nodes of a lattice on a mesh, and solves its normal equations without writing them down.
#include "fit/normal_grid.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"

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

typedef void link_visitor(sheen_normal_grid *g, uint32_t a, uint32_t b);

static void count_link(sheen_normal_grid *g, uint32_t a, uint32_t b)
{
    g->first[a + 1]++;
    g->first[b + 1]++;
}

static void write_link(sheen_normal_grid *g, uint32_t a, uint32_t b)
{
    g->neighbour[g->first[a]++] = b;
    g->neighbour[g->first[b]++] = a;
}

static void visit_links(sheen_normal_grid *g, link_visitor *visit)
{
    const int T = g->texels_per_edge;
    const size_t per_triangle = sheen_texels_per_triangle(T);
    for (size_t f = 0; f < g->n_triangles; f++) {
        const uint32_t *node = g->node + f * per_triangle;
        for (int j = 0; j < T - 1; j++)
            for (int i = 0; i + j < T - 1; i++) {
                const uint32_t here = node[sheen_texel_index(T, i, j)],
                               right = node[sheen_texel_index(T, i + 1, j)],
                               up = node[sheen_texel_index(T, i, j + 1)];
                visit(g, here, right);
                visit(g, here, up);
                visit(g, right, up);
            }
    }
}

// Anew in the order in which triangles come to them: what is near on the surface is near in memory.
static sheen_status renumber(sheen_normal_grid *g, sheen_err *err)
{
    uint32_t *number = malloc((g->n_nodes + 1) * sizeof *number), next = 0;
    if (!number)
        return sheen_fail_memory(err, 4.0 * (double)g->n_nodes, "a normal map");
    memset(number, 0xff, g->n_nodes * sizeof *number);
    for (size_t i = 0; i < g->n_triangles * sheen_texels_per_triangle(g->texels_per_edge); i++) {
        uint32_t *to = &number[g->node[i]];
        if (*to == UINT32_MAX)
            *to = next++;
        g->node[i] = *to;
    }
    free(number);
    g->n_nodes = next; // a vertex without triangles is none
    return SHEEN_OK;
}

// Each node's neighbours side by side.
static sheen_status link_nodes(sheen_normal_grid *g, sheen_err *err)
{
    const size_t n_links = g->n_triangles * 3 * sheen_texels_per_triangle(g->texels_per_edge - 1);
    g->first = calloc(g->n_nodes + 2, sizeof *g->first);
    g->neighbour = malloc((2 * n_links + 1) * sizeof *g->neighbour);
    if (!g->first || !g->neighbour || n_links > UINT32_MAX / 2)
        return sheen_fail_memory(err, 8.0 * (double)n_links, "a normal map");
    visit_links(g, count_link);
    for (size_t i = 0; i < g->n_nodes; i++)
        g->first[i + 1] += g->first[i];
    visit_links(g, write_link); // leaves each node's first at the next one's
    memmove(g->first + 1, g->first, g->n_nodes * sizeof *g->first);
    g->first[0] = 0;
    return SHEEN_OK;
}

sheen_status sheen_normal_grid_init(sheen_normal_grid *g, const sheen_mesh *mesh, int texels_per_edge,
                                    sheen_err *err)
{
    const int T = texels_per_edge;
    const size_t n_triangles = mesh->n_triangles, per_triangle = sheen_texels_per_triangle(T);
    *g = (sheen_normal_grid){.texels_per_edge = T, .n_triangles = n_triangles};
    if (n_triangles * per_triangle > UINT32_MAX / 2)
        return sheen_fail(err, SHEEN_EARG, "%zu triangles of %zu texels are too many for a normal map",
                          n_triangles, per_triangle);
    side *sides = malloc(3 * n_triangles * sizeof *sides);
    g->node = calloc(n_triangles * per_triangle + 1, sizeof *g->node);
    if (!sides || !g->node) {
        free(sides);
        sheen_normal_grid_release(g);
        return sheen_fail_memory(err, 4.0 * (double)(n_triangles * per_triangle), "a normal map");
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
    }
    g->n_nodes = next;
    sheen_status s = renumber(g, err);
    if (!s)
        s = link_nodes(g, err);
    if (s)
        sheen_normal_grid_release(g);
    return s;
}

void sheen_normal_grid_release(sheen_normal_grid *g)
{
    free(g->node);
    free(g->first);
    free(g->neighbour);
    *g = (sheen_normal_grid){0};
}

// Unknowns are kept four floats a node, the last one 0, which suits vectors.
enum { WIDTH = 4, NODES_PIECE = 4096, ROWS_PIECE = 1024 };

typedef struct system {
    const sheen_normal_grid *grid;
    const sheen_normal_row *rows;
    size_t n_rows;
    uint32_t *row_first, *row_entry; // [n_nodes + 1], [3 n_rows]: 3 row + k of the rows that a node bears on
    float stiffness, pull;
    int n_threads;
    float *d, *residual, *direction, *inverse_diagonal, *product; // [n_nodes][WIDTH]
    float *force;                                                 // [n_rows][WIDTH]
    float step, share;
    double *sum; // of each piece of nodes
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
        for (size_t c = 0; c < 3; c++)
            out[c] += row->weight[k] * x[WIDTH * (size_t)row->node[k] + c];
}

// What the rows say of a node: sum of their forces.
static void add_forces(float y[WIDTH], const system_of *s, size_t node)
{
    for (uint32_t e = s->row_first[node]; e < s->row_first[node + 1]; e++) {
        const uint32_t row = s->row_entry[e] / 3;
        const float weight = s->rows[row].weight[s->row_entry[e] % 3];
        const float *force = s->force + WIDTH * (size_t)row;
        for (int c = 0; c < WIDTH; c++)
            y[c] += weight * force[c];
    }
}

// y = A x at one node; the rows' forces are there.
static void multiply_node(float y[WIDTH], const system_of *s, const float *x, size_t node)
{
    const uint32_t begin = s->grid->first[node], end = s->grid->first[node + 1];
    const float own = s->pull + s->stiffness * (float)(end - begin);
    float about[WIDTH] = {0};
    for (uint32_t e = begin; e < end; e++) {
        const float *other = x + WIDTH * (size_t)s->grid->neighbour[e];
        for (int c = 0; c < WIDTH; c++)
            about[c] += other[c];
    }
    for (int c = 0; c < WIDTH; c++)
        y[c] = own * x[WIDTH * node + (size_t)c] - s->stiffness * about[c];
    add_forces(y, s, node);
}

static void run_rows(system_of *s, void (*body)(void *self, size_t begin, size_t end))
{
    sheen_parallel_for(s->n_rows, ROWS_PIECE, s->n_threads, body, s);
}

// Over all nodes; returns the sum of what the pieces left in s->sum, in their order.
static double run_nodes(system_of *s, void (*body)(void *self, size_t begin, size_t end))
{
    const size_t n = s->grid->n_nodes, n_pieces = (n + NODES_PIECE - 1) / NODES_PIECE;
    memset(s->sum, 0, n_pieces * sizeof *s->sum);
    sheen_parallel_for(n, NODES_PIECE, s->n_threads, body, s);
    double sum = 0;
    for (size_t i = 0; i < n_pieces; i++)
        sum += s->sum[i];
    return sum;
}

// Rows speak of changes from the d that there is: b + H d0 on the right and H d0 on the left leave b.
static void start_rows(void *self, size_t begin, size_t end)
{
    system_of *s = self;
    for (size_t i = begin; i < end; i++)
        for (size_t c = 0; c < WIDTH; c++)
            s->force[WIDTH * i + c] = c < 3 ? -s->rows[i].b[c] : 0;
}

static void start_nodes(void *self, size_t begin, size_t end)
{
    system_of *s = self;
    double sum = 0;
    for (size_t i = begin; i < end; i++) {
        float minus_residual[WIDTH], diagonal[WIDTH];
        multiply_node(minus_residual, s, s->d, i);
        for (int c = 0; c < WIDTH; c++)
            diagonal[c] = s->pull + s->stiffness * (float)(s->grid->first[i + 1] - s->grid->first[i]);
        for (uint32_t e = s->row_first[i]; e < s->row_first[i + 1]; e++) {
            const sheen_normal_row *row = &s->rows[s->row_entry[e] / 3];
            const float w = row->weight[s->row_entry[e] % 3], own[3] = {row->H[0], row->H[2], row->H[5]};
            for (int c = 0; c < 3; c++)
                diagonal[c] += w * w * own[c];
        }
        for (size_t c = 0; c < WIDTH; c++) {
            const size_t k = WIDTH * i + c;
            s->inverse_diagonal[k] = 1 / diagonal[c];
            s->residual[k] = -minus_residual[c];
            s->direction[k] = s->residual[k] * s->inverse_diagonal[k];
            sum += (double)(s->residual[k] * s->direction[k]);
        }
    }
    s->sum[begin / NODES_PIECE] = sum;
}

static void multiply_rows(void *self, size_t begin, size_t end)
{
    system_of *s = self;
    for (size_t i = begin; i < end; i++) {
        float at[3];
        at_row(at, &s->rows[i], s->direction);
        times_H(s->force + WIDTH * i, s->rows[i].H, at);
    }
}

static void multiply_nodes(void *self, size_t begin, size_t end)
{
    system_of *s = self;
    double sum = 0;
    for (size_t i = begin; i < end; i++) {
        float y[WIDTH];
        multiply_node(y, s, s->direction, i);
        memcpy(s->product + WIDTH * i, y, sizeof y);
        for (size_t c = 0; c < WIDTH; c++)
            sum += (double)(y[c] * s->direction[WIDTH * i + c]);
    }
    s->sum[begin / NODES_PIECE] = sum;
}

static void step_nodes(void *self, size_t begin, size_t end)
{
    system_of *s = self;
    double sum = 0;
    for (size_t k = WIDTH * begin; k < WIDTH * end; k++) {
        s->d[k] += s->step * s->direction[k];
        s->residual[k] -= s->step * s->product[k];
        sum += (double)(s->residual[k] * s->residual[k] * s->inverse_diagonal[k]);
    }
    s->sum[begin / NODES_PIECE] = sum;
}

static void turn_nodes(void *self, size_t begin, size_t end)
{
    system_of *s = self;
    for (size_t k = WIDTH * begin; k < WIDTH * end; k++)
        s->direction[k] = s->residual[k] * s->inverse_diagonal[k] + s->share * s->direction[k];
}

static void conjugate_gradients(system_of *s)
{
    run_rows(s, start_rows);
    double before = run_nodes(s, start_nodes);
    const double enough = small_enough * before;
    for (int k = 0; k < MAX_ITERATIONS && before > enough; k++) {
        run_rows(s, multiply_rows);
        s->step = (float)(before / run_nodes(s, multiply_nodes));
        const double after = run_nodes(s, step_nodes);
        s->share = (float)(after / before);
        run_nodes(s, turn_nodes);
        before = after;
    }
}

// Which rows bear on a node, by counting.
static void index_rows(system_of *s)
{
    const size_t n = s->grid->n_nodes;
    uint32_t *first = s->row_first; // zero
    for (size_t e = 0; e < 3 * s->n_rows; e++)
        first[s->rows[e / 3].node[e % 3] + 1]++;
    for (size_t i = 0; i < n; i++)
        first[i + 1] += first[i];
    for (size_t e = 0; e < 3 * s->n_rows; e++)
        s->row_entry[first[s->rows[e / 3].node[e % 3]]++] = (uint32_t)e;
    memmove(first + 1, first, n * sizeof *first);
    first[0] = 0;
}

static void release_system(system_of *s)
{
    free(s->row_first);
    free(s->row_entry);
    free(s->d);
    free(s->force);
    free(s->sum);
}

static sheen_status open_system(system_of *s, sheen_err *err)
{
    const size_t n = s->grid->n_nodes;
    s->row_first = calloc(n + 2, sizeof *s->row_first);
    s->row_entry = malloc((3 * s->n_rows + 1) * sizeof *s->row_entry);
    s->d = calloc(5 * WIDTH * n + 1, sizeof *s->d);
    s->force = calloc(WIDTH * s->n_rows + 1, sizeof *s->force);
    s->sum = malloc((n / NODES_PIECE + 1) * sizeof *s->sum);
    if (!s->row_first || !s->row_entry || !s->d || !s->force || !s->sum)
        return sheen_fail_memory(err, (double)(5 * WIDTH * n * sizeof *s->d), "a normal map's equations");
    s->residual = s->d + WIDTH * n;
    s->direction = s->residual + WIDTH * n;
    s->inverse_diagonal = s->direction + WIDTH * n;
    s->product = s->inverse_diagonal + WIDTH * n;
    index_rows(s);
    return SHEEN_OK;
}

sheen_status sheen_normal_grid_solve(float *d, const sheen_normal_grid *g, const sheen_normal_row *rows,
                                     size_t n_rows, const sheen_normal_prior *prior, int n_threads,
                                     sheen_err *err)
{
    system_of s = {.grid = g,
                   .rows = rows,
                   .n_rows = n_rows,
                   .stiffness = (float)prior->stiffness,
                   .pull = (float)(prior->stiffness / (prior->reach * prior->reach)),
                   .n_threads = n_threads};
    const sheen_status status = open_system(&s, err);
    if (!status) {
        for (size_t i = 0; i < g->n_nodes; i++)
            memcpy(s.d + WIDTH * i, d + 3 * i, 3 * sizeof *d);
        conjugate_gradients(&s);
        for (size_t i = 0; i < g->n_nodes; i++)
            memcpy(d + 3 * i, s.d + WIDTH * i, 3 * sizeof *d);
    }
    release_system(&s);
    return status;
}

// SPDX-License-Identifier: Apache-2.0
// geodesic.c - nodes of the illumination hemisphere (section 4.1) and the search for the nearest one.
//
// Nodes come in the order: corners of the icosahedron, its edges, its faces; those below the horizon are left
// out. For the search the hemisphere is laid out on a square (the octahedron's upper half, turned by 45
// degrees: u = (x + y) / s, v = (x - y) / s, s = |x| + |y| + z), cut into cells. Great circles bound the
// cells, or halve them at the octahedron's edges, so a cell lies within the angle from its centre to its
// farthest corner. Each cell lists every node which may be the nearest to a direction in it, so a search
// looks at one list.
#include "render/geodesic.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"

static const double pi = 3.14159265358979323846;

enum { N_CORNERS = 12, N_EDGES = 30, N_FACES = 20 };

// One corner is +z, one -z; between them two rings of five at z = 1/sqrt(5) and -1/sqrt(5).
static void icosahedron_corners(double corner[N_CORNERS][3])
{
    const double z = 1 / sqrt(5.0), r = 2 / sqrt(5.0);
    memset(corner, 0, N_CORNERS * sizeof *corner);
    corner[0][2] = 1;
    corner[11][2] = -1;
    for (int i = 0; i < 5; i++) {
        const double upper_rad = 2 * pi * i / 5, lower_rad = upper_rad + pi / 5;
        const double upper[3] = {r * cos(upper_rad), r * sin(upper_rad), z};
        const double lower[3] = {r * cos(lower_rad), r * sin(lower_rad), -z};
        memcpy(corner[1 + i], upper, sizeof upper);
        memcpy(corner[6 + i], lower, sizeof lower);
    }
}

// Edges and faces by index: two corners are neighbours where their distance is the icosahedron's edge.
static void icosahedron_sides(double corner[N_CORNERS][3], int edge[N_EDGES][2], int face[N_FACES][3])
{
    int n_edges = 0, n_faces = 0;
    int near[N_CORNERS][N_CORNERS];
    for (int a = 0; a < N_CORNERS; a++)
        for (int b = 0; b < N_CORNERS; b++)
            near[a][b] = a != b &&
                         sheen_dot(corner[a], corner[b]) > 0.4; // neighbours have 1 / sqrt(5) = 0.447
    for (int a = 0; a < N_CORNERS; a++)
        for (int b = a + 1; b < N_CORNERS; b++) {
            if (!near[a][b])
                continue;
            edge[n_edges][0] = a;
            edge[n_edges++][1] = b;
            for (int c = b + 1; c < N_CORNERS; c++)
                if (near[a][c] && near[b][c]) {
                    face[n_faces][0] = a;
                    face[n_faces][1] = b;
                    face[n_faces++][2] = c;
                }
        }
    assert(n_edges == N_EDGES && n_faces == N_FACES);
}

// Appends the unit vector along wa a + wb b + wc c, unless it is below the horizon.
static void add_node(sheen_geodesic *g, const double a[3], double wa, const double b[3], double wb,
                     const double c[3], double wc)
{
    double p[3];
    for (int k = 0; k < 3; k++)
        p[k] = wa * a[k] + wb * b[k] + wc * c[k];
    sheen_normalize(p);
    if (p[2] < -1e-9)
        return;
    if (p[2] < 1e-9)
        p[2] = 0;
    for (int k = 0; k < 3; k++)
        g->v_world[3 * g->n_nodes + (size_t)k] = (float)p[k];
    g->n_nodes++;
}

static void add_nodes(sheen_geodesic *g)
{
    double corner[N_CORNERS][3];
    int edge[N_EDGES][2], face[N_FACES][3];
    icosahedron_corners(corner);
    icosahedron_sides(corner, edge, face);
    const int f = g->frequency;
    for (int i = 0; i < N_CORNERS; i++)
        add_node(g, corner[i], 1, corner[i], 0, corner[i], 0);
    for (int e = 0; e < N_EDGES; e++)
        for (int i = 1; i < f; i++)
            add_node(g, corner[edge[e][0]], f - i, corner[edge[e][1]], i, corner[0], 0);
    for (int t = 0; t < N_FACES; t++)
        for (int j = 1; j < f - 1; j++)
            for (int i = 1; i < f - j; i++)
                add_node(g, corner[face[t][0]], f - i - j, corner[face[t][1]], i, corner[face[t][2]], j);
}

// The square's place of a direction, -1..1 each. Below the horizon: of the horizon's point under it.
static void square_of(float uv[2], const float v[3])
{
    const float s = fabsf(v[0]) + fabsf(v[1]) + (v[2] > 0 ? v[2] : 0);
    uv[0] = s > 0 ? (v[0] + v[1]) / s : 0;
    uv[1] = s > 0 ? (v[0] - v[1]) / s : 0;
}

static void direction_of(float v[3], float uu, float vv)
{
    v[0] = 0.5f * (uu + vv);
    v[1] = 0.5f * (uu - vv);
    v[2] = 1 - fabsf(v[0]) - fabsf(v[1]);
    if (v[2] < 0)
        v[2] = 0;
    sheen_normalizef(v);
}

static int cell_along(const sheen_geodesic *g, float u)
{
    const int i = (int)((u + 1) * 0.5f * (float)g->n_cells_side);
    return i < 0 ? 0 : i >= g->n_cells_side ? g->n_cells_side - 1 : i;
}

// Index of the cell of a direction; its column and row too, where wanted.
static size_t cell_of(const sheen_geodesic *g, const float v[3], int column_row[2])
{
    float uv[2];
    square_of(uv, v);
    const int column = cell_along(g, uv[0]), row = cell_along(g, uv[1]);
    if (column_row) {
        column_row[0] = column;
        column_row[1] = row;
    }
    return (size_t)row * (size_t)g->n_cells_side + (size_t)column;
}

static float angle_between(const float a[3], const float b[3])
{
    float across[3];
    sheen_crossf(across, a, b);
    return atan2f(sqrtf(sheen_dotf(across, across)), sheen_dotf(a, b));
}

// Centre of a cell, and the angle from it to the farthest corner.
static float cell_cone(const sheen_geodesic *g, int column, int row, float centre[3])
{
    const float step = 2.0f / (float)g->n_cells_side;
    direction_of(centre, -1 + step * ((float)column + 0.5f), -1 + step * ((float)row + 0.5f));
    float radius_rad = 0;
    for (int k = 0; k < 4; k++) {
        float corner[3];
        direction_of(corner, -1 + step * (float)(column + (k & 1)), -1 + step * (float)(row + (k >> 1)));
        radius_rad = fmaxf(radius_rad, angle_between(centre, corner));
    }
    return radius_rad * 1.0001f + 1e-6f;
}

// Cells on either side in which something may lie that is angle_rad from a direction: the square's coordinates
// change by at most sqrt(2) (1 + sqrt(3)) < 3.9 per radian.
static int window_cells(const sheen_geodesic *g, float angle_rad)
{
    const float cells = 3.9f * angle_rad * 0.5f * (float)g->n_cells_side;
    return cells < (float)g->n_cells_side ? (int)cells + 1 : g->n_cells_side;
}

typedef struct cones {
    float (*centre)[3];
    float *cos_reach; // of the cell's radius + reach_rad
    float radius_max_rad;
} cones;

// Visits the cells whose cone (with reach) holds the node; adds the node to each, or counts only.
static void list_node(sheen_geodesic *g, const cones *c, size_t node, int window, uint32_t *fill)
{
    const float *v = g->v_world + 3 * node;
    int at[2];
    cell_of(g, v, at);
    const int side = g->n_cells_side;
    const int row0 = at[1] - window < 0 ? 0 : at[1] - window,
              row1 = at[1] + window < side ? at[1] + window : side - 1;
    const int col0 = at[0] - window < 0 ? 0 : at[0] - window,
              col1 = at[0] + window < side ? at[0] + window : side - 1;
    for (int row = row0; row <= row1; row++)
        for (int column = col0; column <= col1; column++) {
            const size_t cell = (size_t)row * (size_t)side + (size_t)column;
            if (sheen_dotf(v, c->centre[cell]) < c->cos_reach[cell])
                continue;
            if (g->cell_nodes)
                g->cell_nodes[fill[cell]] = (uint32_t)node;
            fill[cell]++;
        }
}

static void make_cones(cones *c, const sheen_geodesic *g, float reach_rad)
{
    for (int row = 0; row < g->n_cells_side; row++)
        for (int column = 0; column < g->n_cells_side; column++) {
            const size_t cell = (size_t)row * (size_t)g->n_cells_side + (size_t)column;
            const float radius_rad = cell_cone(g, column, row, c->centre[cell]);
            const float reach = fminf(radius_rad + reach_rad, 3.1415926f);
            c->cos_reach[cell] = cosf(reach) - 1e-6f;
            c->radius_max_rad = fmaxf(c->radius_max_rad, radius_rad);
        }
}

// Twice the expected distance of neighbours: the hexagonal lattice of this density.
static float reach_of(const sheen_geodesic *g)
{
    const double area_sr = 2 * pi / (double)g->n_nodes;
    return (float)(2 * sqrt(area_sr * 2 / sqrt(3.0)));
}

static sheen_status make_cells(sheen_geodesic *g, sheen_err *err)
{
    const int side = (int)ceil(sqrt((double)g->n_nodes / 4));
    g->n_cells_side = side;
    const size_t n_cells = (size_t)side * (size_t)side;
    sheen_status s = SHEEN_OK;
    cones c = {calloc(n_cells, sizeof *c.centre), calloc(n_cells, sizeof *c.cos_reach), 0};
    uint32_t *fill = calloc(n_cells + 1, sizeof *fill);
    g->cell_start = calloc(n_cells + 1, sizeof *g->cell_start);
    if (!c.centre || !c.cos_reach || !fill || !g->cell_start) {
        s = sheen_fail_memory(err, (double)(n_cells * 24), "the illumination hemisphere's search grid");
        goto done;
    }
    const float reach_rad = reach_of(g);
    make_cones(&c, g, reach_rad);
    const int window = window_cells(g, c.radius_max_rad + reach_rad) + 1;
    for (size_t i = 0; i < g->n_nodes; i++)
        list_node(g, &c, i, window, fill);
    for (size_t i = 0; i < n_cells; i++) {
        g->cell_start[i + 1] = g->cell_start[i] + fill[i];
        fill[i] = g->cell_start[i];
    }
    g->cell_nodes = calloc((size_t)g->cell_start[n_cells] + 1, sizeof *g->cell_nodes);
    if (!g->cell_nodes) {
        s = sheen_fail_memory(err, 4.0 * (double)g->cell_start[n_cells],
                              "the illumination hemisphere's search grid");
        goto done;
    }
    for (size_t i = 0; i < g->n_nodes; i++)
        list_node(g, &c, i, window, fill);

done:
    free(c.centre);
    free(c.cos_reach);
    free(fill);
    return s;
}

// The listed node nearest to v, other than `but` (SIZE_MAX: any).
static uint32_t nearest_but(const sheen_geodesic *g, const float v[3], size_t but)
{
    const size_t cell = cell_of(g, v, NULL);
    uint32_t best = UINT32_MAX;
    float best_cos = -2;
    for (uint32_t k = g->cell_start[cell]; k < g->cell_start[cell + 1]; k++) {
        const uint32_t node = g->cell_nodes[k];
        const float c = sheen_dotf(v, g->v_world + 3 * (size_t)node);
        if (c > best_cos && node != but) {
            best_cos = c;
            best = node;
        }
    }
    return best;
}

sheen_status sheen_geodesic_init(sheen_geodesic *g, int frequency, sheen_err *err)
{
    *g = (sheen_geodesic){.frequency = frequency};
    if (frequency < 1 || frequency > SHEEN_GEODESIC_MAX_FREQUENCY)
        return sheen_fail(err, SHEEN_EARG, "a geodesic hemisphere of frequency %d is out of range (1 to %d)",
                          frequency, SHEEN_GEODESIC_MAX_FREQUENCY);
    const size_t most = 10 * (size_t)frequency * (size_t)frequency + 2;
    g->v_world = malloc(most * 3 * sizeof *g->v_world);
    if (!g->v_world)
        return sheen_fail_memory(err, 12.0 * (double)most, "the illumination hemisphere");
    add_nodes(g);
    const sheen_status s = make_cells(g, err);
    if (s) {
        sheen_geodesic_release(g);
        return s;
    }
    double sum_rad = 0;
    for (size_t i = 0; i < g->n_nodes; i++) {
        const uint32_t other = nearest_but(g, g->v_world + 3 * i, i);
        sum_rad += (double)angle_between(g->v_world + 3 * i, g->v_world + 3 * (size_t)other);
    }
    g->spacing_rad = (float)(sum_rad / (double)g->n_nodes);
    return SHEEN_OK;
}

void sheen_geodesic_release(sheen_geodesic *g)
{
    free(g->v_world);
    free(g->cell_start);
    free(g->cell_nodes);
    *g = (sheen_geodesic){0};
}

uint32_t sheen_geodesic_nearest(const sheen_geodesic *g, const float v_world[3])
{
    if (!(v_world[2] >= -sinf(0.5f * g->spacing_rad)))
        return UINT32_MAX;
    return nearest_but(g, v_world, SIZE_MAX);
}

// All nodes one after another: ascending by itself.
static size_t within_all(const sheen_geodesic *g, uint32_t *out, size_t max_out, const float v[3],
                         float cos_angle)
{
    size_t n = 0;
    for (size_t i = 0; i < g->n_nodes; i++)
        if (sheen_dotf(v, g->v_world + 3 * i) >= cos_angle) {
            if (n < max_out)
                out[n] = (uint32_t)i;
            n++;
        }
    return n;
}

static int ascending(const void *a, const void *b)
{
    const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return x < y ? -1 : x > y;
}

size_t sheen_geodesic_within(const sheen_geodesic *g, uint32_t *out, size_t max_out, const float v_world[3],
                             float angle_rad)
{
    const float cos_angle = cosf(fminf(angle_rad, 3.1415926f));
    const int window = window_cells(g, angle_rad + fmaxf(0, -v_world[2])) + 1;
    if (2 * window + 1 >= g->n_cells_side)
        return within_all(g, out, max_out, v_world, cos_angle);
    int at[2];
    cell_of(g, v_world, at);
    size_t n = 0;
    for (int row = at[1] - window; row <= at[1] + window; row++)
        for (int column = at[0] - window; column <= at[0] + window; column++) {
            if (row < 0 || column < 0 || row >= g->n_cells_side || column >= g->n_cells_side)
                continue;
            const size_t cell = (size_t)row * (size_t)g->n_cells_side + (size_t)column;
            for (uint32_t k = g->cell_start[cell]; k < g->cell_start[cell + 1]; k++) {
                const uint32_t node = g->cell_nodes[k];
                const float *p = g->v_world + 3 * (size_t)node;
                // A node stands in several cells' lists; it counts in its own.
                if (sheen_dotf(v_world, p) < cos_angle || cell_of(g, p, NULL) != cell)
                    continue;
                if (n == max_out)
                    return within_all(g, out, max_out, v_world, cos_angle);
                out[n++] = node;
            }
        }
    if (n)
        qsort(out, n, sizeof *out, ascending);
    return n;
}

double sheen_geodesic_solid_angle_sr(const sheen_geodesic *g)
{
    return 2 * pi / (double)g->n_nodes;
}

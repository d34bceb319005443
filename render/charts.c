// SPDX-License-Identifier: Apache-2.0
// charts.c - charts grown over neighbours that face the same way, laid flat along their axis, packed on shelves.
//
// A chart takes the triangles that can be reached from its first one and face within some 50 degrees of it, so that laying
// it flat shortens nothing to less than 0.64. Where a chart folds over itself (two of its triangles would share a pixel)
// the later triangle is left for another chart.
#include "render/charts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"

static const float least_cosine = 0.64f;
static const int gutter_px = 3; // about each chart
enum { FIRST_SIDE_PX = 64, NO_CHART = -1 };

typedef struct chart {
    uint32_t first, count; // in cutting.order
    float axis_obj[3], right_obj[3], down_obj[3];
    float min_m[2], max_m[2]; // along right and down
    int x0_px, y0_px, width_px, height_px;
} chart;

typedef struct cutting {
    const sheen_mesh *mesh;
    float *normal;       // [n_triangles][3]
    uint32_t *neighbour; // [n_triangles][3] across the edge that begins at a corner; UINT32_MAX: none
    int *chart_of;       // [n_triangles]
    uint32_t *order;     // triangles, chart by chart
    chart *charts;
    size_t n_charts, n_ordered;
    float texel_m;
    uint32_t *owner; // pixels of one chart: its triangle + 1
    size_t owner_capacity;
} cutting;

void sheen_charts_release(sheen_charts *c)
{
    free(c->triangles);
    free(c->vertex);
    free(c->q_px);
    *c = (sheen_charts){0};
}

// ---- neighbours

typedef struct edge {
    uint32_t low, high, corner; // corner: 3 * triangle + its first corner
} edge;

static int by_ends(const void *a, const void *b)
{
    const edge *x = a, *y = b;
    if (x->low != y->low)
        return x->low < y->low ? -1 : 1;
    if (x->high != y->high)
        return x->high < y->high ? -1 : 1;
    return x->corner < y->corner ? -1 : x->corner > y->corner;
}

static sheen_status find_neighbours(cutting *c, sheen_err *err)
{
    const size_t n = 3 * c->mesh->n_triangles;
    edge *edges = malloc(n * sizeof *edges);
    if (!edges)
        return sheen_fail_memory(err, (double)(n * sizeof *edges), "a mesh's edges");
    for (size_t i = 0; i < n; i++) {
        const uint32_t a = c->mesh->triangles[i], b = c->mesh->triangles[i % 3 == 2 ? i - 2 : i + 1];
        edges[i] = (edge){a < b ? a : b, a < b ? b : a, (uint32_t)i};
        c->neighbour[i] = UINT32_MAX;
    }
    qsort(edges, n, sizeof *edges, by_ends);
    for (size_t i = 0; i + 1 < n; i++)
        if (edges[i].low == edges[i + 1].low && edges[i].high == edges[i + 1].high) {
            c->neighbour[edges[i].corner] = edges[i + 1].corner / 3;
            c->neighbour[edges[i + 1].corner] = edges[i].corner / 3;
            i++;
        }
    free(edges);
    return SHEEN_OK;
}

static void find_normals(cutting *c)
{
    for (size_t i = 0; i < c->mesh->n_triangles; i++) {
        const uint32_t *corner = c->mesh->triangles + 3 * i;
        const float *p = c->mesh->p_obj + 3 * (size_t)corner[0];
        float a[3], b[3];
        sheen_subf(a, c->mesh->p_obj + 3 * (size_t)corner[1], p);
        sheen_subf(b, c->mesh->p_obj + 3 * (size_t)corner[2], p);
        sheen_crossf(c->normal + 3 * i, a, b);
        sheen_normalizef(c->normal + 3 * i);
    }
}

// ---- growing

static void set_axes(chart *to, const float axis[3])
{
    float other[3] = {0, 0, 0};
    memcpy(to->axis_obj, axis, sizeof to->axis_obj);
    other[fabsf(axis[0]) < fabsf(axis[1])   ? fabsf(axis[0]) < fabsf(axis[2]) ? 0 : 2
          : fabsf(axis[1]) < fabsf(axis[2]) ? 1
                                            : 2] = 1;
    sheen_crossf(to->right_obj, other, axis);
    sheen_normalizef(to->right_obj);
    sheen_crossf(to->down_obj, to->right_obj, axis);
}

static void flat_corner(float q_m[2], const cutting *c, const chart *of, uint32_t triangle, int corner)
{
    const float *p = c->mesh->p_obj + 3 * (size_t)c->mesh->triangles[3 * (size_t)triangle + (size_t)corner];
    q_m[0] = sheen_dotf(p, of->right_obj);
    q_m[1] = sheen_dotf(p, of->down_obj);
}

static void find_bounds(cutting *c, chart *of)
{
    for (int k = 0; k < 2; k++) {
        of->min_m[k] = INFINITY;
        of->max_m[k] = -INFINITY;
    }
    for (uint32_t i = 0; i < of->count; i++)
        for (int corner = 0; corner < 3; corner++) {
            float q_m[2];
            flat_corner(q_m, c, of, c->order[of->first + i], corner);
            for (int k = 0; k < 2; k++) {
                of->min_m[k] = fminf(of->min_m[k], q_m[k]);
                of->max_m[k] = fmaxf(of->max_m[k], q_m[k]);
            }
        }
}

// Breadth first from a triangle; `order` is the queue.
static void grow(cutting *c, uint32_t seed)
{
    chart *now = &c->charts[c->n_charts];
    *now = (chart){.first = (uint32_t)c->n_ordered};
    set_axes(now, c->normal + 3 * (size_t)seed);
    c->chart_of[seed] = (int)c->n_charts;
    c->order[c->n_ordered++] = seed;
    for (size_t at = now->first; at < c->n_ordered; at++)
        for (size_t k = 0; k < 3; k++) {
            const uint32_t next = c->neighbour[3 * (size_t)c->order[at] + k];
            if (next == UINT32_MAX || c->chart_of[next] != NO_CHART ||
                !(sheen_dotf(c->normal + 3 * (size_t)next, now->axis_obj) > least_cosine))
                continue;
            c->chart_of[next] = (int)c->n_charts;
            c->order[c->n_ordered++] = next;
        }
    now->count = (uint32_t)(c->n_ordered - now->first);
    find_bounds(c, now);
}

// ---- pixels of a triangle

typedef struct painter {
    void (*paint)(void *self, int x, int y, float b1, float b2);
    void *self;
} painter;

static double cross2(const float o[2], double x, double y, const float p[2])
{
    return (double)(p[0] - o[0]) * (y - (double)o[1]) - (double)(p[1] - o[1]) * (x - (double)o[0]);
}

// Calls for each pixel whose centre lies in the triangle with corners q_px.
static void paint(float q_px[3][2], int width_px, int height_px, const painter *to)
{
    const double area = cross2(q_px[0], (double)q_px[2][0], (double)q_px[2][1], q_px[1]);
    if (!(fabs(area) > 1e-9))
        return;
    const float low_x = fminf(fminf(q_px[0][0], q_px[1][0]), q_px[2][0]),
                high_x = fmaxf(fmaxf(q_px[0][0], q_px[1][0]), q_px[2][0]),
                low_y = fminf(fminf(q_px[0][1], q_px[1][1]), q_px[2][1]),
                high_y = fmaxf(fmaxf(q_px[0][1], q_px[1][1]), q_px[2][1]);
    const int x0 = (int)fmaxf(0, floorf(low_x - 0.5f)), x1 = (int)fminf((float)width_px - 1, ceilf(high_x)),
              y0 = (int)fmaxf(0, floorf(low_y - 0.5f)), y1 = (int)fminf((float)height_px - 1, ceilf(high_y));
    for (int y = y0; y <= y1; y++)
        for (int x = x0; x <= x1; x++) {
            const double b2 = cross2(q_px[0], x + 0.5, y + 0.5, q_px[1]) / area,
                         b1 = -cross2(q_px[0], x + 0.5, y + 0.5, q_px[2]) / area;
            if (b1 >= -1e-6 && b2 >= -1e-6 && b1 + b2 <= 1 + 2e-6)
                to->paint(to->self, x, y, (float)b1, (float)b2);
        }
}

// ---- folds

typedef struct folding {
    cutting *c;
    int width_px;
    uint32_t triangle;
    int n_met; // pixels that others own
    int claim; // 0: only count
} folding;

static void meet(void *self, int x, int y, float b1, float b2)
{
    folding *f = self;
    uint32_t *owner = f->c->owner + (size_t)y * (size_t)f->width_px + (size_t)x;
    // Pixels on a common edge belong to two triangles: only what lies well inside counts.
    const int inside = b1 > 0.02f && b2 > 0.02f && b1 + b2 < 0.98f;
    if (f->claim && inside)
        *owner = f->triangle + 1;
    else if (inside && *owner && *owner != f->triangle + 1)
        f->n_met++;
}

static sheen_status make_room(cutting *c, size_t n, sheen_err *err)
{
    if (n > c->owner_capacity) {
        uint32_t *larger = realloc(c->owner, n * sizeof *larger);
        if (!larger)
            return sheen_fail_memory(err, (double)(n * sizeof *larger), "a chart");
        c->owner = larger;
        c->owner_capacity = n;
    }
    memset(c->owner, 0, n * sizeof *c->owner);
    return SHEEN_OK;
}

// Gives back the triangles of the newest chart that would lie on others of it.
static sheen_status unfold(cutting *c, sheen_err *err)
{
    chart *now = &c->charts[c->n_charts];
    float texel_m = c->texel_m;
    const float widest_m = fmaxf(now->max_m[0] - now->min_m[0], now->max_m[1] - now->min_m[1]);
    if (widest_m / texel_m > 2048)
        texel_m = widest_m / 2048;
    const int width_px = (int)((now->max_m[0] - now->min_m[0]) / texel_m) + 2,
              height_px = (int)((now->max_m[1] - now->min_m[1]) / texel_m) + 2;
    const sheen_status s = make_room(c, (size_t)width_px * (size_t)height_px, err);
    if (s)
        return s;
    uint32_t kept = 0;
    for (uint32_t i = 0; i < now->count; i++) {
        folding f = {.c = c, .width_px = width_px, .triangle = c->order[now->first + i]};
        const painter p = {meet, &f};
        float q_px[3][2];
        for (int corner = 0; corner < 3; corner++) {
            flat_corner(q_px[corner], c, now, f.triangle, corner);
            for (int k = 0; k < 2; k++)
                q_px[corner][k] = (q_px[corner][k] - now->min_m[k]) / texel_m + 0.5f;
        }
        paint(q_px, width_px, height_px, &p);
        if (f.n_met && i) {
            c->chart_of[f.triangle] = NO_CHART;
            continue;
        }
        f.claim = 1;
        paint(q_px, width_px, height_px, &p);
        c->order[now->first + kept++] = f.triangle;
    }
    now->count = kept;
    c->n_ordered = now->first + kept;
    find_bounds(c, now);
    return SHEEN_OK;
}

static sheen_status cut(cutting *c, sheen_err *err)
{
    sheen_status s = find_neighbours(c, err);
    find_normals(c);
    for (size_t i = 0; i < c->mesh->n_triangles; i++)
        c->chart_of[i] = NO_CHART;
    // Once round finds all but what folds gave back, which lies before its chart's last triangle.
    for (size_t begin = 0; !s && c->n_ordered < c->mesh->n_triangles;) {
        while (c->chart_of[begin] != NO_CHART)
            begin++;
        grow(c, (uint32_t)begin);
        s = unfold(c, err);
        c->n_charts++;
    }
    return s;
}

// ---- packing

static int by_height(const void *a, const void *b)
{
    const chart *x = a, *y = b;
    if (x->height_px != y->height_px)
        return x->height_px > y->height_px ? -1 : 1;
    return x->first < y->first ? -1 : x->first > y->first;
}

// On shelves, the tallest first; false where they do not fit.
static int pack(cutting *c, float texel_m, int side_px)
{
    for (size_t i = 0; i < c->n_charts; i++) {
        chart *now = &c->charts[i];
        const float across[2] = {(now->max_m[0] - now->min_m[0]) / texel_m,
                                 (now->max_m[1] - now->min_m[1]) / texel_m};
        if (!(across[0] < (float)side_px && across[1] < (float)side_px))
            return 0;
        now->width_px = (int)ceilf(across[0]) + 2 * gutter_px;
        now->height_px = (int)ceilf(across[1]) + 2 * gutter_px;
    }
    qsort(c->charts, c->n_charts, sizeof *c->charts, by_height);
    int x = 0, y = 0, shelf_px = 0;
    for (size_t i = 0; i < c->n_charts; i++) {
        chart *now = &c->charts[i];
        if (x + now->width_px > side_px) {
            x = 0;
            y += shelf_px;
            shelf_px = 0;
        }
        if (now->width_px > side_px || y + now->height_px > side_px)
            return 0;
        now->x0_px = x;
        now->y0_px = y;
        x += now->width_px;
        shelf_px = now->height_px > shelf_px ? now->height_px : shelf_px;
    }
    return 1;
}

static sheen_status pack_all(cutting *c, int *side_px, int max_side_px, sheen_err *err)
{
    for (int side = FIRST_SIDE_PX; side <= max_side_px; side *= 2)
        if (pack(c, c->texel_m, side)) {
            *side_px = side;
            return SHEEN_OK;
        }
    *side_px = max_side_px;
    for (int i = 0; i < 200; i++) {
        c->texel_m *= 1.05f;
        if (pack(c, c->texel_m, max_side_px))
            return SHEEN_OK;
    }
    return sheen_fail(err, SHEEN_EARG, "%zu pieces of surface do not fit into a picture of %d px a side",
                      c->n_charts, max_side_px);
}

// ---- result

static sheen_status write_out(sheen_charts *out, const cutting *c, sheen_err *err)
{
    const size_t n = 3 * c->mesh->n_triangles;
    uint32_t *number = malloc((c->mesh->n_vertices + 1) * sizeof *number);
    size_t *stamp = calloc(c->mesh->n_vertices, sizeof *stamp); // chart + 1 that a vertex was last met in
    out->triangles = malloc((n + 1) * sizeof *out->triangles);
    out->vertex = malloc((n + 1) * sizeof *out->vertex);
    out->q_px = malloc(2 * (n + 1) * sizeof *out->q_px);
    out->n_triangles = c->mesh->n_triangles;
    sheen_status s = SHEEN_OK;
    if (!number || !stamp || !out->triangles || !out->vertex || !out->q_px)
        s = sheen_fail_memory(err, 16.0 * (double)n, "texture coordinates");
    for (size_t i = 0; !s && i < c->n_charts; i++) {
        const chart *now = &c->charts[i];
        const int origin[2] = {now->x0_px + gutter_px, now->y0_px + gutter_px};
        for (uint32_t k = 0; k < 3 * now->count; k++) {
            const uint32_t triangle = c->order[now->first + k / 3];
            const uint32_t vertex = c->mesh->triangles[3 * (size_t)triangle + k % 3];
            if (stamp[vertex] != i + 1) {
                float *q = out->q_px + 2 * out->n_vertices;
                stamp[vertex] = i + 1;
                number[vertex] = (uint32_t)out->n_vertices;
                out->vertex[out->n_vertices++] = vertex;
                flat_corner(q, c, now, triangle, (int)(k % 3));
                for (int axis = 0; axis < 2; axis++)
                    q[axis] = (float)origin[axis] + (q[axis] - now->min_m[axis]) / c->texel_m;
            }
            out->triangles[3 * (size_t)triangle + k % 3] = number[vertex];
        }
    }
    free(number);
    free(stamp);
    return s;
}

sheen_status sheen_charts_make(sheen_charts *out, const sheen_mesh *mesh, double texel_m, int max_side_px,
                               sheen_err *err)
{
    *out = (sheen_charts){0};
    if (!mesh->n_triangles || mesh->n_triangles > UINT32_MAX / 3 || !(texel_m > 0) ||
        max_side_px < FIRST_SIDE_PX || max_side_px > SHEEN_IMAGE_MAX_SIDE_PX)
        return sheen_fail(err, SHEEN_EARG, "cannot lay %zu triangles out with texels of %g m",
                          mesh->n_triangles, texel_m);
    cutting c = {.mesh = mesh, .texel_m = (float)texel_m};
    const size_t n = mesh->n_triangles;
    c.normal = malloc(3 * n * sizeof *c.normal);
    c.neighbour = malloc(3 * n * sizeof *c.neighbour);
    c.chart_of = malloc(n * sizeof *c.chart_of);
    c.order = malloc(n * sizeof *c.order);
    c.charts = malloc(n * sizeof *c.charts);
    sheen_status s = SHEEN_OK;
    if (!c.normal || !c.neighbour || !c.chart_of || !c.order || !c.charts)
        s = sheen_fail_memory(err, 100.0 * (double)n, "charts");
    if (!s)
        s = cut(&c, err);
    if (!s)
        s = pack_all(&c, &out->side_px, max_side_px, err);
    if (!s)
        s = write_out(out, &c, err);
    free(c.normal);
    free(c.neighbour);
    free(c.chart_of);
    free(c.order);
    free(c.charts);
    free(c.owner);
    if (s)
        sheen_charts_release(out);
    return s;
}

typedef struct placing {
    sheen_chart_place *places;
    int side_px;
    uint32_t triangle;
} placing;

static void place(void *self, int x, int y, float b1, float b2)
{
    const placing *p = self;
    p->places[(size_t)y * (size_t)p->side_px + (size_t)x] = (sheen_chart_place){p->triangle, b1, b2};
}

void sheen_charts_places(sheen_chart_place *places, const sheen_charts *c)
{
    const size_t n = (size_t)c->side_px * (size_t)c->side_px;
    for (size_t i = 0; i < n; i++)
        places[i] = (sheen_chart_place){.triangle = SHEEN_CHART_EMPTY};
    for (size_t i = 0; i < c->n_triangles; i++) {
        placing to = {places, c->side_px, (uint32_t)i};
        const painter p = {place, &to};
        float q_px[3][2];
        for (size_t corner = 0; corner < 3; corner++)
            memcpy(q_px[corner], c->q_px + 2 * (size_t)c->triangles[3 * i + corner], sizeof q_px[corner]);
        paint(q_px, c->side_px, c->side_px, &p);
    }
}

// SPDX-License-Identifier: Apache-2.0
// light_cells.c - the lobe's sum over the few lights in its reach.
//
// A term counts while alpha <= reach = SHEEN_LOBE_REACH_SIGMA sigma. The light's direction is v mirrored
// about h, the mirror direction r is v mirrored about n, and mirroring at most doubles angles: so a light
// that counts lies within 2 reach of r. Directions are laid out on a square (an unfolded octahedron) and cut
// into cells; each cell keeps a copy of all lights which lie within 2 reach of any direction in it. A sum
// looks up r's cell and runs the plain kernel over that list. With a margin, lists reach further, so that one
// serves all samples whose mirror directions lie about r. Lists are filled up with lights of no weight to
// whole vectors.
#include "render/light_cells.h"

#include <assert.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { LANES = 16, MAX_SIDE = 192, BLOCK = 12 };
// Lists longer than this in all (64 MB) are not worth their memory: coarser cells, at last none.
static const size_t max_entries = (size_t)4 << 20;

static void direction_of(float d[3], float u, float v)
{
    d[0] = u;
    d[1] = v;
    d[2] = 1 - fabsf(u) - fabsf(v);
    if (d[2] < 0) { // the four outer triangles fold down to the lower half
        d[0] = copysignf(1 - fabsf(v), u);
        d[1] = copysignf(1 - fabsf(u), v);
    }
    sheen_normalizef(d);
}

// The directions of a cell, or of a block of cells, lie within radius_rad of the centre.
typedef struct cone {
    float centre[3], radius_rad;
} cone;

static float angle_between(const float a[3], const float b[3])
{
    float across[3];
    sheen_crossf(across, a, b);
    return atan2f(sqrtf(sheen_dotf(across, across)), sheen_dotf(a, b));
}

// Cells are bounded by great circles, as the octahedron's sides are planes (side is even, so that cells do
// not straddle its edges other than along a diagonal): their farthest points are corners.
static cone cell_cone(int side, int column, int row)
{
    const float step = 2.0f / (float)side, u0 = -1 + step * (float)column, v0 = -1 + step * (float)row;
    cone c = {.radius_rad = 0};
    direction_of(c.centre, u0 + 0.5f * step, v0 + 0.5f * step);
    for (int k = 0; k < 4; k++) {
        float corner[3];
        direction_of(corner, u0 + step * (float)(k & 1), v0 + step * (float)(k >> 1));
        c.radius_rad = fmaxf(c.radius_rad, angle_between(c.centre, corner));
    }
    c.radius_rad = c.radius_rad * 1.0001f + 1e-5f;
    return c;
}

// BLOCK x BLOCK cells, fewer at the square's end; the cone about the middle one that holds all their cones.
static cone block_cone(int side, int column, int row)
{
    const int columns = side - column < BLOCK ? side - column : BLOCK,
              rows = side - row < BLOCK ? side - row : BLOCK;
    cone block = cell_cone(side, column + columns / 2, row + rows / 2);
    for (int i = 0; i < columns * rows; i++) {
        const cone c = cell_cone(side, column + i % columns, row + i / columns);
        block.radius_rad = fmaxf(block.radius_rad, angle_between(block.centre, c.centre) + c.radius_rad);
    }
    return block;
}

static void put(sheen_lights *to, size_t i, float x, float y, float z, float weight)
{
    to->dx[i] = x;
    to->dy[i] = y;
    to->dz[i] = z;
    to->weight[i] = weight;
}

// Copies the lights within reach_rad of a cone to `to` from `at` on, or (to NULL) only counts them. Lights
// without weight are left out.
static size_t select_lights(sheen_lights *to, size_t at, const sheen_lights *lights, const cone *c,
                            float reach_rad)
{
    const float angle = c->radius_rad + reach_rad, least = angle < 3.14f ? cosf(angle) - 1e-6f : -2;
    size_t n = 0;
    for (size_t i = 0; i < lights->count; i++) {
        const float d[3] = {lights->dx[i], lights->dy[i], lights->dz[i]};
        if (sheen_dotf(d, c->centre) < least || lights->weight[i] == 0)
            continue;
        if (to)
            put(to, at + n, d[0], d[1], d[2], lights->weight[i]);
        n++;
    }
    return n;
}

// The same in whole vectors.
static size_t list_cell(sheen_lights *to, size_t at, const sheen_lights *lights, const cone *c,
                        float reach_rad)
{
    size_t n = select_lights(to, at, lights, c, reach_rad);
    for (; n % LANES; n++)
        if (to)
            put(to, at + n, 0, 0, 1, 0);
    return n;
}

// Lists every cell, or (c->lists.dx NULL) only counts; block by block, because a block's cells choose from
// the few lights near the block. `start` holds counts on the first pass, and where to write on the second.
static void list_cells(sheen_light_cells *c, const sheen_lights *lights, sheen_lights *near, float reach_rad)
{
    for (int row0 = 0; row0 < c->side; row0 += BLOCK)
        for (int column0 = 0; column0 < c->side; column0 += BLOCK) {
            const cone block = block_cone(c->side, column0, row0);
            near->count = select_lights(near, 0, lights, &block, reach_rad);
            for (int row = row0; row < c->side && row < row0 + BLOCK; row++)
                for (int column = column0; column < c->side && column < column0 + BLOCK; column++) {
                    const size_t cell = (size_t)row * (size_t)c->side + (size_t)column;
                    const cone one = cell_cone(c->side, column, row);
                    if (c->lists.dx)
                        list_cell(&c->lists, c->start[cell], near, &one, reach_rad);
                    else
                        c->start[cell] = (uint32_t)list_cell(NULL, 0, near, &one, reach_rad);
                }
        }
}

// Turns counts into starts; false where the lists would be too long together.
static int sum_starts(sheen_light_cells *c)
{
    const size_t n_cells = (size_t)c->side * (size_t)c->side;
    size_t total = 0;
    for (size_t cell = 0; cell < n_cells; cell++) {
        const size_t count = c->start[cell];
        c->start[cell] = (uint32_t)total;
        total += count;
        if (total > max_entries)
            return 0;
    }
    c->start[n_cells] = (uint32_t)total;
    return 1;
}

// Cells of about two and a half sigma; fewer where lists get long; none where the lobe reaches everything.
static void choose_side(sheen_light_cells *c, const sheen_lights *lights, sheen_lights *near, float reach_rad)
{
    c->side = 0;
    if (reach_rad > 1.4f)
        return;
    int side = (int)(1.4f / c->sigma_rad);
    side = (side > MAX_SIDE ? MAX_SIDE : side < 4 ? 4 : side) / 2 * 2;
    for (; side >= 4; side = side / 4 * 2) {
        c->side = side;
        list_cells(c, lights, near, reach_rad);
        if (sum_starts(c))
            return;
    }
    c->side = 0;
}

static sheen_status room(sheen_lights *l, size_t n, sheen_err *err)
{
    // Aligned to whole vectors, as the lists are, so that no load straddles two cache lines.
    const size_t size_bytes = (n + LANES) / LANES * LANES * sizeof(float);
    l->dx = aligned_alloc(64, size_bytes);
    l->dy = aligned_alloc(64, size_bytes);
    l->dz = aligned_alloc(64, size_bytes);
    l->weight = aligned_alloc(64, size_bytes);
    l->count = n;
    if (!l->dx || !l->dy || !l->dz || !l->weight)
        return sheen_fail_memory(err, 4.0 * (double)size_bytes, "the lights' cells");
    return SHEEN_OK;
}

static void release(sheen_lights *l)
{
    free(l->dx);
    free(l->dy);
    free(l->dz);
    free(l->weight);
    *l = (sheen_lights){0};
}

sheen_status sheen_light_cells_new(sheen_light_cells **out, const sheen_lights *lights, float sigma_rad,
                                   sheen_err *err)
{
    return sheen_light_cells_new_wide(out, lights, sigma_rad, 0, err);
}

sheen_status sheen_light_cells_new_wide(sheen_light_cells **out, const sheen_lights *lights, float sigma_rad,
                                        float margin_rad, sheen_err *err)
{
    assert(sigma_rad > 0 && margin_rad >= 0);
    const float reach_rad = 2 * SHEEN_LOBE_REACH_SIGMA * sigma_rad + margin_rad;
    const cone everything = {.centre = {0, 0, 1}, .radius_rad = 4};
    sheen_lights near = {0};
    sheen_status s = SHEEN_OK;
    *out = NULL;
    sheen_light_cells *c = calloc(1, sizeof *c);
    if (c)
        c->start = calloc((size_t)MAX_SIDE * MAX_SIDE + 1, sizeof *c->start);
    if (!c || !c->start) {
        s = sheen_fail_memory(err, 4.0 * MAX_SIDE * MAX_SIDE, "the lights' cells");
        goto done;
    }
    c->sigma_rad = sigma_rad;
    c->margin_rad = margin_rad;
    s = room(&near, lights->count, err);
    if (s)
        goto done;
    choose_side(c, lights, &near, reach_rad);
    if (c->side) {
        s = room(&c->lists, c->start[(size_t)c->side * (size_t)c->side], err);
        if (!s)
            list_cells(c, lights, &near, reach_rad);
    } else {
        s = room(&c->lists, list_cell(NULL, 0, lights, &everything, 0), err);
        if (!s)
            list_cell(&c->lists, 0, lights, &everything, 0);
    }

done:
    release(&near);
    if (s)
        sheen_light_cells_free(&c);
    *out = c;
    return s;
}

void sheen_light_cells_free(sheen_light_cells **cells)
{
    sheen_light_cells *c = *cells;
    if (!c)
        return;
    free(c->start);
    release(&c->lists);
    free(c);
    *cells = NULL;
}

void sheen_light_cells_near(sheen_lights *near, const sheen_light_cells *cells, const float n[3],
                            const float v[3])
{
    float r[3];
    sheen_mirrorf(r, n, v);
    *near = sheen_lights_near(cells, r);
}

float sheen_light_cells_sum(const sheen_light_cells *cells, const float n[3], const float v[3])
{
    sheen_lights near;
    sheen_light_cells_near(&near, cells, n, v);
    return near.count ? sheen_lobe_sum(&near, n, v, cells->sigma_rad) : 0;
}

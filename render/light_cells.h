// SPDX-License-Identifier: Apache-2.0
// light_cells.h - the inside of sheen_light_cells, for the kernels that sum over them. Used inside render only.
#ifndef SHEEN_RENDER_LIGHT_CELLS_H
#define SHEEN_RENDER_LIGHT_CELLS_H

#include <stddef.h>
#include <stdint.h>

#include "render/lobe.h"

struct sheen_light_cells {
    float sigma_rad;
    float margin_rad; // a cell's list serves mirror directions up to so far outside of the cell
    int side;         // cells along the square; 0: one list for all directions
    uint32_t *start;  // [side * side + 1]
    sheen_lights lists;
};

// sheen_light_cells_new with a margin.
sheen_status sheen_light_cells_new_wide(sheen_light_cells **out, const sheen_lights *lights, float sigma_rad,
                                        float margin_rad, sheen_err *err);

// The cell that a unit direction lies in.
static inline size_t sheen_light_cell_of(int side, const float d[3])
{
    const float s = fabsf(d[0]) + fabsf(d[1]) + fabsf(d[2]);
    float u = d[0] / s, v = d[1] / s;
    if (d[2] < 0) {
        const float folded = copysignf(1 - fabsf(v), u);
        v = copysignf(1 - fabsf(u), v);
        u = folded;
    }
    const int column = (int)((u + 1) * 0.5f * (float)side), row = (int)((v + 1) * 0.5f * (float)side);
    const int c = column < 0 ? 0 : column >= side ? side - 1 : column;
    const int r = row < 0 ? 0 : row >= side ? side - 1 : row;
    return (size_t)r * (size_t)side + (size_t)c;
}

// The lights near a mirror direction.
static inline sheen_lights sheen_lights_near(const sheen_light_cells *cells, const float r[3])
{
    if (!cells->side)
        return cells->lists;
    const size_t cell = sheen_light_cell_of(cells->side, r);
    const uint32_t begin = cells->start[cell], end = cells->start[cell + 1];
    const sheen_lights *all = &cells->lists;
    return (sheen_lights){all->dx + begin, all->dy + begin, all->dz + begin, all->weight + begin,
                          end - begin};
}

#endif

// SPDX-License-Identifier: Apache-2.0
// page_layout.h - the packed geometry's layout, for its writer and its reader only (docs/viewer.md).
#ifndef SHEEN_RENDER_PAGE_LAYOUT_H
#define SHEEN_RENDER_PAGE_LAYOUT_H

#include <stddef.h>
#include <stdint.h>

#include "render/texture.h"

enum {
    SHEEN_PAGE_MAGIC = 0x314e4853, // "SHN1"
    // u32: magic, vertices, triangles, texels an edge, atlas columns, lights, moving, 0
    SHEEN_PAGE_N_INTS = 8,
    // f64: k_S, sigma, light_rgb[3], rt_world_obj[6], rt_board_obj[6], focal/width, box min[3], box max[3]
    SHEEN_PAGE_N_REALS = 24,
    SHEEN_PAGE_HEADER_BYTES = 4 * SHEEN_PAGE_N_INTS + 8 * SHEEN_PAGE_N_REALS,
    SHEEN_PAGE_VERTEX_BYTES = 10,  // 5 numbers of 16 bits, each in two planes: x y z, octahedral normal
    SHEEN_PAGE_TRIANGLE_BYTES = 9, // 3 numbers of 24 bits, in three planes
    SHEEN_PAGE_LIGHT_BYTES = 10,   // direction 3 x i16, weight f32
    SHEEN_PAGE_MAX_VERTICES = 1 << 24,
    SHEEN_PAGE_MAX_TRIANGLES = 1 << 22,
    SHEEN_PAGE_MAX_LIGHTS = 1 << 20,
};

static inline size_t sheen_page_seen_bytes(size_t n_triangles, int texels_per_edge)
{
    return (n_triangles * sheen_texels_per_triangle(texels_per_edge) + 7) / 8;
}

static inline size_t sheen_page_bytes(size_t n_vertices, size_t n_triangles, int texels_per_edge,
                                      size_t n_lights)
{
    return SHEEN_PAGE_HEADER_BYTES + SHEEN_PAGE_VERTEX_BYTES * n_vertices +
           SHEEN_PAGE_TRIANGLE_BYTES * n_triangles + SHEEN_PAGE_LIGHT_BYTES * n_lights +
           sheen_page_seen_bytes(n_triangles, texels_per_edge);
}

#endif

// SPDX-License-Identifier: Apache-2.0
// page_layout.h - the packed geometry's layout, for its writer and its reader only (docs/viewer.md).
#ifndef SHEEN_RENDER_PAGE_LAYOUT_H
#define SHEEN_RENDER_PAGE_LAYOUT_H

#include <stddef.h>
#include <stdint.h>

#include "render/page_normals.h"

#define SHEEN_PAGE_SCHEMA "sheen-page"

enum {
    SHEEN_PAGE_VERSION = 2,
    SHEEN_PAGE_MAGIC = 0x324e4853,   // "SHN2"
    SHEEN_PAGE_HEADER_BYTES = 2 * 4, // u32: magic, bytes of the JSON text that follows
    SHEEN_PAGE_VERTEX_BYTES = 10,    // 5 numbers of 16 bits, each in two planes: x y z, octahedral normal
    SHEEN_PAGE_TRIANGLE_BYTES = 9,   // 3 numbers of 24 bits, in three planes
    SHEEN_PAGE_MAX_VERTICES = 1 << 24,
    SHEEN_PAGE_MAX_TRIANGLES = 1 << 22,
    SHEEN_PAGE_MAX_BOARD_SIDE_PX = 4096,
};

static inline size_t sheen_page_seen_bytes(size_t n_triangles, int texels_per_edge)
{
    return (n_triangles * sheen_texels_per_triangle(texels_per_edge) + 7) / 8;
}

// Of what follows the JSON text. normals_texels_per_edge: 0 where there is no normal map.
static inline size_t sheen_page_surface_bytes(size_t n_vertices, size_t n_triangles, int texels_per_edge,
                                              int normals_texels_per_edge)
{
    return SHEEN_PAGE_VERTEX_BYTES * n_vertices + SHEEN_PAGE_TRIANGLE_BYTES * n_triangles +
           sheen_page_seen_bytes(n_triangles, texels_per_edge) +
           sheen_page_normals_bytes(n_triangles, normals_texels_per_edge);
}

#endif

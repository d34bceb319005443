// SPDX-License-Identifier: Apache-2.0
// page_normals.h - normals in a packed page: those of vertices, and the normal map's offsets (docs/viewer.md).
#ifndef SHEEN_RENDER_PAGE_NORMALS_H
#define SHEEN_RENDER_PAGE_NORMALS_H

#include <math.h>

#include "render/normal_map.h"

static inline uint16_t sheen_page_u16(float x) // 0..1
{
    return (uint16_t)(fminf(fmaxf(x, 0), 1) * 65535.0f + 0.5f);
}

// The sphere onto a square by the octahedron, 16 bits a side; and back, as unit normal.
void sheen_page_normal_code(uint16_t code[2], const float n[3]);
void sheen_page_normal_of(float n[3], const uint16_t code[2]);

// Small differences of either sign become small numbers: 0 -1 1 -2 2 as 0 1 2 3 4, modulo 2^16.
static inline uint16_t sheen_page_fold(uint16_t difference)
{
    return (uint16_t)((uint16_t)(difference << 1) ^ (difference >> 15 ? 0xffff : 0));
}

static inline uint16_t sheen_page_unfold(uint16_t folded)
{
    return (uint16_t)((folded >> 1) ^ (folded & 1 ? 0xffff : 0));
}

// The offsets' step in a page of a lobe of sigma_rad: small beside it, and the largest offset still has a number.
double sheen_page_normals_step(double sigma_rad);
size_t sheen_page_normals_bytes(size_t n_triangles, int texels_per_edge);
// mesh: with the vertex normals that the reader has. to: sheen_page_normals_bytes.
void sheen_page_normals_put(uint8_t *to, const sheen_texture *normals, const sheen_mesh *mesh,
                            double step_rad);
// Fills an initialised map. Numbers beyond SHEEN_NORMAL_MAP_MOST are held to it.
void sheen_page_normals_get(sheen_texture *normals, const uint8_t *from, const sheen_mesh *mesh,
                            double step_rad);

#endif

// SPDX-License-Identifier: Apache-2.0
// geodesic.h - the illumination hemisphere's nodes: the upper half of a subdivided icosahedron (section 4.1).
//
// Class I subdivision of frequency f: every edge of the icosahedron in f pieces, pushed out to the
// unit sphere: 10 f^2 + 2 nodes on the sphere. One of the icosahedron's vertices is +z; nodes with
// z >= 0 are kept, in an order that depends on f alone. f = 60 gives the paper's "18000".
#ifndef SHEEN_RENDER_GEODESIC_H
#define SHEEN_RENDER_GEODESIC_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SHEEN_GEODESIC_MAX_FREQUENCY = 400 };

typedef struct sheen_geodesic {
    int frequency;
    size_t n_nodes;    // N_L of eq. (7)
    float *v_world;    // [n_nodes][3], unit
    float spacing_rad; // mean distance to the nearest neighbour
    // Search grid over directions, private.
    uint32_t *cell_start, *cell_nodes;
    int n_cells_side;
} sheen_geodesic;

// EARG: frequency outside 1..400. ENOMEM.
sheen_status sheen_geodesic_init(sheen_geodesic *g, int frequency, sheen_err *err);
void sheen_geodesic_release(sheen_geodesic *g);

// The node nearest to a unit direction, or UINT32_MAX where the direction is below the horizon by
// more than half a spacing.
uint32_t sheen_geodesic_nearest(const sheen_geodesic *g, const float v_world[3]);

// Nodes within angle_rad of a unit direction, in ascending order, at most max_out into out; returns how
// many there are.
size_t sheen_geodesic_within(const sheen_geodesic *g, uint32_t *out, size_t max_out, const float v_world[3],
                             float angle_rad);

// Half the solid angle of a sphere shared evenly: omega = 2 pi / N_L, as in eq. (7).
double sheen_geodesic_solid_angle_sr(const sheen_geodesic *g);

#ifdef __cplusplus
}
#endif
#endif

// SPDX-License-Identifier: Apache-2.0
// normal_grid.h - offsets of normals as unknowns: one a texel of a normal map, shared edge texels being one, tied to their neighbours.
//
// Minimises over the offsets d (frame obj, one a node)
//
//     1/2 sum_rows (dx' H dx - 2 b' dx) + 1/2 stiffness sum_links |d_i - d_j|^2 + 1/2 stiffness / reach^2 sum_nodes |d_i|^2
//
// dx: the change of d at the row's place, linear between its three nodes. The second sum is the membrane's energy, which in two dimensions
// does not depend on the lattice's pitch; the third lets d die away where no row is within `reach` nodes.
#ifndef SHEEN_FIT_NORMAL_GRID_H
#define SHEEN_FIT_NORMAL_GRID_H

#include "base/mesh.h"
#include "render/texture.h"

typedef struct sheen_normal_grid {
    int texels_per_edge; // of the map
    size_t n_triangles, n_nodes;
    uint32_t *node;      // [n_triangles * texels] of each of the map's texels
    uint32_t *first;     // [n_nodes + 1] where a node's neighbours begin
    uint32_t *neighbour; // every link from both its ends
} sheen_normal_grid;

// What one place on the surface says.
typedef struct sheen_normal_row {
    float H[6], b[3]; // xx, xy, yy, xz, yz, zz
    uint32_t node[3];
    float weight[3];
} sheen_normal_row;

typedef struct sheen_normal_prior {
    double stiffness; // per squared radian
    double reach;     // nodes
} sheen_normal_prior;

// EARG, ENOMEM.
sheen_status sheen_normal_grid_init(sheen_normal_grid *g, const sheen_mesh *mesh, int texels_per_edge,
                                    sheen_err *err);
void sheen_normal_grid_release(sheen_normal_grid *g);

// Improves d[n_nodes][3] in place, by conjugate gradients from where it is. The result does not depend on n_threads. ENOMEM.
sheen_status sheen_normal_grid_solve(float *d, const sheen_normal_grid *g, const sheen_normal_row *rows,
                                     size_t n_rows, const sheen_normal_prior *prior, int n_threads,
                                     sheen_err *err);

#endif

// SPDX-License-Identifier: Apache-2.0
// simplify.h - a mesh with fewer triangles.
#ifndef SHEEN_RENDER_SIMPLIFY_H
#define SHEEN_RENDER_SIMPLIFY_H

#include "base/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

// At most about max_triangles of them (more where the shape permits no fewer), by collapsing edges; the vertices that
// are left stay where they are, with their normals, and get new numbers. *error_m: how far the surface moved, about.
// ENOMEM.
sheen_status sheen_mesh_simplify(sheen_mesh *out, const sheen_mesh *mesh, size_t max_triangles,
                                 double *error_m, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

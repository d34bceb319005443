// SPDX-License-Identifier: Apache-2.0
// mesh_build.h - how the mesh formats hand over what they read: vertices, polygons, and the checks on both.
//
// Only mesh*.c include this. The builder owns what it holds until sheen_mesh_build_finish() gives it to a mesh.
#ifndef SHEEN_BASE_MESH_BUILD_H
#define SHEEN_BASE_MESH_BUILD_H

#include <stdbool.h>

#include "base/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SHEEN_MESH_MAX_VERTICES = 3 * SHEEN_MESH_MAX_TRIANGLES };

typedef struct sheen_mesh_build {
    sheen_mesh mesh;
    size_t vertex_capacity, triangle_capacity;
} sheen_mesh_build;

// Room for this many more. EFORMAT beyond the largest mesh; ENOMEM. The caller has seen that the file is large
// enough to hold them.
sheen_status sheen_mesh_build_reserve(sheen_mesh_build *b, size_t n_vertices, size_t n_triangles,
                                      sheen_err *err);

// Appends a vertex. n_obj may be NULL, or any length: finish() makes it a unit, or finds one from the triangles.
// EFORMAT for a position that is not finite or further out than any object (1e9 m).
sheen_status sheen_mesh_build_vertex(sheen_mesh_build *b, const double p_obj[3], const double *n_obj,
                                     sheen_err *err);

// Replaces the normal of vertex i (any length, as above).
void sheen_mesh_build_normal(sheen_mesh_build *b, size_t i, const double n_obj[3]);

// Appends a triangle; those with a repeated vertex are dropped. EFORMAT for an index beyond the n_vertices that
// there are, or will be.
sheen_status sheen_mesh_build_triangle(sheen_mesh_build *b, int64_t i0, int64_t i1, int64_t i2,
                                       size_t n_vertices, sheen_err *err);

// Drops triangles without area, completes the normals, and moves all into *mesh. EDATA: no triangle is left.
sheen_status sheen_mesh_build_finish(sheen_mesh_build *b, sheen_mesh *mesh, sheen_err *err);
void sheen_mesh_build_release(sheen_mesh_build *b);

// One format each.
sheen_status sheen_ply_parse(sheen_mesh *mesh, const void *data, size_t size_bytes, sheen_err *err);
sheen_status sheen_obj_parse(sheen_mesh *mesh, const void *data, size_t size_bytes, sheen_err *err);
sheen_status sheen_glb_parse(sheen_mesh *mesh, const void *data, size_t size_bytes, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

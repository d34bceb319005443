// SPDX-License-Identifier: Apache-2.0
// mesh.h - the object's triangle mesh, in its own frame ("obj"), metres.
#ifndef SHEEN_BASE_MESH_H
#define SHEEN_BASE_MESH_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_mesh {
    float *p_obj;        // [n_vertices][3]
    float *n_obj;        // [n_vertices][3] unit normals: the file's, else area-weighted from the triangles
    uint32_t *triangles; // [n_triangles][3], counter-clockwise seen from outside, each < n_vertices
    size_t n_vertices, n_triangles;
} sheen_mesh;

enum { SHEEN_MESH_MAX_TRIANGLES = 20000000 };

// PLY (ASCII, binary of either order), OBJ, glTF binary (.glb): told by the first bytes, else by
// `name_hint`'s extension. Polygons become fans; vertices that no triangle uses stay; triangles
// with a repeated vertex or no area are dropped. EFORMAT; EDATA where no triangle is left.
sheen_status sheen_mesh_parse(sheen_mesh *mesh, const void *data, size_t size_bytes, const char *name_hint,
                              sheen_err *err);
// From a file, and then mended (mesh_repair.h).
sheen_status sheen_mesh_load(sheen_mesh *mesh, const char *path, sheen_err *err);
void sheen_mesh_release(sheen_mesh *mesh);

// Binary little-endian PLY with normals.
sheen_status sheen_mesh_save_ply(const sheen_mesh *mesh, const char *path, sheen_err *err);

// Area-weighted vertex normals from the triangles; a vertex without area gets +z.
void sheen_mesh_compute_normals(sheen_mesh *mesh);

// Axis-aligned bounds, and a sphere about the box's centre that holds every vertex.
void sheen_mesh_bounds(const sheen_mesh *mesh, float min_obj[3], float max_obj[3]);
void sheen_mesh_sphere(const sheen_mesh *mesh, float centre_obj[3], float *radius_m);

#ifdef __cplusplus
}
#endif
#endif

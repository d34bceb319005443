// SPDX-License-Identifier: Apache-2.0
// mesh_repair.h - what scanners and modelling programs leave behind: double faces, parts inside out, wrong normals.
#ifndef SHEEN_BASE_MESH_REPAIR_H
#define SHEEN_BASE_MESH_REPAIR_H

#include "base/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

// What was done; all 0: the mesh is as it was, to the bit.
typedef struct sheen_mesh_repairs {
    size_t n_doubles; // triangles dropped because another one has the same three corners (by place)
    size_t n_turned;  // triangles turned over: against their neighbours, or of a part that was inside out
    size_t n_normals; // vertex normals replaced because they point away from their triangles
} sheen_mesh_repairs;

// Corners at one place count as one. Across edges of two triangles the winding is made to agree; a part that encloses volume
// is turned so that the volume is positive, an open one as most of its triangles already are. Where more than a fifth of the
// vertex normals are further than 60 degrees from their triangles', all are computed anew. Depends on the mesh alone. ENOMEM.
sheen_status sheen_mesh_repair(sheen_mesh_repairs *out, sheen_mesh *mesh, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

// SPDX-License-Identifier: Apache-2.0
// mesh_foreign.h - meshes of other programs' formats: STL, glTF as text, Collada, 3MF and what else assimp reads.
//
// The formats that a session holds (PLY, OBJ, glTF binary) have readers of their own (mesh.h), which keep the order
// of vertices and are fuzzed. assimp is neither, so it runs in a process of its own with limits on memory and time:
// what damages it gives a sentence.
#ifndef SHEEN_BASE_MESH_FOREIGN_H
#define SHEEN_BASE_MESH_FOREIGN_H

#include <stdbool.h>

#include "base/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

// True for the endings .ply, .obj, .glb.
bool sheen_mesh_is_native(const char *path);

// Any mesh: native ones by sheen_mesh_load, others through assimp. All parts of a file become one mesh, placed as its
// scene says; vertices as given, in the file's own unit. EIO, EACCESS; EFORMAT (malformed, or no format that is
// read), EDATA (no triangle), ENOMEM.
sheen_status sheen_mesh_load_any(sheen_mesh *mesh, const char *path, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

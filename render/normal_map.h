// SPDX-License-Identifier: Apache-2.0
// normal_map.h - normals finer than the mesh's: n = (m + d) / |m + d|, m the mesh's interpolated unit normal at the place, d an offset.
//
// A map is a texture (texture.h) whose rgb is d in frame obj, radians for small angles: it needs no tangent frame to be
// interpolated, and shared edge texels keep it free of seams. Its texels an edge are its own. n_triangles 0: there is none, and
// n = m. Files hold the two parts of d across m, in the frame that sheen_axes_aboutf (base/vec.h) makes from m alone.
#ifndef SHEEN_RENDER_NORMAL_MAP_H
#define SHEEN_RENDER_NORMAL_MAP_H

#include "render/texture.h"

#ifdef __cplusplus
extern "C" {
#endif

// |d| is held to this: 45 degrees.
#define SHEEN_NORMAL_MAP_MOST 1.0f

// No offsets. EARG, ENOMEM.
sheen_status sheen_normal_map_init(sheen_texture *normals, size_t n_triangles, int texels_per_edge,
                                   sheen_err *err);

// Bends n_obj, the mesh's unit normal at a hit. normals may be NULL or empty.
void sheen_normal_map_bend(float n_obj[3], const sheen_texture *normals, const sheen_hit *hit);

// sheen_texture_lattice with bent normals, for a lattice of any number of texels an edge.
void sheen_normal_map_lattice(const sheen_mesh *mesh, const sheen_texture *normals, size_t triangle,
                              int texels_per_edge, float *p_obj, float *n_obj);

// sheen_hit_surface with bent normals.
void sheen_normal_map_surface(const sheen_mesh *mesh, const sheen_texture *normals, const sheen_hit *hit,
                              const double p_camera_obj[3], float p_obj[3], float n_obj[3], float v_obj[3]);

// To and from the two numbers a texel has in a file: rgb = (d.a, d.b, 0), n_views as it is. In place.
void sheen_normal_map_to_tangents(sheen_texture *normals, const sheen_mesh *mesh);
void sheen_normal_map_from_tangents(sheen_texture *normals, const sheen_mesh *mesh);

#ifdef __cplusplus
}
#endif
#endif

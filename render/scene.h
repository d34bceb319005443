// SPDX-License-Identifier: Apache-2.0
// scene.h - exact visibility of a mesh: which triangle a ray meets first, and whether it meets any.
//
// Rays and hits are in the mesh's frame, metres. A scene is read-only after it was made and may
// be used from several threads at once.
#ifndef SHEEN_RENDER_SCENE_H
#define SHEEN_RENDER_SCENE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_scene sheen_scene;

#define SHEEN_NO_HIT UINT32_MAX

typedef struct sheen_hit {
    uint32_t triangle; // SHEEN_NO_HIT: nothing
    float b1, b2;      // barycentric weights of the triangle's corners 1 and 2; corner 0 has 1 - b1 - b2
    float t_m;         // distance along the unit ray
} sheen_hit;

// Builds the ray-tracing structure. The mesh is copied. ENOMEM, EUNSUP (no ray tracing here).
sheen_status sheen_scene_new(sheen_scene **out, const sheen_mesh *mesh, sheen_err *err);
void sheen_scene_free(sheen_scene **scene);

// First hits of n rays from origin_obj[3] (one for all when shared_origin, else [n][3]) along unit
// directions v_obj[n][3]. Coherent rays (neighbouring pixels side by side) are faster.
void sheen_scene_first_hits(const sheen_scene *scene, sheen_hit *hits, const float *origin_obj,
                            int shared_origin, const float *v_obj, size_t n);

// occluded[i] = 1 where something lies on the open segment from p_obj[i] to the common point target_obj
// (both ends pulled in by offset_m, so that the surface at p does not hide itself).
void sheen_scene_occluded(const sheen_scene *scene, uint8_t *occluded, const float *p_obj, size_t n,
                          const float target_obj[3], float offset_m);

// True where one ray from origin_obj along the unit direction v_obj meets anything.
bool sheen_scene_blocked(const sheen_scene *scene, const float origin_obj[3], const float v_obj[3]);

#ifdef __cplusplus
}
#endif
#endif

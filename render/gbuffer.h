// SPDX-License-Identifier: Apache-2.0
// gbuffer.h - what a camera sees of the mesh, pixel by pixel: triangle, place on it, normal, view direction.
#ifndef SHEEN_RENDER_GBUFFER_H
#define SHEEN_RENDER_GBUFFER_H

#include "base/camera.h"
#include "base/mesh.h"
#include "render/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

// Samples of the window [x0, x0+width) x [y0, y0+height) of the image: the box round the projected mesh,
// clipped to the image; everything outside it is background. n x n samples a pixel (supersampling 1, 2, ...);
// sample (i, j) of pixel (x, y) lies at x + (i + 0.5) / n - 0.5, likewise y.
typedef struct sheen_gbuffer {
    int x0_px, y0_px, width_px, height_px; // window, in pixels; width 0: the mesh is not in view
    int samples_per_side;
    sheen_hit *hits;        // [height_px * n][width_px * n]
    double p_camera_obj[3]; // centre of projection
} sheen_gbuffer;

// rt_cam_obj must be finite. Through the full lens model; the result does not depend on n_threads.
// EARG, ENOMEM.
sheen_status sheen_gbuffer_make(sheen_gbuffer *out, const sheen_scene *scene, const sheen_mesh *mesh,
                                const sheen_camera *cam, const double rt_cam_obj[6], int samples_per_side,
                                int n_threads, sheen_err *err);
// The same by one ray a sample, whatever the lens.
sheen_status sheen_gbuffer_make_ref(sheen_gbuffer *out, const sheen_scene *scene, const sheen_mesh *mesh,
                                    const sheen_camera *cam, const double rt_cam_obj[6], int samples_per_side,
                                    int n_threads, sheen_err *err);
void sheen_gbuffer_release(sheen_gbuffer *g);

// At a hit: point, unit interpolated normal n (turned nowhere: it may face away), and unit direction v to
// the camera. Any output may be NULL.
void sheen_hit_surface(const sheen_mesh *mesh, const sheen_hit *hit, const double p_camera_obj[3],
                       float p_obj[3], float n_obj[3], float v_obj[3]);

#ifdef __cplusplus
}
#endif
#endif

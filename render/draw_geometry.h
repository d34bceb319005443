// SPDX-License-Identifier: Apache-2.0
// draw_geometry.h - what a picture shows, as numbers: depth, normals, and which pixels are the object.
#ifndef SHEEN_RENDER_DRAW_GEOMETRY_H
#define SHEEN_RENDER_DRAW_GEOMETRY_H

#include "render/draw.h"

#ifdef __cplusplus
extern "C" {
#endif

// At each pixel's centre, one sample; 0 off the object.
typedef struct sheen_geometry {
    sheen_image depth_m; // 1 channel: z_cam, along the optical axis
    sheen_image n_cam;   // 3 channels: unit normal in the camera's frame (x right, y down, z forward)
    sheen_image mask;    // 1 channel: 1 on the object
} sheen_geometry;

// EARG (not finite), ENOMEM. Released by sheen_geometry_release.
sheen_status sheen_draw_geometry(sheen_geometry *out, const sheen_drawing *d, const sheen_camera *cam,
                                 const double rt_cam_obj[6], int n_threads, sheen_err *err);
void sheen_geometry_release(sheen_geometry *g);

#ifdef __cplusplus
}
#endif
#endif

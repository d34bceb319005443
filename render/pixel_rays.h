// SPDX-License-Identifier: Apache-2.0
// pixel_rays.h - directions through many points of an image, fast for any lens. Used inside render only.
#ifndef SHEEN_RENDER_PIXEL_RAYS_H
#define SHEEN_RENDER_PIXEL_RAYS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/camera.h"
#include "base/pose3.h"

// How far an interpolated direction may be off.
#define SHEEN_PIXEL_RAYS_ERROR_PX 1e-3

// Read-only after init; may be used from several threads.
typedef struct sheen_pixel_rays {
    const sheen_camera *cam; // lent
    sheen_Rt Rt_obj_cam;
    bool pinhole;          // a formula; no grid
    int step_px;           // distance of the grid's points: 16, 8 or 4
    double x0_px, y0_px;   // of the grid's point (0, 0)
    int n_columns, n_rows; // of grid points
    double *v_obj;         // [n_rows][n_columns][3]
    bool *smooth;          // [n_rows][n_columns]: the cell right and below may be interpolated
} sheen_pixel_rays;

// For points of the pixels [x0, x0 + width) x [y0, y0 + height), their borders included; window_px is x0, y0,
// width, height. EARG (a bad lens), ENOMEM.
sheen_status sheen_pixel_rays_init(sheen_pixel_rays *r, const sheen_camera *cam, const double rt_cam_obj[6],
                                   const int window_px[4], int n_threads, sheen_err *err);
void sheen_pixel_rays_release(sheen_pixel_rays *r);

// Unit directions v_obj[n][3] in the object's frame through (x + i dx, y), i = 0..n-1, which lie in the
// pixels given to init; NaN where the lens has no inverse. n <= 64, and dx <= 1.
void sheen_pixel_rays_row(const sheen_pixel_rays *r, float *v_obj, double x_px, double y_px, double dx_px,
                          int n);
// The same, each point through the lens model.
void sheen_pixel_rays_row_ref(const sheen_pixel_rays *r, float *v_obj, double x_px, double y_px, double dx_px,
                              int n);

#endif

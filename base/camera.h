// SPDX-License-Identifier: Apache-2.0
// camera.h - a camera's lens: projection and unprojection through mrcal's models.
//
// A plain struct; mrcal does the mathematics (camera_mrcal.c). Pixel coordinates have (0,0) at
// the centre of the top-left pixel; camera axes are x right, y down, z forward.
#ifndef SHEEN_BASE_CAMERA_H
#define SHEEN_BASE_CAMERA_H

#include <stddef.h>

#include "base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SHEEN_CAMERA_MAX_INTRINSICS = 1024 };

typedef struct sheen_camera {
    char lensmodel[96]; // mrcal's name with its configuration: "LENSMODEL_OPENCV8"
    int n_intrinsics;   // as the lens model demands
    double intrinsics[SHEEN_CAMERA_MAX_INTRINSICS]; // fx fy cx cy in px, then the distortion
    int width_px, height_px;
    // The camera and its focus as the frames that it was calibrated from say ("NAME; focus 30"); "": not known.
    char taken_by[160];
    double rt_cam_ref[6]; // mrcal's "extrinsics"; sheen leaves them zero in camera.cameramodel
} sheen_camera;

// fx fy cx cy; n_distortion 0 (pinhole), 4, 5, 8 or 12 numbers in OpenCV's order k1 k2 p1 p2 k3 ...
// EARG for anything else or what sheen_camera_check refuses.
sheen_status sheen_camera_opencv(sheen_camera *cam, int width_px, int height_px, const double fxycxy[4],
                                 const double *distortion, int n_distortion, sheen_err *err);

// Known lens model, right number of finite intrinsics, positive focal length and size. EFORMAT.
sheen_status sheen_camera_check(const sheen_camera *cam, sheen_err *err);

// q_px[2n] from p_cam[3n] (z > 0 for models with a pinhole core). dq_dp[6n] (2x3 row-major) may be NULL.
// A point behind such a camera gives NaN. ENOMEM, EARG (bad model).
sheen_status sheen_camera_project(const sheen_camera *cam, double *q_px, double *dq_dp, const double *p_cam,
                                  size_t n, sheen_err *err);
// Unit directions v_cam[3n] from q_px[2n]; NaN where the model has no inverse there.
sheen_status sheen_camera_unproject(const sheen_camera *cam, double *v_cam, const double *q_px, size_t n,
                                    sheen_err *err);

// The camera of the same lens for an image scaled by `factor` (pixel centres keep their place:
// q' + 1/2 = factor (q + 1/2)). Only models with a core. EUNSUP for splined ones.
sheen_status sheen_camera_scale(sheen_camera *out, const sheen_camera *cam, double factor, sheen_err *err);

// .cameramodel: mrcal's text format, read by mrcal's own parser, written with all digits.
sheen_status sheen_camera_parse(sheen_camera *cam, const void *data, size_t size_bytes, sheen_err *err);
sheen_status sheen_camera_load(sheen_camera *cam, const char *path, sheen_err *err);
sheen_status sheen_camera_save(const sheen_camera *cam, const char *path, sheen_err *err);

// What mrcal's tools and people find in such a file beside the lens; each may be left out.
typedef struct sheen_camera_extras {
    const double *region_px; // closed outline [n_region][2] of where the lens is certain
    size_t n_region;
    const char *note;                // a comment of one line
    const char *optimization_inputs; // base 85, as mrcal writes them
} sheen_camera_extras;

sheen_status sheen_camera_save_with(const sheen_camera *cam, const sheen_camera_extras *extras,
                                    const char *path, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

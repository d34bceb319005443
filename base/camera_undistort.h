// SPDX-License-Identifier: Apache-2.0
// camera_undistort.h - photographs without their lens's distortion.
#ifndef SHEEN_BASE_CAMERA_UNDISTORT_H
#define SHEEN_BASE_CAMERA_UNDISTORT_H

#include "base/camera.h"
#include "base/image.h"

#ifdef __cplusplus
extern "C" {
#endif

// What a pinhole camera (four intrinsics) sees of a photograph by cam, bilinear; black outside of it. EARG, ENOMEM.
sheen_status sheen_image_undistort(sheen_image *out, const sheen_image *img, const sheen_camera *cam,
                                   const sheen_camera *pinhole, int n_threads, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

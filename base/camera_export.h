// SPDX-License-Identifier: Apache-2.0
// camera_export.h - a camera as other programs' files: OpenCV, ROS, Kalibr, COLMAP.
#ifndef SHEEN_BASE_CAMERA_EXPORT_H
#define SHEEN_BASE_CAMERA_EXPORT_H

#include "base/camera.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum sheen_camera_format {
    SHEEN_CAMERA_OPENCV, // FileStorage YAML: camera_matrix, distortion_coefficients
    SHEEN_CAMERA_ROS,    // camera_info YAML: plumb_bob or rational_polynomial
    SHEEN_CAMERA_KALIBR, // camchain YAML: pinhole, radtan
    SHEEN_CAMERA_COLMAP  // cameras.txt: PINHOLE, OPENCV or FULL_OPENCV; its pixels begin at the corner: +0.5
} sheen_camera_format;

// By a path's last two endings: ".opencv.yaml", ".ros.yaml", ".kalibr.yaml", ".colmap.txt". EARG.
sheen_status sheen_camera_format_of(sheen_camera_format *out, const char *path, sheen_err *err);
// EUNSUP where the format cannot say what the lens does (the sentence says which model it can); EIO, EACCESS.
sheen_status sheen_camera_export(const sheen_camera *camera, sheen_camera_format format, const char *path,
                                 sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

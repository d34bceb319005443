// SPDX-License-Identifier: Apache-2.0
// pose_file_build.h - what the pose formats share: growing lists of views and cameras, with their checks.
//
// Only pose_file*.c include this.
#ifndef SHEEN_BASE_POSE_FILE_BUILD_H
#define SHEEN_BASE_POSE_FILE_BUILD_H

#include "base/json.h"
#include "base/pose3.h"
#include "base/pose_file.h"

#ifdef __cplusplus
extern "C" {
#endif

// Appends a view whose file is the `length` bytes at `file` ("" where none: `fallback` names it). Its name is the
// file's without folder and extension. EFORMAT where either is too long; ENOMEM.
sheen_status sheen_pose_file_add_view(sheen_pose_file *p, const char *file, size_t length,
                                      const char *fallback, sheen_view **view_out, sheen_err *err);
sheen_status sheen_pose_file_add_camera(sheen_pose_file *p, const sheen_camera *cam, sheen_err *err);

// Each name once, and at least one view. EFORMAT.
sheen_status sheen_pose_file_check(const sheen_pose_file *p, sheen_err *err);

// Like sheen_camera_opencv, with what other programs' files hold: cx, cy with the top-left pixel's centre at
// (0.5, 0.5), and bad numbers are the file's fault: EFORMAT.
sheen_status sheen_camera_from_foreign(sheen_camera *cam, int width_px, int height_px, const double fxycxy[4],
                                       const double *distortion, int n_distortion, sheen_err *err);

// A transforms.json whose cameras may leave out their size: width_px, height_px (> 0) are taken then.
sheen_status sheen_transforms_parse_sized(sheen_pose_file *out, const sheen_json *root, int width_px,
                                          int height_px, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

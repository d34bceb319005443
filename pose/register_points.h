// SPDX-License-Identifier: Apache-2.0
// register_points.h - where a mesh stands, from points of it that a person marked in frames.
#ifndef SHEEN_POSE_REGISTER_POINTS_H
#define SHEEN_POSE_REGISTER_POINTS_H

#include <stddef.h>

#include "base/camera.h"
#include "base/session.h"
#include "pose/outline.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_register_point {
    char frame[64];
    double q_px[2];  // where the frame shows it
    double p_obj[3]; // in the mesh's frame and unit
} sheen_register_point;

enum { SHEEN_REGISTER_MIN_POINTS = 4, SHEEN_REGISTER_MAX_POINTS = 10000 };

// Text: a line a mark, "frame x y X Y Z" (pixels; the mesh's own unit); '#' begins a remark. *points_out is the
// caller's to free. EFORMAT with the line's number; EDATA: none.
sheen_status sheen_register_points_parse(sheen_register_point **points_out, size_t *n_out, const void *data,
                                         size_t size_bytes, sheen_err *err);

typedef struct sheen_register_points_fit {
    sheen_placement placement;
    double rms_px;   // per axis
    double worst_px; // distance of the worst mark
    size_t i_worst, n;
    double sigma_rad, sigma_m; // largest axis; of the marks' centre
} sheen_register_points_fit;

// Least squares over all marks in frames that have a pose, from many starts; unit_m > 0 keeps the scale. EDATA: too
// few, marks in no frame with a pose, or marks that do not determine the place.
sheen_status sheen_register_points_solve(sheen_register_points_fit *out, const sheen_register_point *points,
                                         size_t n_points, const sheen_camera *camera,
                                         const sheen_poses *poses, double unit_m, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

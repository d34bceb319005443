// SPDX-License-Identifier: Apache-2.0
// view_sphere.h - from where a board has been seen, and from where not yet.
#ifndef SHEEN_CALIB_VIEW_SPHERE_H
#define SHEEN_CALIB_VIEW_SPHERE_H

#include <stdbool.h>
#include <stddef.h>

#include "base/camera.h"
#include "calib/view.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SHEEN_VIEW_SPHERE_MAX = 1024 };

typedef struct sheen_view_sphere {
    double v_board[SHEEN_VIEW_SPHERE_MAX][3]; // unit vectors from the board to the camera
    size_t n_views;
} sheen_view_sphere; // zero to begin with

// The unit vector from the (first) board to the camera that sees these tags of it. A camera that is not calibrated yet
// (NULL) is taken for one without distortion whose image is as wide as it is far away: good to some degrees, enough to
// choose views by. False where the tags do not determine it.
bool sheen_view_direction(double v_board[3], const sheen_camera *camera, int width_px, int height_px,
                          const sheen_tag_seen *tags, size_t n_tags);

// Angle to the nearest view so far, radians; pi where there is none.
double sheen_view_sphere_nearest_rad(const sheen_view_sphere *s, const double v_board[3]);
void sheen_view_sphere_add(sheen_view_sphere *s, const double v_board[3]); // beyond the maximum: forgotten
// The largest hole in the ring about the board: the angle on the sphere from its middle (halfway between two neighbours
// and at their mean height) to the nearest view; pi where there are fewer than two. *middle_rad is where it is, as an
// angle about the board against the first view, -pi to pi, positive to the right of whoever stands there.
double sheen_view_sphere_hole_rad(const sheen_view_sphere *s, double *middle_rad);
// "behind", "the right", ... for such an angle.
const char *sheen_view_side(double angle_rad);

#ifdef __cplusplus
}
#endif
#endif

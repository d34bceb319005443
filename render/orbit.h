// SPDX-License-Identifier: Apache-2.0
// orbit.h - viewpoints about an object, and films of them.
#ifndef SHEEN_RENDER_ORBIT_H
#define SHEEN_RENDER_ORBIT_H

#include "base/camera.h"
#include "base/mesh.h"
#include "base/progress.h"
#include "render/draw.h"

#ifdef __cplusplus
extern "C" {
#endif

// Pose that looks at the mesh's centre from azimuth (about world z, 0 = +x, counter-clockwise), elevation
// above the xy plane, at a distance in metres (0: the mesh's sphere fills 80 % of the smaller image side).
// World z is up in the picture.
sheen_status sheen_view_pose(double rt_cam_obj[6], const sheen_mesh *mesh, const double rt_world_obj[6],
                             const sheen_camera *cam, double azimuth_rad, double elevation_rad,
                             double distance_m, sheen_err *err);

// A film through the program ffmpeg: raw frames are piped to it, the file appears under its name when it is
// complete.
typedef struct sheen_film sheen_film;
// EUNSUP: no ffmpeg, or it knows no encoder for the extension (.mp4, .webm). Sizes are made even by cropping.
sheen_status sheen_film_open(sheen_film **out, const char *path, int width_px, int height_px,
                             int frames_per_s, sheen_err *err);
sheen_status sheen_film_add(sheen_film *film, const sheen_image *lin, sheen_err *err);
// Completes the file (or with keep = 0 removes it) and closes. *film is NULL afterwards in every case.
sheen_status sheen_film_close(sheen_film **film, int keep, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

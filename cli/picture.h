// SPDX-License-Identifier: Apache-2.0
// picture.h - a drawn view as a file, in the layer and format asked for; and a folder of them once about.
#ifndef SHEEN_CLI_PICTURE_H
#define SHEEN_CLI_PICTURE_H

#include "cli/stages.h"

typedef struct sheen_cli_picture {
    const char *layer; // NULL or "all", "diffuse", "specular", "mask", "normal", "depth"
    bool transparent;  // an alpha channel of the object's coverage
} sheen_cli_picture;

bool sheen_cli_layer_known(const char *layer);
// mask, normal or depth: drawn from the mesh alone.
bool sheen_cli_layer_is_geometry(const char *layer);

// Draws and writes by path's ending: .exr linear (depth and normals in full floats), else PNG in sRGB (normals as
// (n + 1) / 2, mask and alpha as they are).
sheen_status sheen_cli_picture_save(const sheen_cli_picture *p, const sheen_cli_view *v,
                                    const sheen_camera *cam, const double rt_cam_obj[6], const char *path,
                                    sheen_err *err);

typedef struct sheen_cli_spin {
    int size_px[2]; // 0 x 0: the camera's
    double elevation_deg, distance_m;
    int count;
    const char *format; // "png" or "exr"
    sheen_cli_picture picture;
} sheen_cli_spin;

// A folder: 000.png, 001.png ... from azimuth 0 on, counter-clockwise; index.json (names, azimuths, elevation,
// size); index.html, which shows them turning as one drags.
sheen_status sheen_cli_spin_save(const sheen_cli_view *v, const char *dir, const sheen_cli_spin *spin,
                                 const sheen_progress *progress, sheen_err *err);

#endif

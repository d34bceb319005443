// SPDX-License-Identifier: Apache-2.0
// raster.h - first hits of all samples of a pinhole's picture, without rays. Used inside render only.
#ifndef SHEEN_RENDER_RASTER_H
#define SHEEN_RENDER_RASTER_H

#include <stdbool.h>

#include "render/gbuffer.h"

// Projected vertices: q_px[n][2] pixels, NaN for those not before the camera; inverse_z_m[n] 1 / z_cam.
typedef struct sheen_projected {
    double *q_px;
    double *inverse_z_m;
} sheen_projected;

// Whether the mesh can be drawn so: the lens is a pinhole, every vertex is before the camera, and none is so
// far out of the window that a float would not hold its place to SHEEN_RASTER_ERROR_PX.
#define SHEEN_RASTER_ERROR_PX 1e-3
bool sheen_raster_can(const sheen_gbuffer *g, const sheen_camera *cam, const sheen_mesh *mesh,
                      const sheen_projected *at);

// The triangles of a window's bands of rows (of samples).
typedef struct sheen_raster_bands sheen_raster_bands;

// g: the window and its samples. The mesh is lent until the release. ENOMEM.
sheen_status sheen_raster_bands_new(sheen_raster_bands **out, const sheen_gbuffer *g, const sheen_mesh *mesh,
                                    const sheen_camera *cam, const sheen_projected *at, int band_rows,
                                    sheen_err *err);
void sheen_raster_bands_free(sheen_raster_bands **bands);

// The hits of one band, row after row. The same as rays through the samples have, except that a sample within
// SHEEN_RASTER_ERROR_PX of a triangle's edge may go to its neighbour. The result does not depend on the bands, nor on
// the instruction set but for the last bits of b1, b2, t_m. May be called from several threads at once. ENOMEM.
sheen_status sheen_raster_bands_hits(const sheen_raster_bands *r, sheen_hit *hits, int number,
                                     sheen_err *err);

#endif

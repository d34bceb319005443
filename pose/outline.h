// SPDX-License-Identifier: Apache-2.0
// outline.h - the outline of a mesh in a picture: what it covers, and samples along the border of that.
//
// The border consists of edges between a triangle that faces the camera and one that does not (or edges with one
// triangle alone), beside which the picture is empty. Samples are points of such edges, so that their motion with
// the pose is known exactly.
#ifndef SHEEN_POSE_OUTLINE_H
#define SHEEN_POSE_OUTLINE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/camera.h"
#include "base/mesh.h"
#include "base/pose3.h"

#ifdef __cplusplus
extern "C" {
#endif

// A mesh's vertices and edges, vertices of the same place being one. Read-only once made; shared by threads.
typedef struct sheen_outline_mesh {
    size_t n_vertices, n_triangles, n_edges;
    float *p_obj;        // [n_vertices][3]
    uint32_t *triangles; // [n_triangles][3]
    uint32_t *edges;     // [n_edges][4]: two vertices, two triangles (UINT32_MAX: none)
} sheen_outline_mesh;

sheen_status sheen_outline_mesh_make(sheen_outline_mesh *out, const sheen_mesh *mesh, sheen_err *err);
// A coarser one for quick looks: vertices of a grid of `cells` cells along the mesh's longest side become their
// mean; triangles that vanish are dropped.
sheen_status sheen_outline_mesh_coarsen(sheen_outline_mesh *out, const sheen_outline_mesh *mesh, int cells,
                                        sheen_err *err);
void sheen_outline_mesh_release(sheen_outline_mesh *mesh);

// Where an object's point goes: p_board = R (scale p_obj) + t.
typedef struct sheen_placement {
    sheen_Rt Rt_board_obj;
    double scale;
} sheen_placement;

// A picture in which outlines are drawn: the camera's, made `factor` (<= 1) times as large. Pixel centres keep
// their place: q' + 1/2 = factor (q + 1/2).
typedef struct sheen_outline_canvas {
    const sheen_camera *camera;
    sheen_Rt Rt_cam_board;
    double factor;
    int width_px, height_px;
} sheen_outline_canvas;

typedef struct sheen_outline_sample {
    double q_px[2];      // in the canvas
    double n_px[2];      // unit, outwards
    double p_board[3];   // the point
    double dq_dboard[6]; // [2][3], how q_px follows the point
    double length_px;    // of the outline that it stands for
} sheen_outline_sample;

// Room for one outline at a time; belongs to one thread.
typedef struct sheen_outline {
    sheen_outline_sample *samples;
    size_t n_samples;
    uint8_t *cover; // [height_px][width_px], 1: covered
    int width_px, height_px;
    int box_px[4]; // of the cover: x0 y0 x1 y1, ends exclusive; empty where nothing is covered
    // scratch
    size_t n_vertices, sample_capacity, cover_capacity;
    double *p_cam, *q_px, *sample_room;
    float *p_board;
} sheen_outline;

// Draws the mesh and samples its outline every spacing_px. *out starts as {0} and is used again and again; a mesh
// that is not in view has no samples. ENOMEM, EARG (camera).
sheen_status sheen_outline_draw(sheen_outline *out, const sheen_outline_mesh *mesh,
                                const sheen_placement *placement, const sheen_outline_canvas *canvas,
                                double spacing_px, sheen_err *err);
void sheen_outline_release(sheen_outline *outline);

#ifdef __cplusplus
}
#endif
#endif

// SPDX-License-Identifier: Apache-2.0
// mask_scene.h - an object on the board from several sides, as masks: what the tests of registration look at.
#ifndef SHEEN_TESTS_MASK_SCENE_H
#define SHEEN_TESTS_MASK_SCENE_H

#include <stdbool.h>

#include "base/board.h"
#include "base/camera.h"
#include "base/image.h"
#include "base/mesh.h"
#include "pose/register_search.h"

enum { MASK_SCENE_MAX_VIEWS = 16 };

typedef struct mask_scene {
    sheen_camera camera;
    size_t n_views;
    sheen_register_view views[MASK_SCENE_MAX_VIEWS];
    sheen_image masks[MASK_SCENE_MAX_VIEWS];
    sheen_image pictures[MASK_SCENE_MAX_VIEWS]; // a shaded object before a grey ground; data NULL: none
} mask_scene;

typedef struct mask_scene_options {
    int width_px, height_px;
    size_t n_views;
    double distance_m, pose_noise; // in parts of .02 mm and .01 degrees
    double mask_noise_px;          // sigma by which the masks' borders wander, over some ten pixels
    int with_pictures;
    uint64_t seed;
} mask_scene_options;

// Masks of a mesh that stands on the board where its file says (board frame, metres), through a lens.
void mask_scene_make(mask_scene *scene, const sheen_mesh *mesh, const mask_scene_options *options);
void mask_scene_release(mask_scene *scene);

// A figure without any symmetry, standing on z = 0 about the origin, some 0.12 m high; and one that has all about
// its axis.
void mask_scene_figure(sheen_mesh *mesh);
void mask_scene_bottle(sheen_mesh *mesh);

// A thick-walled block with rounded edges, one corner drawn out; as large.
void mask_scene_block(sheen_mesh *mesh);

// What goes wrong with masks that are cut out of pictures: wider by a pixel all around; a round piece of the border
// missing, elsewhere in each; a shadow on the ground beside the object taken for a part of it.
typedef enum mask_scene_fault { MASK_SCENE_WIDER, MASK_SCENE_BITTEN, MASK_SCENE_SHADOW } mask_scene_fault;
void mask_scene_spoil(mask_scene *scene, mask_scene_fault fault, uint64_t *seed);

// Reflectance of the print at a place of the board, with black squares for tags; false: beyond it.
bool mask_scene_print(float rgb[3], const sheen_board *board, double x_m, double y_m);

// The mesh in another frame and unit: p' = R^T (p - t) / unit_m, with the pose given.
void mask_scene_move(sheen_mesh *out, const sheen_mesh *mesh, const double rt_board_obj[6], double unit_m);

// Largest distance between where a placement puts the moved mesh's vertices and where they were, and the angle.
void mask_scene_error(double *distance_m, double *angle_rad, const sheen_placement *placement,
                      const double rt_board_obj[6], double unit_m, const sheen_mesh *mesh);

#endif

// SPDX-License-Identifier: Apache-2.0
// register_search.h - where a mesh stands on the board, from masks alone: many starts, the best refined, and a word
// on how sure that is.
//
// The object stands on the board's plane on one of its sides. Starts are all yaws of a grid for each side asked for;
// the place comes from the masks' centres, the size, where it is not known, from their areas. Starts slide on the
// board (yaw, place, size) in small pictures with a coarse mesh; the best are freed and fitted in full ones.
#ifndef SHEEN_POSE_REGISTER_SEARCH_H
#define SHEEN_POSE_REGISTER_SEARCH_H

#include <stdbool.h>
#include <stddef.h>

#include "base/camera.h"
#include "base/image.h"
#include "base/mesh.h"
#include "base/progress.h"
#include "pose/outline_fit.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_register_view {
    double rt_cam_board[6];
    const sheen_image *mask;  // of the camera's size, one channel; negative or NaN: not known
    const sheen_image *light; // likewise, brightness as the eye divides it; NULL: none
} sheen_register_view;

// Sides of the mesh that may point up: bits 1 << (2 axis + negative).
enum {
    SHEEN_UP_X = 1,
    SHEEN_UP_MINUS_X = 2,
    SHEEN_UP_Y = 4,
    SHEEN_UP_MINUS_Y = 8,
    SHEEN_UP_Z = 16,
    SHEEN_UP_MINUS_Z = 32,
    SHEEN_UP_ANY = 63
};

typedef struct sheen_register_options {
    unsigned ups;     // 0: any
    double unit_m;    // metres in one unit of the mesh; 0: find out
    bool fit_scale;   // let the size go even where the unit is known
    bool rough_masks; // their borders are right, but pieces of the object may be missing inside
    bool edges;       // end with the pictures' edges rather than the masks' borders
    int n_threads;    // 0: one per processor
    sheen_progress progress;
} sheen_register_options;

typedef enum sheen_register_state {
    SHEEN_REGISTER_SURE,
    SHEEN_REGISTER_AMBIGUOUS, // another place fits as well
    SHEEN_REGISTER_POOR       // even the best does not fit
} sheen_register_state;

typedef struct sheen_registration {
    sheen_placement placement; // p_board = R (scale p_obj) + t
    sheen_register_state state;
    char reason[240];            // where not sure
    unsigned up;                 // the side that points up
    double unit_m;               // the unit that the scale stands for; 0: none that is in use
    sheen_outline_misfit misfit; // in full pictures
    double sigma_rad,
        sigma_m; // one standard deviation: largest axis; distance of the vertex that is known worst
    double second_border_px; // misfit of the next best, different, place; NaN: there is none
    double second_angle_rad, second_distance_m; // how far that is
    double height_m;                            // of the object's lowest point above the board
    size_t n_views;
} sheen_registration;

// EDATA: no mask shows anything, or the mesh fits nowhere near; EARG (mesh empty or not finite); ECANCEL, ENOMEM.
// Success may yet be ambiguous or poor: see state.
sheen_status sheen_register_search(sheen_registration *out, const sheen_mesh *mesh,
                                   const sheen_camera *camera, const sheen_register_view *views,
                                   size_t n_views, const sheen_register_options *options, sheen_err *err);

// The same from a place that is known roughly (a degree or two, a part in twenty of its size): refined, and judged by
// its misfit alone.
sheen_status sheen_register_refine(sheen_registration *out, const sheen_mesh *mesh,
                                   const sheen_camera *camera, const sheen_register_view *views,
                                   size_t n_views, const sheen_placement *start,
                                   const sheen_register_options *options, sheen_err *err);

// "x", "-x", "y", ... of one bit of ups; the unit's name ("mm") or "" .
const char *sheen_up_name(unsigned up);
const char *sheen_unit_name(double unit_m);

#ifdef __cplusplus
}
#endif
#endif

// SPDX-License-Identifier: Apache-2.0
// outline_fit.h - a mesh's place from its outlines in several views against masks, and against image edges.
//
// From every sample of the outline one looks along its normal for the mask's border (or the steepest step of the
// picture's brightness): the signed distance there is the residual, n . dq/dp . dp/d(pose, scale) its gradient.
// Gauss-Newton with weights that let go of what lies far off (Geman and McClure), drawing anew at every step.
#ifndef SHEEN_POSE_OUTLINE_FIT_H
#define SHEEN_POSE_OUTLINE_FIT_H

#include <stdbool.h>
#include <stddef.h>

#include "base/image.h"
#include "pose/outline.h"

#ifdef __cplusplus
extern "C" {
#endif

// A view to fit to, at the canvas' size. What is negative or NaN in a mask is not known.
typedef struct sheen_outline_view {
    sheen_outline_canvas canvas;
    const float *mask;  // [height_px][width_px], the object's share of the pixel
    const float *light; // [height_px][width_px], brightness in equal steps for the eye; NULL: no image edges
} sheen_outline_view;

// The views of a fit, and room for an outline each, starting as {0}.
typedef struct sheen_outline_views {
    const sheen_outline_view *views;
    sheen_outline *outlines;
    size_t n_views;
} sheen_outline_views;

// Unknowns: turn about the pivot (3, board axes), move (3), logarithm of the scale, by how much all borders lie
// outside of the object (pixels: masks that were cut too wide, or at another brightness).
enum { SHEEN_OUTLINE_UNKNOWNS = 8, SHEEN_OUTLINE_SCALE = 6, SHEEN_OUTLINE_OFFSET = 7 };

typedef struct sheen_outline_fit_options {
    bool free[SHEEN_OUTLINE_UNKNOWNS];
    bool
        pivot_on_board; // about the foot of the object's centre rather than the centre: what stands keeps standing
    bool edges;         // to the image's edges rather than the masks' borders
    double reach_px;   // how far a border is looked for
    double spacing_px; // of samples
    int max_steps;
} sheen_outline_fit_options;

typedef struct sheen_outline_misfit {
    double rms_px;    // of the distances that were found, weighted
    double border_px; // area by which cover and mask differ, divided by the length of the outline
    double overlap;   // of cover and mask: intersection over union, over all views
    double found;     // share of the outline, where the mask is known, from which a border was found
    double covariance[SHEEN_OUTLINE_UNKNOWNS *
                      SHEEN_OUTLINE_UNKNOWNS]; // outline_residuals.h, sheen_outline_covariance
    double offset_px; // of the borders from the outlines, outwards, where it was free
    double moved_m;   // by the last step
} sheen_outline_misfit;

// Moves *placement to where it fits best near its start. centre_obj is the pivot in the mesh's frame (before scale).
// EDATA: no outline is near any mask.
sheen_status sheen_outline_fit(sheen_placement *placement, sheen_outline_misfit *misfit,
                               const sheen_outline_mesh *mesh, const sheen_outline_views *views,
                               const double centre_obj[3], const sheen_outline_fit_options *options,
                               sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

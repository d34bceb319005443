// SPDX-License-Identifier: Apache-2.0
// align.h - poses and exposures of the photographs, made to agree on the surface (photo-consistency).
//
// A point of the surface has one diffuse colour D in all photographs that see it:
//
//     I_v(q_v(p)) / g_v = D(p) + S_v(p)
//
// I_v photograph v, q_v its projection, g_v its gain (exposure and white balance), S_v the light of highlights and mirror
// images where a model predicts it already, else 0 and an outlier to the Lorentzian loss. All poses and gains are solved
// together by Gauss-Newton, each D eliminated in closed form, so that a motion common to all photographs converges as
// fast as any other. Hand-held sessions (on a turntable D changes with the angle).
#ifndef SHEEN_FIT_ALIGN_H
#define SHEEN_FIT_ALIGN_H

#include "fit/photos.h"
#include "fit/view_light.h"
#include "render/gbuffer.h"

typedef struct sheen_align_options {
    int poses, gains;    // what to refine
    double prior_px;     // standard deviation of poses whose covariance is not known, on the object; 0: 2 px
    double prior_ev;     // of the given exposures; 0: 0.5
    double white_lin;    // from here on a pixel is clipped; 0: 0.97
    int texels_per_edge; // of the lattice of points
    const sheen_view_light
        *lights; // [n_views] of that lattice: what is predicted besides D; NULL: nothing yet
    int n_threads;
    sheen_progress progress;
} sheen_align_options;

typedef struct sheen_align_view {
    double moved_px; // rms motion of the object's points in the picture
    double sigma_px; // standard deviation of what is left, as the residuals tell it (mean over the points)
    double gain[3];  // by which the photograph was brighter than their geometric mean
} sheen_align_view;

typedef struct sheen_align_result {
    sheen_align_view *views; // [n_views]
    size_t n_views, n_points;
    int poses_kept, gains_kept;       // 0: not asked for, or the points left out were not predicted better
    double error_before, error_after; // robust scale of the disagreement on points left out, linear light
} sheen_align_result;

// Refines the poses (rt_cam_obj) of *photos, and tells the gains; the pictures stay as they are. Half of the points are used, the other half decides:
// poses and gains are kept only where they predict it better, and poses only where they can be believed (align_proof.c). scene: of the mesh.
// ENOMEM, ECANCEL. Where fewer than a few hundred points are seen twice nothing is changed. The result does not depend on n_threads.
sheen_status sheen_align_photos(sheen_align_result *out, sheen_photos *photos, const sheen_mesh *mesh,
                                const sheen_scene *scene, const sheen_align_options *options, sheen_err *err);
void sheen_align_result_release(sheen_align_result *r);

// Gives every photograph a picture of its own that is divided by its gain; taken[n_views] receives the pictures that it had,
// for sheen_align_give_back. ENOMEM: nothing has changed.
sheen_status sheen_align_divide(sheen_image *taken, sheen_photos *photos, const sheen_align_result *r,
                                sheen_err *err);
void sheen_align_give_back(sheen_photos *photos, sheen_image *taken);

#endif

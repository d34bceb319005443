// SPDX-License-Identifier: Apache-2.0
// fit_session.h - the stage "fit": a session's photographs, camera, poses and mesh become its model/.
#ifndef SHEEN_FIT_FIT_SESSION_H
#define SHEEN_FIT_FIT_SESSION_H

#include "base/session.h"
#include "fit/certainty.h"
#include "fit/method.h"

// What the paper reports, and what a person asks.
typedef struct sheen_fit_summary {
    char method[24];
    double f0; // reflectance at normal incidence; NaN: not part of the method
    size_t n_views, n_samples;
    size_t n_dark; // photographs left out because they show nothing, and the name of the first
    char dark_name[64];
    int texels_per_edge;
    double seen_share; // of the texels
    size_t n_nodes, n_reached, n_assigned,
        n_left; // hemisphere; reached by a mirror shot; kept by the check; lit at the end
    double sigma0_rad, sigma_rad, k_s, sigma_err, objective, light_rgb[3];
    int converged;
    int poses_refined, exposures_refined; // by the photographs' agreement (align.h)
    double pose_moved_px, pose_sigma_px;  // root mean squares over the photographs
    double exposure_range_ev;             // between the brightest and the darkest
    sheen_certainty certainty;
    sheen_refine_turn *turns; // [n_turns] sigma, k_S, E and the nodes left, turn by turn
    size_t n_turns;
} sheen_fit_summary;

void sheen_fit_summary_release(sheen_fit_summary *f);

// Fits the input frames and replaces model/ in one step: model.json, texture.exr and the pictures (pictures.h). On any
// failure the session is as it was.
sheen_status sheen_fit_session(sheen_fit_summary *out, const sheen_session *s, sheen_fit_method method,
                               const sheen_paper_options *options, sheen_err *err);

// True where model/ was made from the session's present inputs.
bool sheen_fit_is_current(const sheen_session *s);

#endif

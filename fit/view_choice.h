// SPDX-License-Identifier: Apache-2.0
// view_choice.h - in which photographs a triangle is looked at, where more face it than an estimate needs.
//
// Of the photographs that a triangle's front faces at most a number is kept: those whose hash of triangle and camera centre is least. So
// the choice is even over the viewpoints, another one for each triangle, and does not depend on the photographs' order.
#ifndef SHEEN_FIT_VIEW_CHOICE_H
#define SHEEN_FIT_VIEW_CHOICE_H

#include "fit/texel_view.h"

typedef struct sheen_view_choice {
    uint32_t *highest; // [n_triangles] hash up to which a photograph is looked at; NULL: all are
    size_t n_triangles;
} sheen_view_choice;

// cameras_obj: [n_views][3] centres of projection. ENOMEM.
sheen_status sheen_view_choice_make(sheen_view_choice *out, const sheen_mesh *mesh,
                                    const double (*cameras_obj)[3], size_t n_views, size_t most_views,
                                    int n_threads, sheen_err *err);
void sheen_view_choice_release(sheen_view_choice *c);

// Unsees the texels of triangles that are not looked at from this camera centre.
void sheen_view_choice_apply(const sheen_view_choice *c, sheen_texel_view *v, const double camera_obj[3]);

#endif

// SPDX-License-Identifier: Apache-2.0
// register_pictures.h - the masks in the size in which outlines are fitted, and what they say of place and size.
#ifndef SHEEN_POSE_REGISTER_PICTURES_H
#define SHEEN_POSE_REGISTER_PICTURES_H

#include "pose/register_search.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_register_pictures {
    sheen_outline_view *views;
    sheen_outline *outlines;
    float *pixels; // all of them
    size_t n_views;
    double factor;
} sheen_register_pictures;

// At most max_views of them, evenly chosen among those that show something, made smaller so that the object's
// longest side is about size_px (never larger than they are; INFINITY: as they are). EDATA: no mask shows anything.
sheen_status sheen_register_pictures_make(sheen_register_pictures *out, const sheen_camera *camera,
                                          const sheen_register_view *views, size_t n_views, size_t max_views,
                                          double size_px, sheen_err *err);
void sheen_register_pictures_release(sheen_register_pictures *p);

// The point of the board's frame that is nearest to the lines of sight through the masks' centres. EDATA.
sheen_status sheen_register_centre(double centre_board[3], const sheen_register_pictures *p, sheen_err *err);

// Area of the masks, and of what the outlines last drawn cover, in canvas pixels over all views.
double sheen_register_mask_area(const sheen_register_pictures *p);
double sheen_register_cover_area(const sheen_register_pictures *p);

#ifdef __cplusplus
}
#endif
#endif

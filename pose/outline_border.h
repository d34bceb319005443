// SPDX-License-Identifier: Apache-2.0
// outline_border.h - how far from a sample of an outline, along its normal, a picture shows it.
#ifndef SHEEN_POSE_OUTLINE_BORDER_H
#define SHEEN_POSE_OUTLINE_BORDER_H

#include <stdbool.h>

#include "pose/outline_fit.h"

#ifdef __cplusplus
extern "C" {
#endif

// False where the mask is not known there, or the sample lies outside of the picture.
bool sheen_outline_mask_known(const sheen_outline_view *v, const sheen_outline_sample *s);

// Distance to the mask's border, outwards from inside the mask, inwards from outside. False: none within reach_px.
bool sheen_outline_find_border(double *distance_px, const sheen_outline_view *v,
                               const sheen_outline_sample *s, double reach_px);

// Distance to the steepest step of brightness, nearer ones being preferred. False: none within reach_px, or no picture.
bool sheen_outline_find_edge(double *distance_px, const sheen_outline_view *v, const sheen_outline_sample *s,
                             double reach_px);

#ifdef __cplusplus
}
#endif
#endif

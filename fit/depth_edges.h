// SPDX-License-Identifier: Apache-2.0
// depth_edges.h - is a pixel far enough from where the view passes from one surface to another?
#ifndef SHEEN_FIT_DEPTH_EDGES_H
#define SHEEN_FIT_DEPTH_EDGES_H

#include <stdbool.h>

#include "render/gbuffer.h"

// True where the 3x3 pixels round (x_px, y_px) of the image all show surface at about distance_m from the camera:
// within what a surface that meets the line of sight at this cosine (n.v > 0) can change over two pixels.
// footprint_per_m: size of a pixel per metre of distance, 1 / focal length in px. g: one sample a pixel.
bool sheen_clear_of_depth_edges(const sheen_gbuffer *g, int x_px, int y_px, float distance_m, float cosine,
                                float footprint_per_m);

#endif

// SPDX-License-Identifier: Apache-2.0
// pictures.h - the paper's pictures of a fit: residual images (figure 5), hemispheres (figure 6), global texture.
#ifndef SHEEN_FIT_PICTURES_H
#define SHEEN_FIT_PICTURES_H

#include "fit/paper.h"

// Writes into `dir`, which exists:
//   residual-<view>.png             residual image, bright as in the photograph
//   hemisphere-partial-<view>.png   partial illumination hemispheres
//   hemisphere-mask.png             mask hemisphere: in how many views each node was reached
//   hemisphere-combined.png         after the consistency check
//   hemisphere-refined.png          after the estimation, each light splatted
//   texture.png                     the atlas, sRGB; what was never seen is magenta
// Hemispheres are seen from above (+z), +x to the right, the horizon as the rim; their brightness is scaled to the 99th
// percentile of the lit nodes.
sheen_status sheen_fit_pictures(const sheen_paper_fit *f, const sheen_photos *photos, const char *dir,
                                sheen_err *err);

#endif

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
//   texture-deviation.png           the atlas of the texels' standard deviations (luminance, linear light, times SHEEN_DEVIATION_SCALE);
//                                   white where one photograph only saw the texel, magenta where none did
//   deviation.png                   the same as the first photograph sees it
// Hemispheres are seen from above (+z), +x to the right, the horizon as the rim; their brightness is scaled to the 99th
// percentile of the lit nodes.
#define SHEEN_DEVIATION_SCALE 20

sheen_status sheen_fit_pictures(const sheen_paper_fit *f, const sheen_photos *photos, const char *dir,
                                sheen_err *err);

#endif

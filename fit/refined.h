// SPDX-License-Identifier: Apache-2.0
// refined.h - beyond the paper: cast shadows, mirrored surroundings with Fresnel's term, and a texture re-estimated
// after the highlights.
#ifndef SHEEN_FIT_REFINED_H
#define SHEEN_FIT_REFINED_H

#include "fit/paper.h"

// Starts from a finished paper fit of the same mesh and photographs and improves its model, residuals and hemispheres in
// place. Photographs of a camera that moved. EDATA, ECANCEL, ENOMEM; *f then still has its paper model or is to be released.
// The photographs may come back with poses corrected.
sheen_status sheen_refined_fit(sheen_paper_fit *f, const sheen_mesh *mesh, sheen_photos *photos,
                               const sheen_paper_options *options, sheen_err *err);

#endif

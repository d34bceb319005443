// SPDX-License-Identifier: Apache-2.0
// radiometry_private.h - what the radiometry*.c files share among themselves.
#ifndef SHEEN_BASE_RADIOMETRY_PRIVATE_H
#define SHEEN_BASE_RADIOMETRY_PRIVATE_H

#include "base/radiometry.h"

// Codes as RGB in linear light, by the curve of r where it has one, else by f->transfer; less the dark frame's where r
// has one. `codes`: as sheen_frame_codes gives them. EFORMAT where the dark frame is of another kind.
sheen_status sheen_radiometry_light(sheen_image *out, const sheen_radiometry *r, const sheen_frame_info *f,
                                    const sheen_raster *codes, sheen_err *err);

#endif

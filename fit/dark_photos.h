// SPDX-License-Identifier: Apache-2.0
// dark_photos.h - photographs that show nothing: the lens cap, a shutter that stayed shut, a file of no finite number.
//
// They see the object, by their pose, and would say that it is black from there.
#ifndef SHEEN_FIT_DARK_PHOTOS_H
#define SHEEN_FIT_DARK_PHOTOS_H

#include "fit/photos.h"

// Leaves out of *photos those whose mean luminance (within the mask) is below 1/128 of the median one's, seven stops, beyond what
// exposures are evened out for; n_dark and dark_name tell. EDATA: all are black.
sheen_status sheen_photos_leave_out_dark(sheen_photos *photos, sheen_err *err);

#endif

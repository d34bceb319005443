// SPDX-License-Identifier: Apache-2.0
// method.h - the methods of fitting, behind one call.
#ifndef SHEEN_FIT_METHOD_H
#define SHEEN_FIT_METHOD_H

#include "fit/paper.h"

typedef enum sheen_fit_method {
    SHEEN_FIT_REFINED, // the paper's start, then lamps, mirrored surroundings and texture, refined (refined.h): the default
    SHEEN_FIT_PAPER, // Nishino, Zhang, Ikeuchi 2001, to the letter
    SHEEN_FIT_METHOD_COUNT
} sheen_fit_method;

const char *sheen_fit_method_name(sheen_fit_method m); // "refined", "paper"
sheen_status sheen_fit_method_from_name(sheen_fit_method *out, const char *name, sheen_err *err);

// Fits by a method. moving: what moved between the photographs; the refined method wants a camera that did (EUNSUP).
// Otherwise as sheen_paper_fit_make; *out is released on failure.
sheen_status sheen_fit_make(sheen_paper_fit *out, sheen_fit_method method, sheen_moving moving,
                            const sheen_mesh *mesh, sheen_photos *photos, const sheen_paper_options *options,
                            sheen_err *err);

#endif

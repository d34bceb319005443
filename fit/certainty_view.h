// SPDX-License-Identifier: Apache-2.0
// certainty_view.h - the viewpoint from which one more photograph would tell most.
#ifndef SHEEN_FIT_CERTAINTY_VIEW_H
#define SHEEN_FIT_CERTAINTY_VIEW_H

#include "fit/certainty.h"

// Tries viewpoints all about the object, at the photographs' mean distance: each counts the lamps whose highlight it would
// show and which fewer than two photographs show so far, and the surface that fewer than two photographs saw. Sets the
// advice of *c where the best is worth a photograph. ENOMEM.
sheen_status sheen_certainty_advise(sheen_certainty *c, const sheen_model *model, const sheen_mesh *mesh,
                                    const sheen_photos *photos, sheen_err *err);

#endif

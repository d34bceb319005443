// SPDX-License-Identifier: Apache-2.0
// stand_still.h - a model of an object that turned, as one of an object that stands as it did in the first photograph.
#ifndef SHEEN_RENDER_STAND_STILL_H
#define SHEEN_RENDER_STAND_STILL_H

#include "render/model.h"

#ifdef __cplusplus
extern "C" {
#endif

// The lights then turn with the object (or the camera goes round both): the texture takes the light of that place on, and
// the model is one of a camera that moves. For formats that know no light on the diffuse part. Nothing is done to a model
// that is one already. ENOMEM.
sheen_status sheen_model_stand_still(sheen_model *m, int n_threads, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

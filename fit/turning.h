// SPDX-License-Identifier: Apache-2.0
// turning.h - the diffuse step of the refined method where the object turned under lights that stood still.
#ifndef SHEEN_FIT_TURNING_H
#define SHEEN_FIT_TURNING_H

#include "fit/refined_state.h"

// Lamps of the diffuse light, where those stand that the highlights showed: neighbours gathered into one. Their strengths are 0.
void sheen_turning_lamps(sheen_irradiance *e, const sheen_model *model);

// Given the rest of the model (lights, surroundings): its irradiance from a part of the texels, then the albedo of every
// texel. How fine the irradiance may be is chosen by cross-validation when it first has lamps. ENOMEM.
sheen_status sheen_turning_diffuse(sheen_refined_state *r, sheen_err *err);

// Adds sign times what the turn changes of a texel's diffuse light, a (E - 1), to the views' predicted lights: with it, a
// texel's photographs differ by what is mirrored only, as those of an object that stood still do.
void sheen_turning_shift(sheen_refined_state *r, float sign);

#endif

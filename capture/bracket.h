// SPDX-License-Identifier: Apache-2.0
// bracket.h - takes a bracket of exposures of a camera that stands still, as one frame.
#ifndef SHEEN_CAPTURE_BRACKET_H
#define SHEEN_CAPTURE_BRACKET_H

#include "capture/ladder.h"

// How long exposure i of n is, in those of the lock.
double sheen_bracket_factor(int i, int n);

// After `frame` was taken at the lock's exposure: n_exposures (2 to SHEEN_BRACKET_MAX) pairs of pictures, each four times
// as long as the one before, about the lock's exposure; then that exposure again. *frame becomes what they make
// together, an OpenEXR picture that *payload_out holds (caller frees). EUNSUP (exposure cannot be set), EDATA (the
// picture does not rest), and what the ladder reports. The session's curve and dark frames are applied to each exposure
// (radiometry.h), EDATA where it has dark frames, and none of such an exposure; its flat field is not.
sheen_status sheen_bracket_take(sheen_frame *frame, uint8_t **payload_out, const sheen_session *session,
                                sheen_ladder *ladder, int n_exposures, sheen_err *err);

#endif

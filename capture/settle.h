// SPDX-License-Identifier: Apache-2.0
// settle.h - whether a camera's picture has come to rest after a change of settings, judged by the picture itself.
#ifndef SHEEN_CAPTURE_SETTLE_H
#define SHEEN_CAPTURE_SETTLE_H

#include <stdbool.h>

#include "base/image.h"

// Settings lag by up to six frames or so; SHEEN_SETTLE_STILL frames in a row must then agree.
enum { SHEEN_SETTLE_MIN = 10, SHEEN_SETTLE_STILL = 4, SHEEN_SETTLE_GIVE_UP = 90 };

typedef struct sheen_settle {
    int n_frames;
    float rgb[SHEEN_SETTLE_STILL][3]; // means of the last frames
} sheen_settle;                       // zero to begin with

// Mean linear light of the picture, over some ten thousand pixels.
void sheen_settle_mean(float rgb[3], const sheen_raster *r, sheen_transfer transfer);
// Adds a frame that was exposed after the change. True: at rest, the means of the last frames differ by less than 2 %.
bool sheen_settle_add(sheen_settle *s, const float rgb[3]);
// The largest relative difference among the last frames' means, 0..1.
float sheen_settle_spread(const sheen_settle *s);

#endif

// SPDX-License-Identifier: Apache-2.0
// rounds.h - where the camera stood while an object turned on its table: once, or at another place in each round.
//
// A table turns about one axis, which lies still in the board's frame: two frames of one round differ by a turn about
// it. Where they do not, the camera was moved in between; then the commanded angles, which count on from round to round, say
// how the object stood, and with that where the camera is.
#ifndef SHEEN_FIT_ROUNDS_H
#define SHEEN_FIT_ROUNDS_H

#include <stddef.h>

#include "base/status.h"

enum { SHEEN_MAX_ROUNDS = 9, SHEEN_ROUND_LEAST_FRAMES = 3 };

typedef struct sheen_round_frame {
    char name[64];
    double rt_cam_board[6];
    double asked_rad; // commanded angle of the table; NaN: none
    int round;        // out: 0, 1, ...; -1: belongs to none
} sheen_round_frame;

typedef struct sheen_rounds {
    double rt_world_cam[SHEEN_MAX_ROUNDS][6]; // world: the board's frame in frames[i_first]
    int n;
    double most_off_deg; // how far the commanded angles and the poses disagree; 0 for one round
} sheen_rounds;

// Frames in the order in which they were taken. One round takes no commanded angles. A frame that belongs to no round, or to
// one of fewer than SHEEN_ROUND_LEAST_FRAMES besides the first round, is marked by -1. EDATA: several rounds, and nothing tells
// how the table stood in them.
sheen_status sheen_rounds_find(sheen_rounds *out, sheen_round_frame *frames, size_t n_frames, size_t i_first,
                               sheen_err *err);

#endif

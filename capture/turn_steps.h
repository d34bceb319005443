// SPDX-License-Identifier: Apache-2.0
// turn_steps.h - the recording of a turntable's rounds: turn, let the picture come to rest, take one frame, and so on.
//
// A policy for sheen_record (capture/record.h). What is done is read from the session: the frame of round r and step k is
// called "r<r>-<k>", that of the empty table "r1-empty", so that a recording that ended anywhere goes on where it was.
#ifndef SHEEN_CAPTURE_TURN_STEPS_H
#define SHEEN_CAPTURE_TURN_STEPS_H

#include "capture/record.h"
#include "capture/turntable.h"

typedef struct sheen_turn_options {
    int n_steps, n_rounds; // frames a turn; turns, each with the camera at another height
    // Where the tags say that the table stands in this frame, degrees from where `reference`'s frame shows it (NULL: this
    // frame becomes the reference, angle 0). EDATA: not to be seen. NULL: nobody looks.
    sheen_status (*see)(void *self, const sheen_frame *frame, const sheen_frame_info *reference,
                        double *angle_deg, sheen_err *err);
    // Before the first frame of a round after the first; returns when the camera stands at its new height. Until then it
    // stands as in the round before, and `see` looks there.
    sheen_status (*next_round)(void *self, int i_round, sheen_err *err);
    // The first round begins with a frame of the table without the object, of role background. Asks for the object to be
    // taken off, and then to be put on; returns when that is done. It stays there: rounds are tied by where it stands. NULL: no
    // such frame.
    sheen_status (*place_object)(void *self, bool on, sheen_err *err);
    void *self;           // for all
    double tolerance_deg; // of the angle seen beside the one commanded; 0: 0.5
} sheen_turn_options;

typedef struct sheen_turn_steps {
    sheen_session *session;
    sheen_table *table;
    sheen_turn_options o;
    int i_round, i_step; // what is wanted now; rounds from 1, step -1: the empty table
    bool *taken; // [n_rounds * (1 + n_steps)] frames in the session or on their way there, steps from -1
    int n_taken; // of this round, in this run
    bool placed; // the angle is known in this round
    bool camera_waits; // to be put at the round's height, once it is
    bool object_waits; // to be put on
    bool turned;       // and the table stands there
    int64_t stood_ns;  // since when
    // The picture's rest.
    float *blocks; // [2][n_blocks]
    int n_still, n_looked, n_old;
} sheen_turn_steps;

// How many frames are missing; 0: all are there.
size_t sheen_turn_steps_missing(const sheen_session *s, const sheen_turn_options *o);
// Lends session and table. EARG (the empty table is wanted, and frames of the object are there already), ENOMEM.
sheen_status sheen_turn_steps_init(sheen_turn_steps *t, sheen_session *session, sheen_table *table,
                                   const sheen_turn_options *options, sheen_err *err);
void sheen_turn_steps_release(sheen_turn_steps *t);
// Fails like the table; EDATA: the picture does not come to rest, or the table did not turn as far as it was told.
sheen_record_policy sheen_turn_steps_policy(sheen_turn_steps *t);

#endif

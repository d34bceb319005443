// SPDX-License-Identifier: Apache-2.0
// ladder.h - the next frame of a source, and what is tried when none comes.
//
//     nothing in time, or an error of the stream    start the stream again; close and open; reset the USB device
//     none of it helped, or the device is gone      ask the person, and wait for the device to come back
//
// After each step the source locks and proves its settings anew. A frame ends the climb: the next stall begins below.
#ifndef SHEEN_CAPTURE_LADDER_H
#define SHEEN_CAPTURE_LADDER_H

#include "capture/record.h"

typedef struct sheen_ladder {
    sheen_source *src;
    const sheen_record_options *options; // timeout_ms, patience_s, notice, progress
    int done, total;                     // for the progress
    int rung;                            // next to try
    bool had_frame;                      // no device is reset before it has ever worked
    int n_recovered;                     // stalls that were got over
} sheen_ladder;

// Waits for the next frame, a little at a time, so that the caller can stop. As sheen_source_next, but ETIMEOUT, ENODEV
// and EIO only after all that can be tried was tried.
sheen_status sheen_ladder_next(sheen_ladder *l, sheen_frame *frame, sheen_err *err);

#endif

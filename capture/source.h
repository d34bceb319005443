// SPDX-License-Identifier: Apache-2.0
// source.h - one way to get frames, whatever they come from.
//
//     sheen_source *src;
//     if (sheen_source_open(&src, "replay:penguin.session", &err)) ...
//     while ((s = sheen_source_next(src, timeout_ms, &frame, &err)) == SHEEN_OK)
//         use(&frame);                    // frame.data is lent until the next call
//     sheen_source_close(&src);           // NULL-safe, sets src to NULL
//
// A source belongs to the thread that opened it; only sheen_source_stop may be called from another
// thread or from a signal handler. How to add one: source_backend.h.
#ifndef SHEEN_CAPTURE_SOURCE_H
#define SHEEN_CAPTURE_SOURCE_H

#include <stddef.h>
#include <stdint.h>

#include "base/session.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_source sheen_source;

// One frame as delivered, with all that its sidecar will say.
typedef struct sheen_frame {
    sheen_frame_info info; // name: "" where the source gives none; file and payload_digest are not set
    const char *extension; // of the payload's file: "jpg", "png", "raw"
    const uint8_t *data;   // payload; lent by the source until the next call
    size_t size_bytes;
    const uint8_t *mask; // the object's mask as a PNG file, lent likewise; NULL: none
    size_t mask_bytes;
} sheen_frame;

// Opens a source by URI:
//     replay:SESSION[?role=input|calibration|test]    frames of a session, in the order of their names
// EARG (unknown kind or option), EUNSUP (a kind of source that this build is without), and what the
// source itself reports: ENODEV, EACCESS, EIO, EFORMAT, EDATA (no frames in it).
sheen_status sheen_source_open(sheen_source **src_out, const char *uri, sheen_err *err);

// Waits at most timeout_ms (>= 0) for the next frame. ETIMEOUT (call again), EEND (the recording is over),
// ENODEV (unplugged), ECANCEL (sheen_source_stop was called), EIO, EFORMAT, ENOMEM.
sheen_status sheen_source_next(sheen_source *src, int timeout_ms, sheen_frame *frame, sheen_err *err);

// How many frames it has in all, -1 where that is not known (a camera).
int64_t sheen_source_count(const sheen_source *src);

void sheen_source_stop(sheen_source *src);
void sheen_source_close(sheen_source **src);

// The URI's schemes that this build can open, in a fixed order; NULL ends the list.
const char *const *sheen_source_schemes(void);

#ifdef __cplusplus
}
#endif
#endif

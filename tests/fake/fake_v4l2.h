// SPDX-License-Identifier: Apache-2.0
// fake_v4l2.h - a camera that exists in memory only: the V4L2 seam over a strict state machine, with a plan of faults.
//
// Its clock is its own and moves when somebody waits, so that seconds of camera take no time. It is as strict as the
// kernel: a call that the state does not allow fails as it does there. Buffers are memory of their own while mapped, so
// that the sanitizer sees who touches them when they are not.
#ifndef SHEEN_TESTS_FAKE_FAKE_V4L2_H
#define SHEEN_TESTS_FAKE_FAKE_V4L2_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/session.h"
#include "capture/v4l2_io.h"

enum { FAKE_MAX_CONTROLS = 16, FAKE_MAX_BUFFERS = 8, FAKE_MAX_LAG = 16 };

typedef struct fake_control {
    uint32_t id, type;
    const char *name;
    int32_t min, max, step, fallback, value;
    uint32_t flags;
} fake_control;

// What goes wrong. Frames are counted from 0 over all that the sensor exposed since it was made; masks have a bit for
// each of the first 64 frames. All zero: nothing does.
typedef struct fake_faults {
    int fail_call, fail_errno;  // the n-th call of open, ioctl, mmap, wait fails (from 1); ENODEV stays
    unsigned long fail_request; // every such ioctl fails with fail_request_errno
    int fail_request_errno;
    uint64_t dropped, flagged, cut,
        swapped;                 // frames: lost, ERROR flag, too few bytes, given after their successor
    int64_t stall_at, unplug_at; // frame; 0: never
    uint32_t first_sequence;
    bool sequence_stands;         // always first_sequence
    int lag_frames;               // settings act on the picture so many frames later
    uint32_t forgetful;           // control that takes a value without a word and keeps its old one
    bool deaf;                    // says that it obeys, exposes as it likes
    int64_t auto_white_at;        // frame at which automatic white balance switches itself on
    double flicker;               // light changes by this share from frame to frame
    int64_t light_off_at;         // frame from which on the light is 30 % less
    bool stamps_end, stamps_none; // timestamps: of the end of frames; of another clock
    bool no_exposure;             // has no controls at all
    bool no_capture;              // a node for metadata
} fake_faults;

typedef struct fake_v4l2 {
    sheen_v4l2_io io; // hand this out
    fake_faults faults;
    // What it delivers: recorded payloads in turn, or (none) a flat RGB3 picture in linear light, lit as the settings say.
    uint8_t **payloads;
    size_t *payload_bytes, n_payloads;
    uint32_t fourcc;
    int width_px, height_px, stride_bytes;
    sheen_colorimetry color;
    int64_t interval_ns;
    fake_control controls[FAKE_MAX_CONTROLS];
    int n_controls;
    // State.
    int n_open, n_calls;
    bool gone, streaming;
    int64_t now_ns, next_frame_ns, n_frames;
    struct {
        void *memory; // while mapped
        bool queued, done;
        size_t bytes_used;
        uint32_t sequence;
        int64_t t_ns;
        bool flagged;
        int64_t order;
    } buffers[FAKE_MAX_BUFFERS];
    int n_buffers, n_mapped;
    int64_t n_done, n_unqueued; // n_unqueued: frames for which no buffer was queued
    int32_t exposures[FAKE_MAX_LAG + 1];
} fake_v4l2;

// 32 x 24 px, RGB3, 30 frames a second, the controls of a webcam.
void fake_v4l2_init(fake_v4l2 *f);
// Delivers the payloads of a recorded session instead; all its frames must have one format.
void fake_v4l2_play(fake_v4l2 *f, const sheen_session *s);
void fake_v4l2_release(fake_v4l2 *f);
fake_control *fake_v4l2_control(fake_v4l2 *f, uint32_t id);
size_t fake_v4l2_frame_bytes(const fake_v4l2 *f);
// Nothing is open or mapped, and nothing streams.
bool fake_v4l2_is_clean(const fake_v4l2 *f);

#endif

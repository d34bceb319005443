// SPDX-License-Identifier: Apache-2.0
// fake_v4l2.h - a camera that exists in memory only: the V4L2 seam over a strict state machine, with a plan of faults.
//
// It is as strict as the kernel: a call that the state does not allow fails as it does there. One camera, two faces:
//
//   - in process (fake_v4l2.c): our own seam. Its clock is its own and moves when somebody waits, so that seconds of
//     camera take no time. Buffers are memory of their own while mapped, so that the sanitizer sees who touches them
//     when they are not.
//   - as a preload library (fake_preload.c): /dev/videoN for any program, on the machine's clock, judged from outside by
//     v4l2-compliance.
#ifndef SHEEN_TESTS_FAKE_FAKE_V4L2_H
#define SHEEN_TESTS_FAKE_FAKE_V4L2_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/session.h"
#include "capture/v4l2_io.h"

enum {
    FAKE_MAX_CONTROLS = 48,
    FAKE_MAX_BUFFERS = 32,
    FAKE_MAX_LAG = 16,
    FAKE_MAX_FILES = 128,
    FAKE_MAX_EVENTS = 48
};
enum {
    FAKE_FD = 1000,
    FAKE_STEP_BYTES = 1 << 26
}; // the first descriptor; from one buffer's offset to the next

#define FAKE_IDENTITY "1d6b:0102 F1"

// What ends a stall: the mildest remedy that helps.
typedef enum fake_remedy { FAKE_NONE, FAKE_RESTART, FAKE_REOPEN, FAKE_USB_RESET } fake_remedy;

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
    uint64_t dropped, flagged, cut, corrupt,
        swapped; // frames: lost, ERROR flag, too few bytes, garbled inside, given after their successor
    int64_t stall_at, unplug_at; // frame; 0: never
    int64_t return_after_ns;     // an unplugged camera is back after so long; 0: never
    int return_node;             // then it is /dev/video<return_node>, and its settings are the factory's
    const char *return_as;       // identity of what is plugged in then; NULL: the same camera
    fake_remedy cure;            // of the stall, which then is over for good
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
    // The sensor of the flat picture; all zero: an even linear one.
    bool ramp;       // the light rises from left to right, from nothing to twice the flat picture's
    bool covered;    // the lens
    double gamma;    // codes are light to the power of 1 / gamma
    double vignette; // share of the light that is missing at the right edge
    int black;       // code without light; the pixel (5, 5) then has 100 more, whatever the light
} fake_faults;

// One opening of the node.
typedef struct fake_file {
    bool open, gone; // gone: of a camera that was unplugged since
    uint32_t priority;
    struct {
        uint32_t id, flags, changes; // changes: what there is to tell, 0: nothing
    } events[FAKE_MAX_EVENTS];
    int n_events;
    uint32_t n_told;
} fake_file;

typedef struct fake_v4l2 {
    sheen_v4l2_io io; // hand this out
    int node;         // /dev/video<node>, and behind the link that stays, FAKE_LINK
    fake_faults faults;
    // What it delivers: recorded payloads in turn, or (none) a flat RGB3 picture in linear light, lit as the settings say;
    // where fourcc is RGGB, a mosaic of it.
    uint8_t **payloads;
    size_t *payload_bytes, n_payloads;
    sheen_frame_info *recorded; // with each payload
    uint32_t fourcc;
    int width_px, height_px, stride_bytes;
    sheen_colorimetry color;
    int64_t interval_ns;
    fake_control controls[FAKE_MAX_CONTROLS];
    int n_controls;
    int64_t (*clock_ns)(void); // NULL: time passes by waiting only
    uint8_t *arena; // where all buffers lie, FAKE_STEP_BYTES apart; NULL: each by itself while mapped
    // State.
    fake_file files[FAKE_MAX_FILES];
    const char *identity;
    int n_resets;
    int n_open, n_calls, owner; // owner: the file whose buffers they are
    bool gone, streaming;
    int64_t now_ns, next_frame_ns, n_frames, unplugged_ns;
    int64_t first_frame; // n_frames as the stream began
    struct {
        void *memory;                              // while mapped
        bool mapped, prepared, queued, done, held; // held: done, but given out after its successor only
        size_t length_bytes, bytes_used;
        uint32_t sequence;
        int64_t t_ns;
        bool flagged;
        int64_t order, queued_order; // of being given out; of being queued
    } buffers[FAKE_MAX_BUFFERS];
    int n_buffers, n_mapped;
    int64_t n_given, n_unqueued; // n_unqueued: frames for which no buffer was queued
    int32_t exposures[FAKE_MAX_LAG + 1];
} fake_v4l2;

// 32 x 24 px, RGB3, 30 frames a second, the controls of a webcam.
void fake_v4l2_init(fake_v4l2 *f);

// What faces are made of: 0 (or a descriptor) or -1 and errno, as the calls of the kernel.
#define FAKE_LINK "/dev/v4l/by-id/usb-sheen_Fake_Camera_0001-video-index0"
bool fake_v4l2_is_node(const fake_v4l2 *f, const char *path);
int fake_v4l2_open(fake_v4l2 *f, const char *path);
int fake_v4l2_ioctl(fake_v4l2 *f, int fd, unsigned long request, void *arg);
void fake_v4l2_close(fake_v4l2 *f, int fd);
// POLL* that hold for this file now.
int fake_v4l2_poll(const fake_v4l2 *f, int fd);
// As if its cable were pulled.
void fake_v4l2_unplug(fake_v4l2 *f);
// The frames that are due until then come.
void fake_v4l2_run(fake_v4l2 *f, int64_t until_ns);
// Something was done about the camera: it may end a stall.
void fake_v4l2_treat(fake_v4l2 *f, fake_remedy by);
// The next call by its number: fails if the plan says so.
int fake_v4l2_enter(fake_v4l2 *f, unsigned long request);
// A plan of faults and the camera's own properties, "key=value;key=value" (fake_plan.c). NULL, or what is wrong with it.
const char *fake_v4l2_plan(fake_v4l2 *f, const char *text);

// Delivers the payloads of a recorded session instead, from its first at each start of the stream, with the settings
// that were recorded with them; all its frames must have one format.
sheen_status fake_v4l2_play(fake_v4l2 *f, const sheen_session *s, sheen_err *err);
void fake_v4l2_release(fake_v4l2 *f);
fake_control *fake_v4l2_control(fake_v4l2 *f, uint32_t id);
size_t fake_v4l2_frame_bytes(const fake_v4l2 *f);
// Nothing is open or mapped, and nothing streams.
bool fake_v4l2_is_clean(const fake_v4l2 *f);

#endif

// SPDX-License-Identifier: Apache-2.0
// fake_parts.h - what the fake camera's files share. Functions return 0 or errno where nothing else is said.
#ifndef SHEEN_TESTS_FAKE_FAKE_PARTS_H
#define SHEEN_TESTS_FAKE_FAKE_PARTS_H

#include <linux/videodev2.h>

#include "tests/fake/fake_v4l2.h"

// fake_v4l2.c: a camera without a face; the file behind a descriptor, or -1
void fake_v4l2_reset(fake_v4l2 *f);
void fake_v4l2_tick(fake_v4l2 *f); // time has passed: an unplugged camera may be back
int fake_file_of(const fake_v4l2 *f, int fd);

// fake_controls.c
void fake_add_controls(fake_v4l2 *f);
void fake_controls_update(fake_v4l2 *f); // automatics make their manual neighbours inactive
// Takes the value for what it is recorded to be; makes a control where there is none of that number.
void fake_record_control(fake_v4l2 *f, uint32_t id, int32_t value);
int fake_query_control(fake_v4l2 *f, struct v4l2_queryctrl *q);
int fake_query_ext_control(fake_v4l2 *f, struct v4l2_query_ext_ctrl *q);
int fake_query_menu(fake_v4l2 *f, struct v4l2_querymenu *m);
int fake_access_control(fake_v4l2 *f, struct v4l2_control *c, bool write, int i_file);
int fake_ext_controls(fake_v4l2 *f, unsigned long request, struct v4l2_ext_controls *c, int i_file);

// fake_events.c
int fake_subscribe(fake_v4l2 *f, fake_file *file, const struct v4l2_event_subscription *e, bool on);
int fake_take_event(fake_v4l2 *f, fake_file *file, struct v4l2_event *e);
// A control changed; all files hear of it but the one that did it (-1: the camera itself).
void fake_tell(fake_v4l2 *f, uint32_t id, uint32_t changes, int i_file);
bool fake_has_event(const fake_file *file);

// fake_format.c
int fake_format_call(fake_v4l2 *f, unsigned long request, void *arg);

// fake_queue.c
int fake_queue_call(fake_v4l2 *f, unsigned long request, void *arg, int i_file);
void fake_queue_free(fake_v4l2 *f);

// fake_sensor.c: one frame period is over: the frame goes into a queued buffer, if there is one.
void fake_expose(fake_v4l2 *f);
// The settings become those that were recorded with a payload.
void fake_play_settings(fake_v4l2 *f, size_t i_payload);

// A recording as it is handed to the preload library, through a file that is inherited: this, n_frames of
// fake_recorded_frame, then the payloads.
typedef struct fake_recording {
    char magic[8]; // FAKE_MAGIC
    uint64_t n_frames;
    uint32_t fourcc, width_px, height_px, stride_bytes;
    sheen_colorimetry color;
} fake_recording;

typedef struct fake_recorded_frame {
    uint64_t at_bytes, size_bytes; // of the payload, from the file's beginning
    sheen_frame_info info;
} fake_recorded_frame;

#define FAKE_MAGIC "sheenf1"
// What with_camera says to the library.
#define FAKE_ENV_PLAN "SHEEN_FAKE_PLAN"
#define FAKE_ENV_FILE "SHEEN_FAKE_FILE"

#endif

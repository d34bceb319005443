// SPDX-License-Identifier: Apache-2.0
// uvc_camera.h - a USB Video Class camera as a model without a bus: what it answers, and which bytes it sends.
//
// One configuration, bulk transfers at high speed, one format: YUY2 or MJPEG. usbip_camera.c and usbredir_camera.c put
// it on a bus.
#ifndef SHEEN_TESTS_VM_UVC_CAMERA_H
#define SHEEN_TESTS_VM_UVC_CAMERA_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/session.h"

enum { UVC_STREAM_ENDPOINT = 0x81, UVC_PACKET_BYTES = 512, UVC_TRANSFER_BYTES = 16384, UVC_STALL = -1 };

typedef struct uvc_control {
    uint8_t entity, selector, size_bytes;
    int32_t min, max, step, fallback, value;
} uvc_control;

enum { UVC_N_CONTROLS = 9 };

typedef struct uvc_camera {
    uint8_t **payloads; // recorded; none: a grey picture, as bright as the settings make it
    size_t *payload_bytes, n_payloads;
    bool jpeg, deaf; // deaf: takes settings and exposes as it likes
    int width_px, height_px;
    uint32_t interval_100ns;
    uvc_control controls[UVC_N_CONTROLS];
    uint8_t probe[26];
    bool streaming, fid;
    int64_t next_ns; // when the next frame begins
    size_t i_frame, at_bytes;
    uint8_t *lit; // the grey picture
    size_t (*choose)(void *self,
                     size_t n_payloads); // which payload a frame that begins shows; NULL: one after another
    void *choose_self;
} uvc_camera;

// From a session, or ("-") lit. False: it said why on stderr.
bool uvc_camera_init(uvc_camera *c, const char *session_path);
void uvc_camera_release(uvc_camera *c);
const uint8_t *uvc_device_descriptor(void); // 18 bytes
size_t uvc_config_descriptor(const uvc_camera *c, uint8_t out[512]);
// A control transfer; data holds what the host sent, or gets the answer (room for `length` bytes). The answer's size, or
// UVC_STALL.
int uvc_camera_setup(uvc_camera *c, const uint8_t setup[8], uint8_t *data, int64_t now_ns);
// The next bulk transfer of at most size bytes. 0: none before c->next_ns, or it does not stream.
size_t uvc_camera_transfer(uvc_camera *c, uint8_t *out, size_t size, int64_t now_ns);

#endif

// SPDX-License-Identifier: Apache-2.0
// uvc_camera.c - the model: descriptors, controls, and frames cut into payloads (USB Video Class 1.0).
#include "tests/vm/uvc_camera.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CAMERA = 1, PROCESSING = 2, VIDEO_STREAMING = 1 }; // entities; the interface of the stream
enum { SET_CUR = 0x01, GET_CUR = 0x81, GET_MIN, GET_MAX, GET_RES, GET_LEN, GET_INFO, GET_DEF };
enum { AE_MODE, AE_PRIORITY, EXPOSURE, BRIGHTNESS, GAIN, MAINS, SHARPNESS, WHITE, WHITE_AUTO };

static const uvc_control webcam[UVC_N_CONTROLS] = {
    {CAMERA, 0x02, 1, 1, 8, 9, 8, 8}, // a set of bits: manual, aperture priority; its step lists them
    {CAMERA, 0x03, 1, 0, 1, 1, 0, 1},
    {CAMERA, 0x04, 4, 1, 5000, 1, 157, 290},
    {PROCESSING, 0x02, 2, -64, 64, 1, 0, 0},
    {PROCESSING, 0x04, 2, 0, 100, 1, 0, 10},
    {PROCESSING, 0x05, 1, 0, 2, 1, 1, 1},
    {PROCESSING, 0x08, 2, 0, 7, 1, 3, 3},
    {PROCESSING, 0x0a, 2, 2800, 6500, 10, 4600, 4600},
    {PROCESSING, 0x0b, 1, 0, 1, 1, 1, 1},
};

static bool load(uvc_camera *c, const char *path)
{
    sheen_session s;
    sheen_err err;
    if (sheen_session_open(&s, path, &err)) {
        fprintf(stderr, "uvc camera: %s\n", err.msg);
        return false;
    }
    c->payloads = calloc(s.n_frames, sizeof *c->payloads);
    c->payload_bytes = calloc(s.n_frames, sizeof *c->payload_bytes);
    for (size_t i = 0; c->payloads && c->payload_bytes && i < s.n_frames; i++) {
        const sheen_frame_info *f = &s.frames[i];
        if (sheen_session_payload(&c->payloads[i], &c->payload_bytes[i], &s, f, &err)) {
            fprintf(stderr, "uvc camera: %s\n", err.msg);
            break;
        }
        c->n_payloads = i + 1;
        c->jpeg = !f->fourcc;
        c->width_px = f->width_px;
        c->height_px = f->height_px;
    }
    const bool all = c->n_payloads && c->n_payloads == s.n_frames;
    sheen_session_release(&s);
    return all;
}

static void put16(uint8_t *out, uint32_t x)
{
    out[0] = (uint8_t)x;
    out[1] = (uint8_t)(x >> 8);
}

static void put32(uint8_t *out, uint32_t x)
{
    put16(out, x);
    put16(out + 2, x >> 16);
}

static uint32_t most_bytes(const uvc_camera *c)
{
    size_t most = (size_t)c->width_px * (size_t)c->height_px * 2;
    for (size_t i = 0; i < c->n_payloads; i++)
        most = c->payload_bytes[i] > most ? c->payload_bytes[i] : most;
    return (uint32_t)most;
}

bool uvc_camera_init(uvc_camera *c, const char *session_path)
{
    *c = (uvc_camera){.width_px = 320, .height_px = 240, .interval_100ns = 333333};
    memcpy(c->controls, webcam, sizeof webcam);
    if (strcmp(session_path, "-") != 0 && !load(c, session_path))
        return false;
    c->lit = c->n_payloads ? NULL : malloc(most_bytes(c));
    c->probe[2] = c->probe[3] = 1; // format, frame
    put32(c->probe + 4, c->interval_100ns);
    put32(c->probe + 18, most_bytes(c));
    put32(c->probe + 22, UVC_TRANSFER_BYTES);
    return c->lit || c->n_payloads;
}

void uvc_camera_release(uvc_camera *c)
{
    for (size_t i = 0; i < c->n_payloads; i++)
        free(c->payloads[i]);
    free(c->payloads);
    free(c->payload_bytes);
    free(c->lit);
}

const uint8_t *uvc_device_descriptor(void)
{
    static const uint8_t d[18] = {18,   1,    0x00, 0x02, 0xef, 2, 1, 64, 0x6b,
                                  0x1d, 0x02, 0x01, 0x00, 0x01, 1, 2, 3,  1};
    return d;
}

static void append(uint8_t *out, size_t *n, const uint8_t *bytes, size_t count)
{
    memcpy(out + *n, bytes, count);
    *n += count;
}
#define APPEND(...) append(out, &n, (const uint8_t[]){__VA_ARGS__}, sizeof((const uint8_t[]){__VA_ARGS__}))

// Format, frame and colour of the stream; *total is patched into the header before them.
static size_t stream_descriptors(const uvc_camera *c, uint8_t *out)
{
    const uint8_t w = (uint8_t)c->width_px, w1 = (uint8_t)(c->width_px >> 8);
    const uint8_t h = (uint8_t)c->height_px, h1 = (uint8_t)(c->height_px >> 8);
    size_t n = 0;
    APPEND(14, 0x24, 0x01, 1, 0, 0, UVC_STREAM_ENDPOINT, 0, 3, 0, 0, 0, 1, 0);
    if (c->jpeg)
        APPEND(11, 0x24, 0x06, 1, 1, 1, 1, 0, 0, 0, 0);
    else // the GUID of YUY2
        APPEND(27, 0x24, 0x04, 1, 1, 'Y', 'U', 'Y', '2', 0, 0, 0x10, 0, 0x80, 0, 0, 0xaa, 0, 0x38, 0x9b, 0x71,
               16, 1, 0, 0, 0, 0);
    APPEND(30, 0x24, (uint8_t)(c->jpeg ? 0x07 : 0x05), 1, 0, w, w1, h, h1, 0, 0, 0x70, 0x08, 0, 0, 0x70, 0x08,
           0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0);
    put32(out + n - 13, most_bytes(c));
    put32(out + n - 9, c->interval_100ns);
    put32(out + n - 4, c->interval_100ns);
    APPEND(6, 0x24, 0x0d, 1, 1, 4); // sRGB, its curve, BT.601
    put16(out + 4, (uint32_t)n);
    return n;
}

size_t uvc_config_descriptor(const uvc_camera *c, uint8_t out[512])
{
    size_t n = 0;
    APPEND(9, 2, 0, 0, 2, 1, 0, 0x80, 250);
    APPEND(8, 11, 0, 2, 0x0e, 3, 0, 2);   // both interfaces are one function
    APPEND(9, 4, 0, 0, 0, 0x0e, 1, 0, 2); // control
    const size_t header = n;
    APPEND(13, 0x24, 0x01, 0x00, 0x01, 0, 0, 0x00, 0x6c, 0xdc, 0x02, 1, VIDEO_STREAMING);
    APPEND(18, 0x24, 0x02, CAMERA, 0x01, 0x02, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0x0e, 0, 0);
    APPEND(11, 0x24, 0x05, PROCESSING, CAMERA, 0, 0, 2, 0x51, 0x16, 0);
    APPEND(9, 0x24, 0x03, 3, 0x01, 0x01, 0, PROCESSING, 0);
    put16(out + header + 5, (uint32_t)(n - header));
    APPEND(9, 4, VIDEO_STREAMING, 0, 1, 0x0e, 2, 0, 0);
    n += stream_descriptors(c, out + n);
    APPEND(7, 5, UVC_STREAM_ENDPOINT, 2, UVC_PACKET_BYTES & 0xff, UVC_PACKET_BYTES >> 8, 0);
    put16(out + 2, (uint32_t)n);
    return n;
}

static int text_descriptor(uint8_t index, uint8_t *data)
{
    static const char *const texts[] = {NULL, "sheen", "Simulated UVC Camera", "UVC-0001"};
    if (!index) {
        memcpy(data, (const uint8_t[]){4, 3, 0x09, 0x04}, 4);
        return 4;
    }
    if (index > 3)
        return UVC_STALL;
    const size_t n = strlen(texts[index]);
    data[0] = (uint8_t)(2 + 2 * n);
    data[1] = 3;
    for (size_t i = 0; i < n; i++)
        put16(data + 2 + 2 * i, (uint8_t)texts[index][i]);
    return data[0];
}

static int standard_request(uvc_camera *c, const uint8_t setup[8], uint8_t *data)
{
    uint8_t config[512];
    size_t n;
    switch (setup[1]) {
    case 0: // GET_STATUS
        memset(data, 0, 2);
        return 2;
    case 1: // CLEAR_FEATURE: the end of a stream, on its endpoint
        c->streaming = false;
        return 0;
    case 6:
        if (setup[3] == 1) {
            memcpy(data, uvc_device_descriptor(), 18);
            return 18;
        }
        if (setup[3] == 3)
            return text_descriptor(setup[2], data);
        if (setup[3] != 2)
            return UVC_STALL;
        n = uvc_config_descriptor(c, config);
        memcpy(data, config, n);
        return (int)n;
    case 8: // GET_CONFIGURATION
        data[0] = 1;
        return 1;
    case 10: // GET_INTERFACE
        data[0] = 0;
        return 1;
    default: // address, configuration, interface: there is one of each
        return 0;
    }
}

static int32_t read_value(const uint8_t *data, size_t size)
{
    uint32_t x = 0;
    for (size_t i = 0; i < size; i++)
        x |= (uint32_t)data[i] << (8 * i);
    return size == 2 ? (int16_t)x : (int32_t)x;
}

// Exposure and white balance are not to be set while their automatics are at work.
static bool is_disabled(const uvc_camera *c, const uvc_control *k)
{
    return (k == &c->controls[EXPOSURE] && c->controls[AE_MODE].value != 1) ||
           (k == &c->controls[WHITE] && c->controls[WHITE_AUTO].value);
}

static int set_control(uvc_camera *c, uvc_control *k, const uint8_t *data)
{
    const int32_t x = read_value(data, k->size_bytes);
    if (is_disabled(c, k) || x < k->min || x > k->max)
        return UVC_STALL;
    k->value = x;
    fprintf(stderr, "set %u.%u to %ld\n", k->entity, k->selector, (long)x);
    return 0;
}

static int control_request(uvc_camera *c, const uint8_t setup[8], uint8_t *data)
{
    uvc_control *k = NULL;
    for (int i = 0; i < UVC_N_CONTROLS; i++)
        if (c->controls[i].entity == setup[5] && c->controls[i].selector == setup[3])
            k = &c->controls[i];
    if (!k)
        return UVC_STALL;
    const int32_t values[] = {k->value, k->min, k->max, k->step, k->size_bytes, 0, k->fallback};
    switch (setup[1]) {
    case SET_CUR:
        return set_control(c, k, data);
    case GET_INFO:
        data[0] = (uint8_t)(3 | (is_disabled(c, k) ? 4 : 0));
        return 1;
    case GET_LEN:
        put16(data, k->size_bytes);
        return 2;
    case GET_CUR:
    case GET_MIN:
    case GET_MAX:
    case GET_RES:
    case GET_DEF:
        put32(data, (uint32_t)values[setup[1] - GET_CUR]);
        return k->size_bytes;
    default:
        return UVC_STALL;
    }
}

static int stream_request(uvc_camera *c, const uint8_t setup[8], uint8_t *data, int64_t now_ns)
{
    if (setup[1] == SET_CUR) {
        if (setup[3] == 2) { // COMMIT: the stream begins, with the first frame
            c->streaming = true;
            c->i_frame = c->at_bytes = 0;
            c->next_ns = now_ns;
        }
        return 0;
    }
    if (setup[1] == GET_INFO) {
        data[0] = 3;
        return 1;
    }
    if (setup[1] == GET_LEN) {
        put16(data, sizeof c->probe);
        return 2;
    }
    memcpy(data, c->probe, sizeof c->probe);
    return sizeof c->probe;
}

int uvc_camera_setup(uvc_camera *c, const uint8_t setup[8], uint8_t *data, int64_t now_ns)
{
    uint8_t answer[512];
    const int length = setup[6] | setup[7] << 8;
    const bool in = setup[0] & 0x80;
    int n;
    if ((setup[0] & 0x60) == 0)
        n = standard_request(c, setup, answer);
    else if (setup[4] == VIDEO_STREAMING)
        n = stream_request(c, setup, in ? answer : data, now_ns);
    else
        n = control_request(c, setup, in ? answer : data);
    n = n > length ? length : n;
    if (in && n > 0)
        memcpy(data, answer, (size_t)n);
    return n;
}

// Full scale at an exposure of 60 ms and the usual gain, on a camera's curve.
static void draw_lit(uvc_camera *c)
{
    const double exposure = c->deaf || c->controls[AE_MODE].value != 1 ? 290 : c->controls[EXPOSURE].value;
    const double light = fmin(exposure / 600 * (10 + c->controls[GAIN].value) / 20, 1);
    const uint8_t code = (uint8_t)(16 + 219 * pow(light, 1 / 2.2) + 0.5);
    for (size_t i = 0; i < most_bytes(c); i += 2) {
        c->lit[i] = code;
        c->lit[i + 1] = 128;
    }
}

size_t uvc_camera_transfer(uvc_camera *c, uint8_t *out, size_t size, int64_t now_ns)
{
    if (!c->streaming || (!c->at_bytes && now_ns < c->next_ns) || size < 3)
        return 0;
    if (!c->at_bytes) { // a frame begins
        c->fid = !c->fid;
        c->next_ns += 100 * (int64_t)c->interval_100ns;
        if (c->next_ns < now_ns) // the host was slow: no hurry after it
            c->next_ns = now_ns;
        if (c->lit)
            draw_lit(c);
        else if (c->choose)
            c->i_frame = c->choose(c->choose_self, c->n_payloads);
    }
    const size_t i = c->n_payloads ? c->i_frame % c->n_payloads : 0;
    const uint8_t *data = c->lit ? c->lit : c->payloads[i];
    const size_t total = c->lit ? most_bytes(c) : c->payload_bytes[i];
    const size_t n = total - c->at_bytes < size - 2 ? total - c->at_bytes : size - 2;
    const bool last = c->at_bytes + n == total;
    out[0] = 2;
    out[1] = (uint8_t)(0x80 | (last ? 2 : 0) | c->fid);
    memcpy(out + 2, data + c->at_bytes, n);
    c->at_bytes = last ? 0 : c->at_bytes + n;
    c->i_frame += last;
    return 2 + n;
}

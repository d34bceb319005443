// SPDX-License-Identifier: Apache-2.0
// fake_sensor.c - frames as the fake camera's settings, its light and its faults make them.
#include "tests/fake/fake_parts.h"

#include <math.h>
#include <string.h>

enum { AUTO_EXPOSURE = 290 }; // what its automatic finds, in 100 us

static int32_t exposure_now(fake_v4l2 *f)
{
    const fake_control *e = fake_v4l2_control(f, V4L2_CID_EXPOSURE_ABSOLUTE);
    if (!e || f->faults.deaf || fake_v4l2_control(f, V4L2_CID_EXPOSURE_AUTO)->value != V4L2_EXPOSURE_MANUAL)
        return AUTO_EXPOSURE;
    return e->value;
}

// Half of full scale at 300.
static double light_of(fake_v4l2 *f, int channel)
{
    const int lag = f->faults.lag_frames;
    const int64_t i = f->n_frames;
    f->exposures[i % (FAKE_MAX_LAG + 1)] = exposure_now(f);
    const int64_t then = i < lag ? 0 : i - lag;
    double light = f->exposures[then % (FAKE_MAX_LAG + 1)] / 600.0;
    light *= i % 2 ? 1 + f->faults.flicker : 1;
    if (f->faults.light_off_at && i >= f->faults.light_off_at)
        light *= 0.7;
    if (channel == 0 && f->faults.auto_white_at && i >= f->faults.auto_white_at)
        light *= 1.1;
    return f->faults.covered ? 0 : light;
}

static uint8_t code_of(const fake_faults *o, double light)
{
    const double lit = o->gamma > 0 ? pow(light, 1 / o->gamma) : light;
    return (uint8_t)(lit > 1 ? 255 : o->black + lit * (255 - o->black) + 0.5);
}

// Where the picture holds that channel of a pixel; NULL where it does not: a mosaic has one a pixel, red at the corner.
static uint8_t *code_at(const fake_v4l2 *f, uint8_t *out, int x, int y, int channel)
{
    const size_t i = (size_t)(y * f->width_px + x);
    if (f->fourcc != V4L2_PIX_FMT_SRGGB8)
        return out + 3 * i + channel;
    return x % 2 + y % 2 == channel ? out + i : NULL;
}

static void draw(const fake_v4l2 *f, uint8_t *out, int channel, double light)
{
    const fake_faults *o = &f->faults;
    for (int x = 0; x < f->width_px; x++) {
        const double share = (double)x / (f->width_px - 1);
        const uint8_t code = code_of(o, light * (o->ramp ? 2 * share : 1) * (1 - o->vignette * share));
        for (int y = 0; y < f->height_px; y++) {
            uint8_t *at = code_at(f, out, x, y, channel);
            if (at)
                *at = code;
        }
    }
    uint8_t *hot = code_at(f, out, 5, 5, channel);
    if (o->black && hot)
        *hot = (uint8_t)(*hot > 155 ? 255 : *hot + 100);
}

void fake_play_settings(fake_v4l2 *f, size_t i_payload)
{
    const sheen_frame_info *g = &f->recorded[i_payload];
    for (int k = 0; k < g->n_controls; k++)
        fake_record_control(f, g->controls[k].id, g->controls[k].value);
}

// One pixel in sixteen is another one.
static void garble(uint8_t *data, size_t size_bytes)
{
    for (size_t i = size_bytes / 4; i + 16 < size_bytes; i += 16)
        data[i] ^= 0x5a;
}

static size_t fill(fake_v4l2 *f, uint8_t *out)
{
    if (f->n_payloads) {
        const size_t i = (size_t)(f->n_frames - f->first_frame) % f->n_payloads;
        memcpy(out, f->payloads[i], f->payload_bytes[i]);
        return f->payload_bytes[i];
    }
    for (int c = 0; c < 3; c++)
        draw(f, out, c, light_of(f, c));
    memcpy(out, &f->n_frames, sizeof f->n_frames); // the first pixels: which frame this is
    return fake_v4l2_frame_bytes(f);
}

static bool planned(uint64_t mask, int64_t frame)
{
    return frame < 64 && mask >> frame & 1;
}

static int a_queued_buffer(const fake_v4l2 *f)
{
    int first = -1;
    for (int i = 0; i < f->n_buffers; i++)
        if (f->buffers[i].queued && f->buffers[i].memory &&
            (first < 0 || f->buffers[i].queued_order < f->buffers[first].queued_order))
            first = i;
    return first;
}

// What the automatic white balance does by itself.
static void run_automatics(fake_v4l2 *f)
{
    if (!f->faults.auto_white_at || f->n_frames < f->faults.auto_white_at)
        return;
    fake_v4l2_control(f, V4L2_CID_AUTO_WHITE_BALANCE)->value = 1;
    fake_controls_update(f);
}

static void finish(fake_v4l2 *f, int i)
{
    const int64_t n = f->n_frames;
    f->buffers[i].bytes_used = fill(f, f->buffers[i].memory);
    if (planned(f->faults.cut, n))
        f->buffers[i].bytes_used /= 2;
    if (planned(f->faults.corrupt, n))
        garble(f->buffers[i].memory, f->buffers[i].bytes_used);
    f->buffers[i].flagged = planned(f->faults.flagged, n);
    f->buffers[i].queued = false;
    f->buffers[i].done = true;
    f->buffers[i].sequence = f->faults.first_sequence +
                             (f->faults.sequence_stands ? 0 : (uint32_t)(n - f->first_frame));
    f->buffers[i].t_ns = f->now_ns - (f->faults.stamps_end ? 0 : f->interval_ns);
    // One that is swapped comes with its successor, but behind it.
    for (int k = 0; k < f->n_buffers; k++)
        f->buffers[k].held = false;
    f->buffers[i].held = planned(f->faults.swapped, n);
    f->buffers[i].order = 2 * n + (f->buffers[i].held ? 3 : 0);
}

void fake_expose(fake_v4l2 *f)
{
    const int64_t n = f->n_frames;
    const int i = a_queued_buffer(f);
    if (f->faults.unplug_at && n >= f->faults.unplug_at) {
        fake_v4l2_unplug(f);
        return;
    }
    if (f->faults.stall_at && n >= f->faults.stall_at)
        return;
    run_automatics(f);
    if (i < 0 || planned(f->faults.dropped, n))
        f->n_unqueued += i < 0;
    else
        finish(f, i);
    f->n_frames++;
}

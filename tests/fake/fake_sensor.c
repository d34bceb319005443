// SPDX-License-Identifier: Apache-2.0
// fake_sensor.c - the fake camera's controls, and frames as its settings, its light and its faults make them.
#include "tests/fake/fake_sensor.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include <linux/videodev2.h>

#include "tests/support.h"

enum { AUTO_EXPOSURE = 290 }; // what its automatic finds, in 100 us

void fake_add_controls(fake_v4l2 *f)
{
    static const fake_control webcam[] = {
        {V4L2_CID_USER_CLASS, V4L2_CTRL_TYPE_CTRL_CLASS, "User Controls", 0, 0, 0, 0, 0,
         V4L2_CTRL_FLAG_READ_ONLY},
        {V4L2_CID_BRIGHTNESS, V4L2_CTRL_TYPE_INTEGER, "Brightness", -64, 64, 1, 0, 3, 0},
        {V4L2_CID_AUTO_WHITE_BALANCE, V4L2_CTRL_TYPE_BOOLEAN, "White Balance, Automatic", 0, 1, 1, 1, 1, 0},
        {V4L2_CID_GAIN, V4L2_CTRL_TYPE_INTEGER, "Gain", 0, 100, 1, 0, 10, 0},
        {V4L2_CID_POWER_LINE_FREQUENCY, V4L2_CTRL_TYPE_MENU, "Power Line Frequency", 0, 2, 1, 1, 1, 0},
        {V4L2_CID_WHITE_BALANCE_TEMPERATURE, V4L2_CTRL_TYPE_INTEGER, "White Balance Temperature", 2800, 6500,
         10, 4600, 4600, V4L2_CTRL_FLAG_INACTIVE},
        {V4L2_CID_SHARPNESS, V4L2_CTRL_TYPE_INTEGER, "Sharpness", 1, 7, 1, 3, 3, 0},
        {V4L2_CID_EXPOSURE_AUTO, V4L2_CTRL_TYPE_MENU, "Auto Exposure", 0, 3, 1, 3, 3, 0},
        {V4L2_CID_EXPOSURE_ABSOLUTE, V4L2_CTRL_TYPE_INTEGER, "Exposure Time, Absolute", 1, 5000, 1, 157, 157,
         V4L2_CTRL_FLAG_INACTIVE},
        {V4L2_CID_EXPOSURE_AUTO_PRIORITY, V4L2_CTRL_TYPE_BOOLEAN, "Exposure, Dynamic Framerate", 0, 1, 1, 0,
         1, 0},
    };
    f->n_controls = sizeof webcam / sizeof *webcam;
    memcpy(f->controls, webcam, sizeof webcam);
    // As the kernel lists them: by number.
    for (int i = 0; i < f->n_controls; i++)
        for (int k = i + 1; k < f->n_controls; k++)
            if (f->controls[k].id < f->controls[i].id) {
                const fake_control c = f->controls[i];
                f->controls[i] = f->controls[k];
                f->controls[k] = c;
            }
}

fake_control *fake_v4l2_control(fake_v4l2 *f, uint32_t id)
{
    for (int i = 0; !f->faults.no_exposure && i < f->n_controls; i++)
        if (f->controls[i].id == id)
            return &f->controls[i];
    return NULL;
}

int fake_query_control(fake_v4l2 *f, struct v4l2_queryctrl *q)
{
    const uint32_t id = q->id & V4L2_CTRL_ID_MASK;
    const bool next = q->id & V4L2_CTRL_FLAG_NEXT_CTRL;
    for (int i = 0; !f->faults.no_exposure && i < f->n_controls; i++) {
        const fake_control *c = &f->controls[i];
        if (next ? c->id <= id || c->type == V4L2_CTRL_TYPE_CTRL_CLASS : c->id != id)
            continue;
        memset(q, 0, sizeof *q);
        q->id = c->id;
        q->type = c->type;
        snprintf((char *)q->name, sizeof q->name, "%s", c->name);
        q->minimum = c->min;
        q->maximum = c->max;
        q->step = c->step;
        q->default_value = c->fallback;
        q->flags = c->flags;
        return 0;
    }
    return EINVAL;
}

// Automatics make their manual neighbours inactive.
static void update_flags(fake_v4l2 *f)
{
    const bool exposes = fake_v4l2_control(f, V4L2_CID_EXPOSURE_AUTO)->value != V4L2_EXPOSURE_MANUAL;
    const bool balances = fake_v4l2_control(f, V4L2_CID_AUTO_WHITE_BALANCE)->value;
    fake_v4l2_control(f, V4L2_CID_EXPOSURE_ABSOLUTE)->flags = exposes ? V4L2_CTRL_FLAG_INACTIVE : 0;
    fake_v4l2_control(f, V4L2_CID_WHITE_BALANCE_TEMPERATURE)->flags = balances ? V4L2_CTRL_FLAG_INACTIVE : 0;
}

int fake_access_control(fake_v4l2 *f, struct v4l2_control *v, bool write)
{
    fake_control *c = fake_v4l2_control(f, v->id);
    if (!c)
        return EINVAL;
    if (!write) {
        v->value = c->value;
        return c->type == V4L2_CTRL_TYPE_CTRL_CLASS ? EACCES : 0;
    }
    if (c->flags & V4L2_CTRL_FLAG_READ_ONLY)
        return EACCES;
    const bool is_number = c->type == V4L2_CTRL_TYPE_INTEGER;
    if (!is_number && (v->value < c->min || v->value > c->max))
        return ERANGE;
    if (is_number) {
        const int32_t x = v->value < c->min ? c->min : v->value > c->max ? c->max : v->value;
        v->value = c->min + (x - c->min + c->step / 2) / c->step * c->step;
    }
    if (v->id != f->faults.forgetful)
        c->value = v->value;
    if (v->id == V4L2_CID_EXPOSURE_AUTO && v->value == V4L2_EXPOSURE_MANUAL)
        fake_v4l2_control(f, V4L2_CID_EXPOSURE_ABSOLUTE)->value = AUTO_EXPOSURE; // it stays at what was found
    update_flags(f);
    return 0;
}

static int32_t exposure_now(fake_v4l2 *f)
{
    const fake_control *e = fake_v4l2_control(f, V4L2_CID_EXPOSURE_ABSOLUTE);
    if (!e || f->faults.deaf || fake_v4l2_control(f, V4L2_CID_EXPOSURE_AUTO)->value != V4L2_EXPOSURE_MANUAL)
        return AUTO_EXPOSURE;
    return e->value;
}

// Half of full scale at 300, on a light of 1.
static uint8_t code_of(fake_v4l2 *f, int channel)
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
    return (uint8_t)(light > 1 ? 255 : light * 255 + 0.5);
}

static size_t fill(fake_v4l2 *f, uint8_t *out)
{
    if (f->n_payloads) {
        const size_t i = (size_t)f->n_frames % f->n_payloads;
        memcpy(out, f->payloads[i], f->payload_bytes[i]);
        return f->payload_bytes[i];
    }
    for (int c = 0; c < 3; c++) {
        const uint8_t code = code_of(f, c);
        for (int i = 0; i < f->width_px * f->height_px; i++)
            out[3 * i + c] = code;
    }
    memcpy(out, &f->n_frames, sizeof f->n_frames); // two pixels and a bit: which frame this is
    return fake_v4l2_frame_bytes(f);
}

static bool planned(uint64_t mask, int64_t frame)
{
    return frame < 64 && mask >> frame & 1;
}

static int a_queued_buffer(const fake_v4l2 *f)
{
    for (int i = 0; i < f->n_buffers; i++)
        if (f->buffers[i].queued)
            return i;
    return -1;
}

void fake_expose(fake_v4l2 *f)
{
    const int64_t n = f->n_frames;
    const int i = a_queued_buffer(f);
    if (f->faults.unplug_at && n >= f->faults.unplug_at) {
        f->gone = true;
        return;
    }
    if (f->faults.stall_at && n >= f->faults.stall_at)
        return;
    if (f->faults.auto_white_at && n >= f->faults.auto_white_at) {
        fake_v4l2_control(f, V4L2_CID_AUTO_WHITE_BALANCE)->value = 1;
        update_flags(f);
    }
    if (i < 0 || planned(f->faults.dropped, n)) {
        f->n_unqueued += i < 0;
        f->n_frames++;
        return;
    }
    f->buffers[i].bytes_used = fill(f, f->buffers[i].memory);
    if (planned(f->faults.cut, n))
        f->buffers[i].bytes_used /= 2;
    f->buffers[i].flagged = planned(f->faults.flagged, n);
    f->buffers[i].queued = false;
    f->buffers[i].done = true;
    f->buffers[i].sequence = f->faults.first_sequence + (f->faults.sequence_stands ? 0 : (uint32_t)n);
    f->buffers[i].t_ns = f->now_ns - (f->faults.stamps_end ? 0 : f->interval_ns);
    // One that is swapped comes after the next, that is: with it, but behind it.
    f->buffers[i].order = 2 * n + (planned(f->faults.swapped, n) ? 3 : 0);
    if (planned(f->faults.swapped, n)) {
        f->n_frames++;
        f->now_ns += f->interval_ns;
        f->next_frame_ns += f->interval_ns;
        fake_expose(f);
        return;
    }
    f->n_frames++;
}

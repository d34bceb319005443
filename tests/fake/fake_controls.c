// SPDX-License-Identifier: Apache-2.0
// fake_controls.c - the fake camera's controls, as the kernel's framework lets them be asked for, set and read.
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "tests/fake/fake_parts.h"

enum { AUTO_EXPOSURE = 290 }; // what its automatic finds, in 100 us
enum { CLASS_FLAGS = V4L2_CTRL_FLAG_READ_ONLY | V4L2_CTRL_FLAG_WRITE_ONLY };

static const char *const exposure_menu[] = {NULL, "Manual Mode", NULL, "Aperture Priority Mode"};
static const char *const mains_menu[] = {"Disabled", "50 Hz", "60 Hz"};

static void sort_controls(fake_v4l2 *f)
{
    for (int i = 0; i < f->n_controls; i++)
        for (int k = i + 1; k < f->n_controls; k++)
            if (f->controls[k].id < f->controls[i].id) {
                const fake_control c = f->controls[i];
                f->controls[i] = f->controls[k];
                f->controls[k] = c;
            }
}

void fake_add_controls(fake_v4l2 *f)
{
    static const fake_control webcam[] = {
        {V4L2_CID_USER_CLASS, V4L2_CTRL_TYPE_CTRL_CLASS, "User Controls", 0, 0, 0, 0, 0, CLASS_FLAGS},
        {V4L2_CID_CAMERA_CLASS, V4L2_CTRL_TYPE_CTRL_CLASS, "Camera Controls", 0, 0, 0, 0, 0, CLASS_FLAGS},
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
    sort_controls(f); // as the kernel lists them: by number
}

fake_control *fake_v4l2_control(fake_v4l2 *f, uint32_t id)
{
    for (int i = 0; !f->faults.no_exposure && i < f->n_controls; i++)
        if (f->controls[i].id == id)
            return &f->controls[i];
    return NULL;
}

void fake_record_control(fake_v4l2 *f, uint32_t id, int32_t value)
{
    fake_control *c = fake_v4l2_control(f, id);
    if (!c) {
        const bool known_class = V4L2_CTRL_ID2WHICH(id) == V4L2_CTRL_CLASS_USER ||
                                 V4L2_CTRL_ID2WHICH(id) == V4L2_CTRL_CLASS_CAMERA;
        if (!known_class || f->n_controls == FAKE_MAX_CONTROLS)
            return;
        f->controls[f->n_controls++] = (fake_control){id,
                                                      V4L2_CTRL_TYPE_INTEGER,
                                                      "Recorded",
                                                      value < 0 ? value : 0,
                                                      value > 100 ? value : 100,
                                                      1,
                                                      value,
                                                      value,
                                                      0};
        sort_controls(f);
        return;
    }
    c->min = value < c->min ? value : c->min;
    c->max = value > c->max ? value : c->max;
    c->value = value;
    fake_controls_update(f);
}

static const char *menu_name(const fake_control *c, int32_t i)
{
    if (c->type != V4L2_CTRL_TYPE_MENU || i < c->min || i > c->max)
        return NULL;
    return c->id == V4L2_CID_EXPOSURE_AUTO ? exposure_menu[i] : mains_menu[i];
}

int fake_query_menu(fake_v4l2 *f, struct v4l2_querymenu *m)
{
    const fake_control *c = fake_v4l2_control(f, m->id);
    const char *name = c ? menu_name(c, (int32_t)m->index) : NULL;
    if (!name)
        return EINVAL;
    snprintf((char *)m->name, sizeof m->name, "%s", name);
    m->reserved = 0;
    return 0;
}

// The control itself, or, with NEXT_CTRL, the first with a higher number.
static const fake_control *look_up(fake_v4l2 *f, uint32_t id)
{
    const uint32_t plain = id & V4L2_CTRL_ID_MASK;
    if (!(id & (V4L2_CTRL_FLAG_NEXT_CTRL | V4L2_CTRL_FLAG_NEXT_COMPOUND)))
        return fake_v4l2_control(f, id);
    for (int i = 0; !f->faults.no_exposure && id & V4L2_CTRL_FLAG_NEXT_CTRL && i < f->n_controls; i++)
        if (f->controls[i].id > plain)
            return &f->controls[i];
    return NULL;
}

int fake_query_control(fake_v4l2 *f, struct v4l2_queryctrl *q)
{
    const fake_control *c = look_up(f, q->id);
    if (!c)
        return EINVAL;
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

int fake_query_ext_control(fake_v4l2 *f, struct v4l2_query_ext_ctrl *q)
{
    const fake_control *c = look_up(f, q->id);
    if (!c)
        return EINVAL;
    memset(q, 0, sizeof *q);
    q->id = c->id;
    q->type = c->type;
    snprintf(q->name, sizeof q->name, "%s", c->name);
    q->minimum = c->min;
    q->maximum = c->max;
    q->step = (__u64)c->step;
    q->default_value = c->fallback;
    q->flags = c->flags;
    q->elem_size = 4;
    q->elems = 1;
    return 0;
}

void fake_controls_update(fake_v4l2 *f)
{
    static const uint32_t pairs[][2] = {{V4L2_CID_EXPOSURE_AUTO, V4L2_CID_EXPOSURE_ABSOLUTE},
                                        {V4L2_CID_AUTO_WHITE_BALANCE, V4L2_CID_WHITE_BALANCE_TEMPERATURE}};
    for (int i = 0; i < 2; i++) {
        const int32_t off = i ? 0 : V4L2_EXPOSURE_MANUAL;
        fake_control *c = fake_v4l2_control(f, pairs[i][1]);
        const uint32_t flags = fake_v4l2_control(f, pairs[i][0])->value != off ? V4L2_CTRL_FLAG_INACTIVE : 0;
        fake_tell(f, c->id, flags != c->flags ? V4L2_EVENT_CTRL_CH_FLAGS : 0, -1);
        c->flags = flags;
    }
}

// Whether the control would take the value, and which it would make of it.
static int check_value(const fake_control *c, int32_t *value)
{
    if (c->flags & V4L2_CTRL_FLAG_READ_ONLY)
        return EACCES;
    const bool is_number = c->type == V4L2_CTRL_TYPE_INTEGER;
    if (c->type == V4L2_CTRL_TYPE_BOOLEAN)
        *value = *value != 0;
    if (!is_number && (*value < c->min || *value > c->max))
        return ERANGE;
    if (c->type == V4L2_CTRL_TYPE_MENU && !menu_name(c, *value))
        return EINVAL;
    if (is_number) {
        const int64_t x = *value < c->min ? c->min : *value > c->max ? c->max : *value;
        const int64_t stepped = c->min + (x - c->min + c->step / 2) / c->step * c->step;
        *value = (int32_t)(stepped > c->max ? stepped - c->step : stepped);
    }
    return 0;
}

static void set_value(fake_v4l2 *f, fake_control *c, int32_t value, int i_file)
{
    const bool changed = c->value != value;
    if (c->id == f->faults.forgetful)
        return;
    c->value = value;
    fake_tell(f, c->id, changed ? V4L2_EVENT_CTRL_CH_VALUE : 0, i_file);
    if (changed && c->id == V4L2_CID_EXPOSURE_AUTO && value == V4L2_EXPOSURE_MANUAL && !f->n_payloads)
        fake_v4l2_control(f, V4L2_CID_EXPOSURE_ABSOLUTE)->value = AUTO_EXPOSURE; // it stays at what was found
    fake_controls_update(f);
}

int fake_access_control(fake_v4l2 *f, struct v4l2_control *v, bool write, int i_file)
{
    fake_control *c = fake_v4l2_control(f, v->id);
    if (!c)
        return EINVAL;
    if (!write) {
        v->value = c->value;
        return c->flags & V4L2_CTRL_FLAG_WRITE_ONLY ? EACCES : 0;
    }
    const int code = check_value(c, &v->value);
    if (!code)
        set_value(f, c, v->value, i_file);
    return code;
}

static bool has_class(fake_v4l2 *f, uint32_t which)
{
    return which == V4L2_CTRL_CLASS_USER || which == V4L2_CTRL_CLASS_CAMERA
               ? fake_v4l2_control(f, which + 1) != NULL
               : false;
}

// All are looked at before the first is touched. *at: the one that is wrong.
static int check_all(fake_v4l2 *f, unsigned long request, struct v4l2_ext_controls *c, uint32_t *at)
{
    for (uint32_t i = 0; i < c->count; i++) {
        const fake_control *one = fake_v4l2_control(f, c->controls[i].id);
        *at = i;
        if (!one ||
            (c->which && c->which != V4L2_CTRL_WHICH_DEF_VAL && V4L2_CTRL_ID2WHICH(one->id) != c->which))
            return EINVAL;
        if (request == VIDIOC_G_EXT_CTRLS) {
            if (one->flags & V4L2_CTRL_FLAG_WRITE_ONLY)
                return EACCES;
            continue;
        }
        int32_t value = c->controls[i].value; // the member is packed
        const int code = check_value(one, &value);
        c->controls[i].value = value;
        if (code)
            return code;
    }
    return 0;
}

int fake_ext_controls(fake_v4l2 *f, unsigned long request, struct v4l2_ext_controls *c, int i_file)
{
    const bool defaults = c->which == V4L2_CTRL_WHICH_DEF_VAL, get = request == VIDIOC_G_EXT_CTRLS;
    uint32_t at = 0;
    c->error_idx = c->count;
    c->reserved[0] = 0;
    if ((defaults && !get) || c->which == V4L2_CTRL_WHICH_REQUEST_VAL)
        return EINVAL;
    if (!c->count)
        return !c->which || defaults || has_class(f, c->which) ? 0 : EINVAL;
    const int code = check_all(f, request, c, &at);
    if (code) {
        // What is wrong with a set is told only where it was tried.
        c->error_idx = request == VIDIOC_TRY_EXT_CTRLS ? at : c->count;
        return code;
    }
    for (uint32_t i = 0; i < c->count; i++) {
        fake_control *one = fake_v4l2_control(f, c->controls[i].id);
        if (get)
            c->controls[i].value = defaults ? one->fallback : one->value;
        else if (request == VIDIOC_S_EXT_CTRLS)
            set_value(f, one, c->controls[i].value, i_file);
    }
    return 0;
}

// SPDX-License-Identifier: Apache-2.0
// v4l2_lock.c - which controls there are to hold, in which order, and at which values.
//
// An automatic makes its manual neighbours inactive: automatics go off first, then flags and values are read anew, then
// the rest is fixed. Some cameras listen only to a change: an automatic that stays on is switched on and off once more.
#include "capture/v4l2_lock.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include <linux/videodev2.h>

#include "capture/v4l2_error.h"

typedef enum policy { OFF, KEEP, LEAST, MOST, EXPOSURE, MANUAL } policy;

typedef struct rule {
    uint32_t id;
    policy policy;
} rule;

static const rule automatics[] = {
    {V4L2_CID_EXPOSURE_AUTO, MANUAL},
    {V4L2_CID_EXPOSURE_AUTO_PRIORITY, OFF},
    {V4L2_CID_AUTO_WHITE_BALANCE, OFF},
    {V4L2_CID_AUTOGAIN, OFF},
    {V4L2_CID_HUE_AUTO, OFF},
    {V4L2_CID_CHROMA_AGC, OFF},
    {V4L2_CID_AUTOBRIGHTNESS, OFF},
    {V4L2_CID_COLORFX, OFF},
    {V4L2_CID_BACKLIGHT_COMPENSATION, LEAST},
    {V4L2_CID_FOCUS_AUTO, OFF},
    {V4L2_CID_ISO_SENSITIVITY_AUTO, OFF},
    {V4L2_CID_WIDE_DYNAMIC_RANGE, OFF},
    {V4L2_CID_IMAGE_STABILIZATION, OFF},
    {V4L2_CID_SCENE_MODE, OFF},
    {V4L2_CID_3A_LOCK, MOST},
};

static const rule fixed[] = {
    {V4L2_CID_EXPOSURE_ABSOLUTE, EXPOSURE},
    {V4L2_CID_EXPOSURE, KEEP},
    {V4L2_CID_GAIN, KEEP},
    {V4L2_CID_ANALOGUE_GAIN, KEEP},
    {V4L2_CID_DIGITAL_GAIN, KEEP},
    {V4L2_CID_ISO_SENSITIVITY, KEEP},
    {V4L2_CID_WHITE_BALANCE_TEMPERATURE, KEEP},
    {V4L2_CID_RED_BALANCE, KEEP},
    {V4L2_CID_BLUE_BALANCE, KEEP},
    {V4L2_CID_GAMMA, KEEP},
    {V4L2_CID_BRIGHTNESS, KEEP},
    {V4L2_CID_CONTRAST, KEEP},
    {V4L2_CID_SATURATION, KEEP},
    {V4L2_CID_HUE, KEEP},
    {V4L2_CID_SHARPNESS, LEAST},
    {V4L2_CID_POWER_LINE_FREQUENCY, KEEP},
    {V4L2_CID_FOCUS_ABSOLUTE, KEEP},
    {V4L2_CID_ZOOM_ABSOLUTE, KEEP},
    {V4L2_CID_IRIS_ABSOLUTE, KEEP},
    {V4L2_CID_JPEG_COMPRESSION_QUALITY, MOST},
    {V4L2_CID_VBLANK, KEEP},
    {V4L2_CID_HBLANK, KEEP},
    {V4L2_CID_TEST_PATTERN, OFF},
};
_Static_assert(sizeof automatics / sizeof *automatics + sizeof fixed / sizeof *fixed <=
                   SHEEN_FRAME_MAX_CONTROLS,
               "a frame's description has room for every setting of the lock");

static const double exposure_unit_s = 100e-6; // of V4L2_CID_EXPOSURE_ABSOLUTE

typedef struct locking {
    sheen_v4l2_lock *lock;
    const sheen_v4l2_lock_options *options;
    const sheen_v4l2_io *io;
    int fd;
    sheen_v4l2_controls controls;
    char refused[300]; // names, with what each has against it
    bool gone;
} locking;

static void refuse(locking *k, const sheen_v4l2_control *c, const char *why)
{
    const size_t n = strlen(k->refused);
    snprintf(k->refused + n, sizeof k->refused - n, "%s%s %s", n ? ", " : "", c->name, why);
}

static int32_t on_step(const sheen_v4l2_control *c, double value)
{
    const double steps = floor((value - c->min) / c->step + 0.5);
    const double v = c->min + steps * c->step;
    return v < c->min ? c->min : v > c->max ? c->max : (int32_t)v;
}

double sheen_v4l2_exposure_near(const sheen_v4l2_exposures *e, double want_s)
{
    double near_s = e->most_s > 0 ? fmin(e->most_s, want_s) : want_s, least = (double)INFINITY;
    for (int i = 0; i < e->n_only; i++) {
        const double off = fabs(log(e->only_s[i] / want_s));
        if (off < least) {
            least = off;
            near_s = e->only_s[i];
        }
    }
    return near_s;
}

static int32_t exposure_of(const sheen_v4l2_control *c, const sheen_v4l2_lock_options *o)
{
    double exposure_s = o->exposure_s > 0 ? o->exposure_s : c->value * exposure_unit_s;
    if (o->exposure_s <= 0 && o->mains_hz) {
        const double half_period_s = 0.5 / o->mains_hz;
        double n = floor(exposure_s / half_period_s + 0.5);
        double most_s = c->max * exposure_unit_s;
        most_s = o->exposures->most_s > 0 ? fmin(most_s, o->exposures->most_s) : most_s;
        n = fmin(n, floor(most_s / half_period_s));
        exposure_s = n < 1 ? half_period_s : n * half_period_s;
    }
    return on_step(c, sheen_v4l2_exposure_near(o->exposures, exposure_s) / exposure_unit_s);
}

static int32_t value_of(const sheen_v4l2_control *c, policy p, const sheen_v4l2_lock_options *o)
{
    switch (p) {
    case MANUAL:
        return V4L2_EXPOSURE_MANUAL;
    case LEAST:
        return c->min;
    case MOST:
        return c->max;
    case EXPOSURE:
        return exposure_of(c, o);
    case KEEP:
        return c->value;
    default:
        return 0;
    }
}

// Writes and reads back. 0 or errno; *got is what the camera then says.
static int write_and_read(const locking *k, const sheen_v4l2_control *c, int32_t want, int32_t *got)
{
    const int code = sheen_v4l2_control_set(k->io, k->fd, c->id, want);
    return code ? code : sheen_v4l2_control_get(got, k->io, k->fd, c->id);
}

static void hold(locking *k, const sheen_v4l2_control *c, int32_t value)
{
    sheen_v4l2_setting *s = &k->lock->settings[k->lock->n_settings++];
    *s = (sheen_v4l2_setting){.id = c->id, .value = value};
    memcpy(s->name, c->name, sizeof s->name);
}

static void apply(locking *k, const rule *r, bool is_automatic)
{
    const sheen_v4l2_control *c = sheen_v4l2_controls_find(&k->controls, r->id);
    char why[80];
    int32_t got = 0;
    if (!c || k->gone)
        return;
    if (!c->has_value && (!is_automatic || c->read_only)) {
        refuse(k, c, "cannot be read");
        return;
    }
    const int32_t want = value_of(c, r->policy, k->options);
    if (c->read_only || (c->inactive && !is_automatic)) {
        if (c->value == want || r->policy == KEEP) {
            hold(k, c, c->value); // nothing to set, but watched
            return;
        }
        refuse(k, c, "cannot be set");
        return;
    }
    int code = write_and_read(k, c, want, &got);
    if (is_automatic && !code && got != want) {
        sheen_v4l2_control_set(k->io, k->fd, c->id, c->fallback != want ? c->fallback : c->max);
        code = write_and_read(k, c, want, &got);
    }
    k->gone = code == ENODEV;
    if (!code && (got == want || (r->policy == EXPOSURE && fabs((double)got - want) <= c->step))) {
        hold(k, c, got);
        return;
    }
    if (code)
        snprintf(why, sizeof why, "does not take %ld (%.40s)", (long)want, strerror(code));
    else
        snprintf(why, sizeof why, "went back from %ld to %ld", (long)want, (long)got);
    refuse(k, c, why);
}

bool sheen_v4l2_is_automatic(const sheen_v4l2_controls *c)
{
    const sheen_v4l2_control *a = sheen_v4l2_controls_find(c, V4L2_CID_EXPOSURE_AUTO);
    return a && (!a->has_value || a->value != V4L2_EXPOSURE_MANUAL);
}

static sheen_status refusal(const locking *k, const char *path, sheen_err *err)
{
    if (k->gone)
        return sheen_v4l2_fail(err, ENODEV, "set the controls of", path);
    if (k->refused[0])
        return sheen_fail(
            err, SHEEN_EUNSUP,
            "the settings of '%.100s' cannot be locked: %s; add '?lock=off' to record without a lock, use "
            "another camera for measuring",
            path, k->refused);
    if (sheen_v4l2_controls_find(&k->controls, V4L2_CID_EXPOSURE_ABSOLUTE) ||
        sheen_v4l2_controls_find(&k->controls, V4L2_CID_EXPOSURE))
        return SHEEN_OK;
    return sheen_fail(
        err, SHEEN_EUNSUP,
        "the settings of '%.100s' cannot be locked: it has no control of its exposure; add '?lock=off' to "
        "record without a lock",
        path);
}

sheen_status sheen_v4l2_lock_set(sheen_v4l2_lock *lock, const sheen_v4l2_lock_options *o,
                                 const sheen_v4l2_io *io, int fd, const char *path, sheen_err *err)
{
    locking k = {.lock = lock, .options = o, .io = io, .fd = fd};
    *lock = (sheen_v4l2_lock){0};
    sheen_status s = sheen_v4l2_controls_read(&k.controls, io, fd, path, err);
    if (s)
        return s;
    for (size_t i = 0; i < sizeof automatics / sizeof *automatics; i++)
        apply(&k, &automatics[i], true);
    sheen_v4l2_controls_release(&k.controls);
    s = sheen_v4l2_controls_read(&k.controls, io, fd, path, err);
    if (s)
        return s;
    for (size_t i = 0; i < sizeof fixed / sizeof *fixed; i++)
        apply(&k, &fixed[i], false);
    s = refusal(&k, path, err);
    sheen_v4l2_controls_release(&k.controls);
    return s;
}

sheen_status sheen_v4l2_lock_follow(sheen_v4l2_lock *lock, const sheen_frame_info *earlier,
                                    bool keep_exposure, const sheen_v4l2_io *io, int fd, const char *path,
                                    sheen_err *err)
{
    for (int i = 0; i < earlier->n_controls; i++)
        for (int k = 0; k < lock->n_settings; k++) {
            sheen_v4l2_setting *set = &lock->settings[k];
            const int32_t want = earlier->controls[i].value;
            if (set->id != earlier->controls[i].id || set->value == want ||
                (keep_exposure && set->id == V4L2_CID_EXPOSURE_ABSOLUTE))
                continue;
            int32_t got = 0;
            int code = sheen_v4l2_control_set(io, fd, set->id, want);
            if (!code)
                code = sheen_v4l2_control_get(&got, io, fd, set->id);
            if (code == ENODEV || code == EIO)
                return sheen_v4l2_fail(err, code, "set the controls of", path);
            if (code || got != want)
                return sheen_fail(
                    err, SHEEN_EUNSUP,
                    "'%.100s' does not take the session's settings again: its %s was %ld; set it "
                    "back where it can be set, or begin a new session",
                    path, set->name, (long)want);
            set->value = got;
        }
    return SHEEN_OK;
}

sheen_status sheen_v4l2_lock_check(const sheen_v4l2_lock *lock, sheen_frame_info *f, const sheen_v4l2_io *io,
                                   int fd, const char *path, sheen_err *err)
{
    sheen_status s = SHEEN_OK;
    for (int i = 0; i < lock->n_settings; i++) {
        const sheen_v4l2_setting *set = &lock->settings[i];
        int32_t value = 0;
        const int code = sheen_v4l2_control_get(&value, io, fd, set->id);
        if (code)
            return sheen_v4l2_fail(err, code, "read back the settings of", path);
        f->controls[i] = (sheen_frame_control){set->id, value};
        if (value != set->value && !s)
            s = sheen_fail(err, SHEEN_EDATA,
                           "the camera '%s' did not keep its settings: %s was %ld and is now %ld", path,
                           set->name, (long)set->value, (long)value);
    }
    f->n_controls = lock->n_settings;
    return s;
}

sheen_status sheen_v4l2_lock_again(const sheen_v4l2_lock *lock, const sheen_v4l2_io *io, int fd,
                                   const char *path, sheen_err *err)
{
    for (int i = 0; i < lock->n_settings; i++) {
        const sheen_v4l2_setting *set = &lock->settings[i];
        int32_t value = 0;
        int code = sheen_v4l2_control_get(&value, io, fd, set->id);
        if (!code && value != set->value)
            code = sheen_v4l2_control_set(io, fd, set->id, set->value);
        if (code)
            return sheen_v4l2_fail(err, code, "set the controls of", path);
    }
    return SHEEN_OK;
}

double sheen_v4l2_lock_exposure_s(const sheen_v4l2_lock *lock)
{
    for (int i = 0; i < lock->n_settings; i++)
        if (lock->settings[i].id == V4L2_CID_EXPOSURE_ABSOLUTE)
            return lock->settings[i].value * exposure_unit_s;
    return 0;
}

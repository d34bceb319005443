// SPDX-License-Identifier: Apache-2.0
// v4l2_prepare.c - the way from a running stream to one whose frames are known to be taken as the lock says.
#include "capture/v4l2_prepare.h"

#include <errno.h>
#include <math.h>

#include <linux/videodev2.h>

#include "base/pixel_format.h"
#include "capture/v4l2_error.h"

enum { WARM_UP_FRAMES = 15 };
static const double unit_s = 100e-6; // of V4L2_CID_EXPOSURE_ABSOLUTE
// Half the exposure is half the light, within what a camera's black level and curve make of it.
static const float probe_most = 0.8f, return_most = 0.05f;
static const float probe_dark = 0.01f, probe_white = 0.9f; // means beyond which a picture says nothing

static void enter(sheen_v4l2_prepare *p, sheen_v4l2_phase phase)
{
    p->phase = phase;
    p->n_frames = 0;
    p->settle = (sheen_settle){0};
    p->changed_ns = p->stream->io->now_ns(p->stream->io->self);
}

static sheen_status set_lock(sheen_v4l2_prepare *p, sheen_err *err)
{
    const sheen_v4l2_lock_options o = {p->options->exposure_s, p->options->mains_hz, &p->options->exposures};
    enter(p, SHEEN_V4L2_SETTLE);
    const sheen_status s = sheen_v4l2_lock_set(&p->lock, &o, p->stream->io, p->stream->fd, p->stream->path,
                                               err);
    p->locked = !s;
    return s;
}

sheen_status sheen_v4l2_prepare_begin(sheen_v4l2_prepare *p, sheen_err *err)
{
    sheen_v4l2_controls c;
    enter(p, SHEEN_V4L2_WARM_UP);
    const sheen_status s = sheen_v4l2_controls_read(&c, p->stream->io, p->stream->fd, p->stream->path, err);
    if (s)
        return s;
    const bool automatic = sheen_v4l2_is_automatic(&c);
    sheen_v4l2_controls_release(&c);
    return automatic && p->options->exposure_s <= 0 ? SHEEN_OK : set_lock(p, err);
}

void sheen_v4l2_prepare_again(sheen_v4l2_prepare *p)
{
    enter(p, SHEEN_V4L2_SETTLE);
}

sheen_status sheen_v4l2_prepare_resume(sheen_v4l2_prepare *p, sheen_err *err)
{
    p->probed = false;
    if (!p->locked)
        return sheen_v4l2_prepare_begin(p, err);
    enter(p, SHEEN_V4L2_SETTLE);
    return sheen_v4l2_lock_again(&p->lock, p->stream->io, p->stream->fd, p->stream->path, err);
}

sheen_status sheen_v4l2_prepare_follow(sheen_v4l2_prepare *p, const sheen_frame_info *earlier, bool covered,
                                       sheen_err *err)
{
    sheen_status s = p->locked ? SHEEN_OK : set_lock(p, err);
    if (!s)
        s = sheen_v4l2_lock_follow(&p->lock, earlier, p->options->exposure_s > 0, p->stream->io,
                                   p->stream->fd, p->stream->path, err);
    enter(p, SHEEN_V4L2_SETTLE);
    p->probed = covered;
    return s;
}

static sheen_status light_of(float rgb[3], const sheen_v4l2_prepare *p, const sheen_v4l2_frame *frame,
                             sheen_err *err)
{
    const sheen_v4l2_format *f = &p->stream->format;
    const sheen_pixel_layout layout = {f->fourcc, f->width_px, f->height_px, f->stride_bytes, f->color};
    sheen_raster raster;
    const sheen_status s = sheen_payload_develop(&raster, frame->data, frame->size_bytes, &layout, err);
    if (s)
        return s;
    sheen_settle_mean(rgb, &raster, p->transfer);
    sheen_raster_release(&raster);
    return SHEEN_OK;
}

static sheen_status set_exposure(sheen_v4l2_prepare *p, int32_t value, sheen_v4l2_phase next, sheen_err *err)
{
    enter(p, next);
    const int code = sheen_v4l2_control_set(p->stream->io, p->stream->fd, V4L2_CID_EXPOSURE_ABSOLUTE, value);
    return code ? sheen_v4l2_fail(err, code, "set the exposure of", p->stream->path) : SHEEN_OK;
}

sheen_status sheen_v4l2_prepare_expose(sheen_v4l2_prepare *p, double factor, double *exposure_s_out,
                                       sheen_err *err)
{
    sheen_v4l2_setting *set = NULL;
    int32_t got = 0;
    for (int i = 0; i < p->lock.n_settings; i++)
        if (p->lock.settings[i].id == V4L2_CID_EXPOSURE_ABSOLUTE)
            set = &p->lock.settings[i];
    if (!set || p->phase != SHEEN_V4L2_FINISHED)
        return sheen_fail(err, SHEEN_EUNSUP,
                          "the exposure of '%.200s' is not under the lock: a bracket needs that",
                          p->stream->path);
    p->base_exposure = p->base_exposure ? p->base_exposure : set->value;
    const double near_s = sheen_v4l2_exposure_near(&p->options->exposures,
                                                   p->base_exposure * factor * unit_s);
    const int32_t want = (int32_t)fmax(1, floor(near_s / unit_s + 0.5));
    const sheen_status s = set_exposure(p, want, SHEEN_V4L2_SETTLE, err);
    const int code = s ? 0 : sheen_v4l2_control_get(&got, p->stream->io, p->stream->fd, set->id);
    if (s || code)
        return s ? s : sheen_v4l2_fail(err, code, "read back the exposure of", p->stream->path);
    set->value = got;
    p->probed = true;
    *exposure_s_out = sheen_v4l2_lock_exposure_s(&p->lock);
    return SHEEN_OK;
}

// Half the locked exposure is *can, where the camera has that and the picture is neither black nor white.
static sheen_status can_probe(bool *can, sheen_v4l2_prepare *p, sheen_err *err)
{
    sheen_v4l2_controls c;
    const float light = fmaxf(p->rgb[0], fmaxf(p->rgb[1], p->rgb[2]));
    *can = false;
    if (p->probed || light < probe_dark || light > probe_white)
        return SHEEN_OK;
    const sheen_status s = sheen_v4l2_controls_read(&c, p->stream->io, p->stream->fd, p->stream->path, err);
    if (s)
        return s;
    const sheen_v4l2_control *e = sheen_v4l2_controls_find(&c, V4L2_CID_EXPOSURE_ABSOLUTE);
    const int64_t locked = (int64_t)(sheen_v4l2_lock_exposure_s(&p->lock) / unit_s + 0.5);
    if (e && !e->read_only && !e->inactive && locked >= 2 && locked / 2 >= e->min) {
        p->exposure = (int32_t)locked;
        p->probe_exposure = e->min + ((int32_t)locked / 2 - e->min) / e->step * e->step;
        *can = 3 * (int64_t)p->probe_exposure <= 2 * locked;
    }
    sheen_v4l2_controls_release(&c);
    return SHEEN_OK;
}

static float mean(const float rgb[3])
{
    return (rgb[0] + rgb[1] + rgb[2]) / 3;
}

static sheen_status on_rest(sheen_v4l2_prepare *p, const float rgb[3], sheen_err *err)
{
    const float ratio = mean(rgb) / fmaxf(mean(p->rgb), 1e-6f);
    bool can = false;
    sheen_status s;
    switch (p->phase) {
    case SHEEN_V4L2_PROBE:
        if (ratio > probe_most)
            return sheen_fail(
                err, SHEEN_EDATA,
                "'%s' says that it obeys, but half the exposure gives %.0f %% of the light: an automatic is "
                "still at work; add '?lock=off' to record without a lock, use another camera for measuring",
                p->stream->path, 100 * (double)ratio);
        return set_exposure(p, p->exposure, SHEEN_V4L2_RETURN, err);
    case SHEEN_V4L2_RETURN:
        if (fabsf(ratio - 1) > return_most)
            return sheen_fail(
                err, SHEEN_EDATA,
                "the picture of '%s' has changed by %.0f %% within a second under the same settings: keep "
                "camera and lights still while it starts",
                p->stream->path, 100 * fabs((double)ratio - 1));
        p->probed = true;
        p->phase = SHEEN_V4L2_FINISHED;
        return SHEEN_OK;
    default:
        for (int c = 0; c < 3; c++)
            p->rgb[c] = rgb[c];
        s = can_probe(&can, p, err);
        if (s)
            return s;
        if (can)
            return set_exposure(p, p->probe_exposure, SHEEN_V4L2_PROBE, err);
        p->phase = SHEEN_V4L2_FINISHED;
        return SHEEN_OK;
    }
}

sheen_status sheen_v4l2_prepare_frame(sheen_v4l2_prepare *p, const sheen_v4l2_frame *frame, int64_t start_ns,
                                      sheen_err *err)
{
    float rgb[3];
    p->n_frames++;
    if (p->phase == SHEEN_V4L2_WARM_UP)
        return p->n_frames < WARM_UP_FRAMES ? SHEEN_OK : set_lock(p, err);
    if (start_ns < 0 ? p->n_frames <= SHEEN_V4L2_MAX_BUFFERS : start_ns < p->changed_ns)
        return SHEEN_OK; // exposed before the change
    const sheen_status s = light_of(rgb, p, frame, err);
    if (s == SHEEN_EFORMAT) {
        p->stream->counts.n_short++; // a JPEG that is broken inside
        return SHEEN_OK;
    }
    if (s)
        return s;
    if (sheen_settle_add(&p->settle, rgb))
        return on_rest(p, rgb, err);
    if (p->n_frames < SHEEN_SETTLE_GIVE_UP)
        return SHEEN_OK;
    return sheen_fail(
        err, SHEEN_EDATA,
        "the picture of '%s' does not come to rest, it changes by %.0f %% from frame to frame: do lamps "
        "flicker (say mains=60 or mains=50), or does something move?",
        p->stream->path, 100 * (double)sheen_settle_spread(&p->settle));
}

// SPDX-License-Identifier: Apache-2.0
// libcamera_frames.c - accounts for the frames of a libcamera camera; knows nothing of libcamera.
#include "capture/libcamera_frames.h"

#include <stdio.h>

#include <linux/videodev2.h>

#include "capture/v4l2_stream.h"

sheen_status sheen_libcamera_frames_describe(sheen_libcamera_frames *f, const char *name, const char *id,
                                             const char *claim, const sheen_transfer *transfer,
                                             sheen_err *err)
{
    sheen_frame_info *info = &f->info;
    f->needed_bytes = 0;
    if (info->fourcc) {
        const sheen_pixel_layout layout = {info->fourcc, info->width_px, info->height_px, info->stride_bytes,
                                           info->color};
        f->needed_bytes = sheen_pixels_size(&layout);
        if (!f->needed_bytes)
            return sheen_fail(err, SHEEN_EIO, "'%.80s' claims %.80s: that cannot be", name, claim);
    }
    info->lock = f->locked ? SHEEN_LOCK_HELD : SHEEN_LOCK_OFF;
    snprintf(info->source, sizeof info->source, "libcamera:%.200s", id);
    snprintf(info->device, sizeof info->device, "%.60s (%.60s)", name, id);
    if (transfer) {
        info->transfer = *transfer;
        return SHEEN_OK;
    }
    return sheen_pixels_transfer(&info->transfer, info->fourcc ? info->fourcc : V4L2_PIX_FMT_MJPEG,
                                 &info->color, err);
}

bool sheen_libcamera_frames_turn(sheen_libcamera_frames *f, int64_t sequence, bool success)
{
    if (f->begun && sequence <= f->last_sequence) {
        f->counts.n_late++;
        return false;
    }
    if (f->begun)
        f->counts.n_dropped += sequence - f->last_sequence - 1;
    f->begun = true;
    f->last_sequence = sequence;
    f->counts.n_flagged += !success;
    return success;
}

static bool is_whole(const sheen_libcamera_frames *f, const uint8_t *data, size_t size_bytes)
{
    return f->info.fourcc ? size_bytes >= f->needed_bytes : sheen_v4l2_jpeg_whole(data, size_bytes);
}

sheen_status sheen_libcamera_frames_judge(bool *keep, sheen_frame *frame, sheen_libcamera_frames *f,
                                          const sheen_frame_pipeline *says, const char *name, sheen_err *err)
{
    const int64_t t_ns = frame->info.t_ns;
    *keep = is_whole(f, frame->data, frame->size_bytes);
    if (!*keep) {
        f->counts.n_short++;
        return SHEEN_OK;
    }
    frame->info = f->info;
    frame->extension = f->info.fourcc ? "raw" : "jpg";
    frame->info.sequence = f->last_sequence;
    frame->info.pipeline = *says;
    frame->info.t_ns = t_ns;
    if (f->locked) {
        const bool was_held = f->lock.phase == SHEEN_LIBCAMERA_HELD;
        const sheen_status s = sheen_libcamera_lock_frame(keep, &f->lock, says, name, err);
        if (s)
            return s;
        f->counts.n_unlocked += was_held && !*keep;
    }
    f->counts.n_frames += *keep;
    return SHEEN_OK;
}

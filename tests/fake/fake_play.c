// SPDX-License-Identifier: Apache-2.0
// fake_play.c - the fake camera delivers what a session recorded.
#include <stdlib.h>

#include "tests/fake/fake_parts.h"

sheen_status fake_v4l2_play(fake_v4l2 *f, const sheen_session *s, sheen_err *err)
{
    if (!s->n_frames)
        return sheen_fail(err, SHEEN_EDATA, "'%s' has no frames", s->path);
    f->payloads = calloc(s->n_frames, sizeof *f->payloads);
    f->payload_bytes = calloc(s->n_frames, sizeof *f->payload_bytes);
    f->recorded = calloc(s->n_frames, sizeof *f->recorded);
    if (!f->payloads || !f->payload_bytes || !f->recorded)
        return sheen_fail_memory(err, (double)s->n_frames, "a recording");
    for (size_t i = 0; i < s->n_frames; i++) {
        const sheen_frame_info *g = &s->frames[i];
        const sheen_status st = sheen_session_payload(&f->payloads[i], &f->payload_bytes[i], s, g, err);
        if (st)
            return st;
        f->n_payloads = i + 1;
        f->recorded[i] = *g;
        if (i &&
            (g->fourcc != s->frames[0].fourcc || g->width_px != f->width_px || g->height_px != f->height_px))
            return sheen_fail(err, SHEEN_EUNSUP, "the frames of '%s' differ in format or size", s->path);
        f->fourcc = g->fourcc ? g->fourcc : V4L2_PIX_FMT_MJPEG;
        f->width_px = g->width_px;
        f->height_px = g->height_px;
        f->stride_bytes = g->stride_bytes;
        f->color = g->color;
        if (!f->color.colorspace) // a driver names one
            f->color.colorspace = g->fourcc ? V4L2_COLORSPACE_SRGB : V4L2_COLORSPACE_JPEG;
    }
    fake_play_settings(f, 0);
    return SHEEN_OK;
}

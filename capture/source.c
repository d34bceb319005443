// SPDX-License-Identifier: Apache-2.0
// source.c - opens sources by URI and hands calls to their backends.
#include "capture/source.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "capture/source_backend.h"

struct sheen_source {
    const sheen_source_backend *backend;
    void *self;
    atomic_bool stopped;
};

static const sheen_source_backend *const backends[] = {
    &sheen_source_replay,
    &sheen_source_v4l2,
#ifdef SHEEN_LIBCAMERA
    &sheen_source_libcamera,
#endif
};
enum { N_BACKENDS = sizeof backends / sizeof *backends };

// Kinds of sources that sheen's URIs have names for, so that a build without one can say that it is.
static const char *const camera_schemes[] = {"libcamera"};

const char *const *sheen_source_schemes(void)
{
    static const char *const schemes[] = {
        "replay",
        "v4l2",
#ifdef SHEEN_LIBCAMERA
        "libcamera",
#endif
        NULL,
    };
    return schemes;
}

static sheen_status find_backend(const sheen_source_backend **out, const char *uri, sheen_err *err)
{
    const char *colon = strchr(uri, ':');
    const size_t n = colon ? (size_t)(colon - uri) : 0;
    for (size_t i = 0; colon && i < N_BACKENDS; i++)
        if (!strncmp(uri, backends[i]->scheme, n) && !backends[i]->scheme[n]) {
            *out = backends[i];
            return colon[1] ? SHEEN_OK
                            : sheen_fail(err, SHEEN_EARG,
                                         "'%s' names nothing: write replay:SESSION or v4l2:/dev/videoN", uri);
        }
    for (size_t i = 0; colon && i < sizeof camera_schemes / sizeof *camera_schemes; i++)
        if (!strncmp(uri, camera_schemes[i], n) && !camera_schemes[i][n])
            return sheen_fail(
                err, SHEEN_EUNSUP,
                "this build has no support for '%.200s': use v4l2:/dev/videoN, import image files, or "
                "use replay:SESSION",
                uri);
    return sheen_fail(err, SHEEN_EARG,
                      "unknown kind of source '%.200s': use v4l2:/dev/videoN or replay:SESSION", uri);
}

sheen_status sheen_source_adopt(sheen_source **src_out, const sheen_source_backend *backend, void *self,
                                sheen_err *err)
{
    sheen_source *src = calloc(1, sizeof *src);
    *src_out = src;
    if (!src) {
        backend->close(self);
        return sheen_fail_memory(err, sizeof *src, "a source");
    }
    src->backend = backend;
    src->self = self;
    atomic_init(&src->stopped, false);
    return SHEEN_OK;
}

sheen_status sheen_source_open(sheen_source **src_out, const char *uri, sheen_err *err)
{
    const sheen_source_backend *backend = NULL;
    void *self = NULL;
    *src_out = NULL;
    sheen_status s = find_backend(&backend, uri, err);
    if (s)
        return s;
    s = backend->open(&self, strchr(uri, ':') + 1, err);
    return s ? sheen_wrap(err, s, "cannot open source '%.200s'", uri)
             : sheen_source_adopt(src_out, backend, self, err);
}

sheen_status sheen_source_next(sheen_source *src, int timeout_ms, sheen_frame *frame, sheen_err *err)
{
    *frame = (sheen_frame){0};
    sheen_frame_info_init(&frame->info);
    if (atomic_load(&src->stopped))
        return sheen_fail(err, SHEEN_ECANCEL, "the source was stopped");
    return src->backend->next(src->self, timeout_ms, frame, err);
}

sheen_status sheen_frame_develop(sheen_raster *out, const sheen_frame *frame, sheen_err *err)
{
    const sheen_frame_info *f = &frame->info;
    const sheen_pixel_layout layout = {f->fourcc, f->width_px, f->height_px, f->stride_bytes, f->color};
    return sheen_payload_develop(out, frame->data, frame->size_bytes, &layout, err);
}

bool sheen_device_is_alike(const char *a, const char *b)
{
    const size_t n = strcspn(a, "("); // its place is in brackets
    return n == strcspn(b, "(") && !strncmp(a, b, n);
}

int64_t sheen_source_count(const sheen_source *src)
{
    return src->backend->count ? src->backend->count(src->self) : -1;
}

void sheen_source_counters(sheen_source_counts *out, const sheen_source *src)
{
    *out = (sheen_source_counts){0};
    if (src->backend->counters)
        src->backend->counters(out, src->self);
}

bool sheen_source_is_live(const sheen_source *src)
{
    return src->backend->counters != NULL;
}

sheen_status sheen_source_expose(sheen_source *src, double factor, double *exposure_s_out, sheen_err *err)
{
    return src->backend->expose
               ? src->backend->expose(src->self, factor, exposure_s_out, err)
               : sheen_fail(err, SHEEN_EUNSUP,
                            "the exposure of this source cannot be set: a bracket needs v4l2:");
}

sheen_status sheen_source_follow(sheen_source *src, const sheen_frame_info *earlier, bool covered,
                                 bool *followed, sheen_err *err)
{
    *followed = false;
    return src->backend->follow ? src->backend->follow(src->self, earlier, covered, followed, err) : SHEEN_OK;
}

bool sheen_source_can_recover(const sheen_source *src)
{
    return src->backend->recover != NULL;
}

sheen_status sheen_source_recover(sheen_source *src, sheen_rung rung, sheen_err *err)
{
    return src->backend->recover ? src->backend->recover(src->self, rung, err)
                                 : sheen_fail(err, SHEEN_EUNSUP, "a recording has no device to recover");
}

bool sheen_source_await(sheen_source *src, int timeout_ms)
{
    return !src->backend->await || src->backend->await(src->self, timeout_ms);
}

void sheen_source_stop(sheen_source *src)
{
    atomic_store(&src->stopped, true);
    if (src->backend->stop)
        src->backend->stop(src->self);
}

void sheen_source_close(sheen_source **src)
{
    if (!src || !*src)
        return;
    (*src)->backend->close((*src)->self);
    free(*src);
    *src = NULL;
}

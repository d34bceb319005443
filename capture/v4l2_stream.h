// SPDX-License-Identifier: Apache-2.0
// v4l2_stream.h - frames out of an opened and configured video node, by mmap: whole, in order, and accounted for.
//
// Every buffer goes back to the driver as soon as it was looked at; what is good has been copied. Drivers may finish
// buffers out of order: frames wait, a few at most, until their turn.
#ifndef SHEEN_CAPTURE_V4L2_STREAM_H
#define SHEEN_CAPTURE_V4L2_STREAM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "capture/source.h"
#include "capture/v4l2_io.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SHEEN_V4L2_MAX_BUFFERS = 8, SHEEN_V4L2_HOLD = 4 };

// What the node was configured to deliver.
typedef struct sheen_v4l2_format {
    uint32_t fourcc;
    int width_px, height_px, stride_bytes; // stride_bytes 0: JPEG
    size_t size_bytes;                     // of the driver's buffers
    size_t needed_bytes;                   // a frame with fewer is short; 0: JPEG
    sheen_colorimetry color;
    int64_t interval_ns; // between two frames, as the driver says; a guess where it does not
} sheen_v4l2_format;

typedef struct sheen_v4l2_frame {
    bool used, rejected;
    int64_t sequence; // counts on where the driver's 32 bits wrap
    int64_t t_ns;     // as stamped; -1 where the driver's clock is not CLOCK_MONOTONIC
    bool end_stamped; // t_ns is the end of the frame, not the start of its exposure
    size_t size_bytes;
    uint8_t *data; // room for format.size_bytes
} sheen_v4l2_frame;

typedef struct sheen_v4l2_stream {
    const sheen_v4l2_io *io;
    int fd, wake_fd;
    const char *path;
    sheen_v4l2_format format;
    void *buffers[SHEEN_V4L2_MAX_BUFFERS];
    size_t lengths_bytes[SHEEN_V4L2_MAX_BUFFERS];
    bool queued[SHEEN_V4L2_MAX_BUFFERS];
    int n_buffers;
    bool on, begun;
    sheen_v4l2_frame slots[SHEEN_V4L2_HOLD + 1], *lent;
    int64_t held_since_ns;
    uint32_t last_raw;                // driver's number of
    int64_t last_sequence, last_t_ns; // the last frame whose turn it was
    sheen_source_counts counts;
} sheen_v4l2_stream;

// Starts streaming on s->fd in s->format (set by the caller, with io, wake_fd and path; the rest zero). After a failure
// nothing is left to stop.
sheen_status sheen_v4l2_stream_start(sheen_v4l2_stream *s, sheen_err *err);
// The next good frame in the order of the sequence numbers, until the time deadline_ns of the io's clock; lent until
// the next call. ETIMEOUT, ECANCEL (wake_fd), ENODEV, EIO.
sheen_status sheen_v4l2_stream_next(sheen_v4l2_stream *s, int64_t deadline_ns,
                                    const sheen_v4l2_frame **frame_out, sheen_err *err);
// Stops and frees everything, in whatever state it is; counts stay. The node stays open.
void sheen_v4l2_stream_stop(sheen_v4l2_stream *s);

// A JPEG with its beginning and its end; zeros may follow.
bool sheen_v4l2_jpeg_whole(const uint8_t *data, size_t size_bytes);

#ifdef __cplusplus
}
#endif
#endif

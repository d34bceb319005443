// SPDX-License-Identifier: Apache-2.0
// v4l2_camera.h - opens a video node and has it deliver one format.
#ifndef SHEEN_CAPTURE_V4L2_CAMERA_H
#define SHEEN_CAPTURE_V4L2_CAMERA_H

#include "capture/v4l2_options.h"
#include "capture/v4l2_stream.h"

// Opens a node that captures video by streaming; *device says what it is and where. ENODEV, EACCESS, EIO (busy),
// EUNSUP (no camera: an output, or a camera's node for metadata).
sheen_status sheen_v4l2_camera_open(int *fd_out, char device[128], const sheen_v4l2_io *io, const char *path,
                                    sheen_err *err);

// True for the formats that sheen records: JPEG, and those of base/pixel_format.h.
bool sheen_v4l2_is_jpeg(uint32_t fourcc);
bool sheen_v4l2_is_recorded(uint32_t fourcc);
// "YUYV"
void sheen_v4l2_fourcc_text(char text[8], uint32_t fourcc);

// Sets format, size and rate as asked for, the camera's own where nothing was. EUNSUP where it offers none such, with
// what it does offer.
sheen_status sheen_v4l2_camera_configure(sheen_v4l2_format *f, const sheen_v4l2_options *o,
                                         const sheen_v4l2_io *io, int fd, sheen_err *err);

#endif

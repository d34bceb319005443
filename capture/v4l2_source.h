// SPDX-License-Identifier: Apache-2.0
// v4l2_source.h - a V4L2 camera as a source, on any seam.
#ifndef SHEEN_CAPTURE_V4L2_SOURCE_H
#define SHEEN_CAPTURE_V4L2_SOURCE_H

#include "capture/source.h"
#include "capture/v4l2_io.h"

// sheen_source_open for "v4l2:" and `rest`, through this seam instead of the kernel. The seam must outlive the source.
sheen_status sheen_v4l2_source_open(sheen_source **src_out, const sheen_v4l2_io *io, const char *rest,
                                    sheen_err *err);

#endif

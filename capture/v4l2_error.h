// SPDX-License-Identifier: Apache-2.0
// v4l2_error.h - what the kernel's refusals mean for a person with a camera.
#ifndef SHEEN_CAPTURE_V4L2_ERROR_H
#define SHEEN_CAPTURE_V4L2_ERROR_H

#include <stddef.h>

#include "base/status.h"
#include "capture/v4l2_io.h"

// io->ioctl, again where a signal interrupted it.
int sheen_v4l2_ioctl(const sheen_v4l2_io *io, int fd, unsigned long request, void *arg);

// sheen_fail for errno `code` of a call on the node `path` that was to `what` ("start the stream of"). ENODEV (gone or
// never there), EACCESS, EUNSUP (the driver knows no such call), ENOMEM, EIO (busy, with the name of the program that
// holds the camera; bandwidth; the rest).
sheen_status sheen_v4l2_fail(sheen_err *err, int code, const char *what, const char *path);

// Who else has the file open: "motion (process 1234)"; "" where nobody, or nobody that we may look at. The folder of
// processes is "/proc".
void sheen_v4l2_holder(char *out, size_t size_bytes, const char *path, const char *proc);

#endif

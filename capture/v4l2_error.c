// SPDX-License-Identifier: Apache-2.0
// v4l2_error.c - errno of a video node as a sentence that says what to do.
#include "capture/v4l2_error.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

int sheen_v4l2_ioctl(const sheen_v4l2_io *io, int fd, unsigned long request, void *arg)
{
    int r;
    do
        r = io->ioctl(io->self, fd, request, arg);
    while (r < 0 && errno == EINTR);
    return r;
}

static sheen_status fail_busy(sheen_err *err, const char *what, const char *path)
{
    char holder[96];
    sheen_v4l2_holder(holder, sizeof holder, path, "/proc");
    return sheen_fail(err, SHEEN_EIO, "cannot %s '%s': %s uses the camera; close it and try again", what,
                      path, holder[0] ? holder : "another program");
}

sheen_status sheen_v4l2_fail(sheen_err *err, int code, const char *what, const char *path)
{
    switch (code) {
    case ENOENT:
        return sheen_fail(err, SHEEN_ENODEV, "there is no '%s': 'sheen devices' lists the cameras", path);
    case ENODEV:
    case ENXIO:
        return sheen_fail(err, SHEEN_ENODEV,
                          "cannot %s '%s': the camera is gone; plug it in and give the same command again",
                          what, path);
    case EACCES:
    case EPERM:
        return sheen_fail(
            err, SHEEN_EACCESS,
            "cannot %s '%s': no permission; join the group 'video' (usermod -aG video NAME) and log "
            "in again",
            what, path);
    case EBUSY:
        return fail_busy(err, what, path);
    case ENOSPC:
        return sheen_fail(
            err, SHEEN_EIO,
            "cannot %s '%s': the USB bus has no bandwidth left (this is not about disk space); put the "
            "camera on a port of its own, or ask for MJPG, a smaller size or a lower rate",
            what, path);
    case ENOTTY:
        return sheen_fail(err, SHEEN_EUNSUP, "cannot %s '%s': its driver does not offer that", what, path);
    case ENOMEM:
        return sheen_fail(err, SHEEN_ENOMEM, "cannot %s '%s': out of memory for its buffers", what, path);
    default:
        return sheen_fail(err, SHEEN_EIO, "cannot %s '%s': %s; unplug the camera and plug it in again", what,
                          path, strerror(code));
    }
}

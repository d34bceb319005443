// SPDX-License-Identifier: Apache-2.0
// devices.c - what a camera says about itself when it is asked.
#include "capture/devices.h"

#include <stdio.h>
#include <stdlib.h>

#include "capture/v4l2_camera.h"

bool sheen_device_ask(sheen_device *d, const sheen_v4l2_io *io)
{
    int fd = -1;
    char name[128];
    sheen_err err = {0};
    d->status = sheen_v4l2_camera_open(&fd, name, io, d->path, &err);
    if (d->status == SHEEN_EUNSUP)
        return false;
    if (!d->status) {
        snprintf(d->name, sizeof d->name, "%s", name);
        d->status = sheen_v4l2_modes_read(&d->modes, &d->n_modes, io, fd, &err);
        if (!d->status)
            d->status = sheen_v4l2_controls_read(&d->controls, io, fd, d->path, &err);
        io->close(io->self, fd);
    }
    if (d->status)
        snprintf(d->problem, sizeof d->problem, "%.255s", err.msg);
    return true;
}

void sheen_devices_release(sheen_device *devices, size_t n_devices)
{
    for (size_t i = 0; devices && i < n_devices; i++) {
        free(devices[i].modes);
        sheen_v4l2_controls_release(&devices[i].controls);
    }
    free(devices);
}

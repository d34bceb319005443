// SPDX-License-Identifier: Apache-2.0
// serial_devices.c - which of the serial lines is the turntable, where nobody said so.
//
// The chips of such boards are in all sorts of machines: where several are plugged in, guessing could set a stranger
// in motion, so the person is asked.
#include "capture/serial_devices.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *lasting_name(const sheen_serial_device *d)
{
    return d->by_id[0] ? d->by_id : d->path;
}

sheen_status sheen_serial_device_choose(char path[SHEEN_SERIAL_DEVICE_PATH],
                                        const sheen_serial_device *devices, size_t n, sheen_err *err)
{
    char names[320] = "";
    for (size_t i = 0; i < n; i++)
        if (devices[i].is_turntable) {
            snprintf(path, SHEEN_SERIAL_DEVICE_PATH, "%s", SHEEN_TURNTABLE_LINK);
            return SHEEN_OK;
        }
    if (n == 1) {
        snprintf(path, SHEEN_SERIAL_DEVICE_PATH, "%s", lasting_name(&devices[0]));
        return SHEEN_OK;
    }
    if (!n)
        return sheen_fail(err, SHEEN_ENODEV, "no turntable is plugged in: look at its cable and its power");
    for (size_t i = 0; i < n; i++) {
        const size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", lasting_name(&devices[i]));
    }
    return sheen_fail(err, SHEEN_EDATA, "%zu serial lines could be the turntable: name one of %s", n, names);
}

sheen_status sheen_serial_device_find(char path[SHEEN_SERIAL_DEVICE_PATH], sheen_err *err)
{
    sheen_serial_device *devices;
    size_t n;
    sheen_status s = sheen_serial_devices_list(&devices, &n, err);
    if (s)
        return s;
    s = sheen_serial_device_choose(path, devices, n, err);
    free(devices);
    return s;
}

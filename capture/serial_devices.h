// SPDX-License-Identifier: Apache-2.0
// serial_devices.h - serial lines over USB, any of which may be a turntable.
#ifndef SHEEN_CAPTURE_SERIAL_DEVICES_H
#define SHEEN_CAPTURE_SERIAL_DEVICES_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

#define SHEEN_TURNTABLE_LINK "/dev/sheen/turntable"

enum { SHEEN_SERIAL_DEVICE_PATH = 256 };

typedef struct sheen_serial_device {
    char path[SHEEN_SERIAL_DEVICE_PATH];  // "/dev/ttyACM0": may be another one tomorrow
    char by_id[SHEEN_SERIAL_DEVICE_PATH]; // link of udev that stays with the device; "": none
    char name[128], serial[128];          // as its USB interface calls itself
    bool is_turntable;                    // /dev/sheen/turntable leads to it
    int vendor_id, product_id;
} sheen_serial_device;

// Sorted by path; free() the list. EIO, ENOMEM.
sheen_status sheen_serial_devices_list(sheen_serial_device **devices_out, size_t *n_out, sheen_err *err);
// The link where there is one, else the only device, by its lasting name. ENODEV: none; EDATA: several, which it names.
sheen_status sheen_serial_device_find(char path[SHEEN_SERIAL_DEVICE_PATH], sheen_err *err);
// The choice among these alone.
sheen_status sheen_serial_device_choose(char path[SHEEN_SERIAL_DEVICE_PATH],
                                        const sheen_serial_device *devices, size_t n, sheen_err *err);

#endif

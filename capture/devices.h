// SPDX-License-Identifier: Apache-2.0
// devices.h - the cameras of this machine: names that stay, where they are plugged in, what they can do.
#ifndef SHEEN_CAPTURE_DEVICES_H
#define SHEEN_CAPTURE_DEVICES_H

#include "capture/v4l2_controls.h"
#include "capture/v4l2_modes.h"

typedef struct sheen_device {
    char path[128];                // "/dev/video0": may be another one tomorrow
    char by_id[256], by_path[256]; // links of udev that stay with the camera, with the port; "": none
    char name[128];                // as the camera calls itself
    char serial[128];
    bool is_usb;
    int vendor_id, product_id; // of USB cameras
    int usb_bus, usb_address;
    char usb_port[32], usb_speed[24]; // "1-4.2", "480 Mbit/s"; "" where libusb cannot tell
    sheen_v4l2_mode *modes;
    size_t n_modes;
    sheen_v4l2_controls controls;
    sheen_status status; // whether it could be opened, with the reason
    char problem[256];
} sheen_device;

// Every node that captures video, sorted by path (nodes for metadata and outputs are left out; one that cannot be
// opened is listed with its reason). *devices_out is released by sheen_devices_release. EIO, ENOMEM.
sheen_status sheen_devices_list(sheen_device **devices_out, size_t *n_out, sheen_err *err);
void sheen_devices_release(sheen_device *devices, size_t n_devices);

// For the seam of v4l2_io.h, which see: a node's lasting name and identity by libudev, its arrival, and a reset by libusb.
void sheen_device_lasting_name(char *name, size_t size_bytes, const char *path);
// As the camera at the node calls itself; "" where that is not known.
void sheen_device_name(char *text, size_t size_bytes, const char *path);
void sheen_device_identity(char *text, size_t size_bytes, const char *path);
int sheen_device_await(const char *path, int wake_fd, int timeout_ms);
int sheen_device_reset(const char *identity);

// Opens d->path through the seam and fills in name, modes and controls. False: it is no camera's node for pictures.
bool sheen_device_ask(sheen_device *d, const sheen_v4l2_io *io);
// Fills in usb_port and usb_speed of devices that have a bus and an address.
void sheen_devices_find_ports(sheen_device *devices, size_t n_devices);

#endif

// SPDX-License-Identifier: Apache-2.0
// devices_usb.c - at which USB port a camera is, how fast the link is, and its reset, through libusb; the only file that
// includes it.
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <libusb-1.0/libusb.h>

#include "capture/devices.h"

static const char *speed_text(int speed)
{
    switch (speed) {
    case LIBUSB_SPEED_LOW:
        return "1.5 Mbit/s";
    case LIBUSB_SPEED_FULL:
        return "12 Mbit/s";
    case LIBUSB_SPEED_HIGH:
        return "480 Mbit/s";
    case LIBUSB_SPEED_SUPER:
        return "5 Gbit/s";
    case LIBUSB_SPEED_SUPER_PLUS:
        return "10 Gbit/s";
    default:
        return "";
    }
}

// "1-4.2": bus 1, port 4 of its root, port 2 of the hub there; as the kernel names it.
static void describe(sheen_device *d, libusb_device *usb)
{
    uint8_t ports[8];
    const int n = libusb_get_port_numbers(usb, ports, sizeof ports);
    size_t end = 0;
    for (int i = 0; i < n; i++) {
        const size_t room = sizeof d->usb_port - end;
        const int w = i ? snprintf(d->usb_port + end, room, ".%d", ports[i])
                        : snprintf(d->usb_port, room, "%d-%d", d->usb_bus, ports[i]);
        if (w < 0 || (size_t)w >= room)
            break;
        end += (size_t)w;
    }
    snprintf(d->usb_speed, sizeof d->usb_speed, "%s", speed_text(libusb_get_device_speed(usb)));
}

void sheen_devices_find_ports(sheen_device *devices, size_t n_devices)
{
    libusb_context *context = NULL;
    libusb_device **list = NULL;
    if (libusb_init(&context))
        return;
    const ssize_t n = libusb_get_device_list(context, &list);
    for (ssize_t i = 0; i < n; i++)
        for (size_t k = 0; k < n_devices; k++)
            if (devices[k].is_usb && libusb_get_bus_number(list[i]) == devices[k].usb_bus &&
                libusb_get_device_address(list[i]) == devices[k].usb_address)
                describe(&devices[k], list[i]);
    if (n >= 0)
        libusb_free_device_list(list, 1);
    libusb_exit(context);
}

static bool has_serial(libusb_device_handle *usb, const struct libusb_device_descriptor *d,
                       const char *serial)
{
    unsigned char text[128] = "";
    return !*serial ||
           (d->iSerialNumber &&
            libusb_get_string_descriptor_ascii(usb, d->iSerialNumber, text, sizeof text - 1) > 0 &&
            !strcmp((const char *)text, serial));
}

// Resets one device if it is the one that is meant. ENOENT: it is not.
static int reset_if(libusb_device *device, unsigned vendor, unsigned product, const char *serial)
{
    struct libusb_device_descriptor d;
    libusb_device_handle *usb = NULL;
    if (libusb_get_device_descriptor(device, &d) || d.idVendor != vendor || d.idProduct != product)
        return ENOENT;
    const int opened = libusb_open(device, &usb);
    if (opened)
        return opened == LIBUSB_ERROR_ACCESS ? EACCES : EIO;
    int code = ENOENT;
    if (has_serial(usb, &d, serial)) {
        const int r = libusb_reset_device(usb);
        // NOT_FOUND: the device came back as a new one, which has to be found anew: that is success here.
        code = !r || r == LIBUSB_ERROR_NOT_FOUND ? 0 : r == LIBUSB_ERROR_NO_DEVICE ? ENODEV : EIO;
    }
    libusb_close(usb);
    return code;
}

int sheen_device_reset(const char *identity)
{
    libusb_context *context = NULL;
    libusb_device **list = NULL;
    char *end;
    const unsigned long vendor = strtoul(identity, &end, 16);
    if (*end != ':')
        return ENOENT;
    const unsigned long product = strtoul(end + 1, &end, 16);
    const char *serial = *end == ' ' ? end + 1 : "";
    if (libusb_init(&context))
        return EIO;
    const ssize_t n = libusb_get_device_list(context, &list);
    int code = ENOENT;
    for (ssize_t i = 0; i < n && code == ENOENT; i++)
        code = reset_if(list[i], (unsigned)vendor, (unsigned)product, serial);
    if (n >= 0)
        libusb_free_device_list(list, 1);
    libusb_exit(context);
    return code;
}

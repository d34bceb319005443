// SPDX-License-Identifier: Apache-2.0
// hotplug.c - what libusb tells of devices that come and go: "arrived 1d6b:0104", "left 1d6b:0104", until it is killed.
#include <stdio.h>

#include <libusb-1.0/libusb.h>

static int LIBUSB_CALL tell(libusb_context *usb, libusb_device *device, libusb_hotplug_event event,
                            void *unused)
{
    struct libusb_device_descriptor d;
    (void)usb;
    (void)unused;
    if (!libusb_get_device_descriptor(device, &d))
        printf("%s %04x:%04x\n", event == LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED ? "arrived" : "left",
               (unsigned)d.idVendor, (unsigned)d.idProduct);
    fflush(stdout);
    return 0;
}

int main(void)
{
    libusb_context *usb;
    const int events = LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED | LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT;
    if (libusb_init(&usb) ||
        libusb_hotplug_register_callback(usb, events, 0, LIBUSB_HOTPLUG_MATCH_ANY, LIBUSB_HOTPLUG_MATCH_ANY,
                                         LIBUSB_HOTPLUG_MATCH_ANY, tell, NULL, NULL))
        return 1;
    while (!libusb_handle_events(usb))
        ;
    return 1;
}

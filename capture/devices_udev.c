// SPDX-License-Identifier: Apache-2.0
// devices_udev.c - finds video nodes, serial lines, their lasting names and their return through libudev; the only file
// that includes it.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <libudev.h>

#include "capture/devices.h"
#include "capture/serial_devices.h"
#include "capture/v4l2_camera.h"

static void copy_text(char *out, size_t size_bytes, const char *text)
{
    snprintf(out, size_bytes, "%s", text ? text : "");
}

static int number(const char *text, int base)
{
    return text ? (int)strtol(text, NULL, base) : 0;
}

static void read_links(sheen_device *d, struct udev_device *dev)
{
    struct udev_list_entry *e;
    udev_list_entry_foreach(e, udev_device_get_devlinks_list_entry(dev))
    {
        const char *link = udev_list_entry_get_name(e);
        if (!strncmp(link, "/dev/v4l/by-id/", 15))
            copy_text(d->by_id, sizeof d->by_id, link);
        else if (!strncmp(link, "/dev/v4l/by-path/", 17))
            copy_text(d->by_path, sizeof d->by_path, link);
    }
}

static void describe(sheen_device *d, struct udev_device *dev)
{
    *d = (sheen_device){0};
    copy_text(d->path, sizeof d->path, udev_device_get_devnode(dev));
    copy_text(d->name, sizeof d->name, udev_device_get_sysattr_value(dev, "name"));
    read_links(d, dev);
    // The parent belongs to dev.
    struct udev_device *usb = udev_device_get_parent_with_subsystem_devtype(dev, "usb", "usb_device");
    if (!usb)
        return;
    d->is_usb = true;
    d->vendor_id = number(udev_device_get_sysattr_value(usb, "idVendor"), 16);
    d->product_id = number(udev_device_get_sysattr_value(usb, "idProduct"), 16);
    d->usb_bus = number(udev_device_get_sysattr_value(usb, "busnum"), 10);
    d->usb_address = number(udev_device_get_sysattr_value(usb, "devnum"), 10);
    copy_text(d->serial, sizeof d->serial, udev_device_get_sysattr_value(usb, "serial"));
}

static int compare_paths(const void *a, const void *b)
{
    const sheen_device *d = a, *e = b;
    const size_t n = strlen(d->path), m = strlen(e->path);
    return n != m ? (n < m ? -1 : 1) : strcmp(d->path, e->path); // video2 before video10
}

typedef struct camera_list {
    sheen_device *devices;
    size_t n;
} camera_list;

static sheen_status collect_cameras(void *self, struct udev_enumerate *all, struct udev *udev, sheen_err *err)
{
    camera_list *list = self;
    struct udev_list_entry *e;
    udev_list_entry_foreach(e, udev_enumerate_get_list_entry(all))
    {
        struct udev_device *dev = udev_device_new_from_syspath(udev, udev_list_entry_get_name(e));
        if (!dev)
            continue; // gone meanwhile
        const char *node = udev_device_get_devnode(dev);
        if (node && !strncmp(node, "/dev/video", 10)) {
            sheen_device *grown = realloc(list->devices, (list->n + 1) * sizeof *grown);
            if (!grown) {
                udev_device_unref(dev);
                return sheen_fail_memory(err, (double)(list->n + 1) * sizeof *grown, "the list of cameras");
            }
            list->devices = grown;
            describe(&grown[list->n], dev);
            if (sheen_device_ask(&grown[list->n], &sheen_v4l2_kernel))
                list->n++;
        }
        udev_device_unref(dev);
    }
    return SHEEN_OK;
}

typedef sheen_status collector(void *list, struct udev_enumerate *all, struct udev *udev, sheen_err *err);

// Lets `collect` go through all devices of a subsystem.
static sheen_status enumerate(const char *subsystem, collector *collect, void *list, sheen_err *err)
{
    struct udev *udev = udev_new();
    struct udev_enumerate *all = udev ? udev_enumerate_new(udev) : NULL;
    sheen_status s = SHEEN_OK;
    if (!all || udev_enumerate_add_match_subsystem(all, subsystem) < 0 ||
        udev_enumerate_scan_devices(all) < 0)
        s = sheen_fail(err, SHEEN_EIO, "the list of devices cannot be read: is '/sys' mounted?");
    if (!s)
        s = collect(list, all, udev, err);
    udev_enumerate_unref(all);
    udev_unref(udev);
    return s;
}

sheen_status sheen_devices_list(sheen_device **devices_out, size_t *n_out, sheen_err *err)
{
    camera_list list = {0};
    *devices_out = NULL;
    *n_out = 0;
    const sheen_status s = enumerate("video4linux", collect_cameras, &list, err);
    if (s) {
        sheen_devices_release(list.devices, list.n);
        return s;
    }
    if (list.n) {
        qsort(list.devices, list.n, sizeof *list.devices, compare_paths);
        sheen_devices_find_ports(list.devices, list.n);
    }
    *devices_out = list.devices;
    *n_out = list.n;
    return SHEEN_OK;
}

typedef struct serial_list {
    sheen_serial_device *devices;
    size_t n;
} serial_list;

static void describe_serial(sheen_serial_device *d, struct udev_device *dev, struct udev_device *usb)
{
    struct udev_list_entry *e;
    *d = (sheen_serial_device){0};
    copy_text(d->path, sizeof d->path, udev_device_get_devnode(dev));
    udev_list_entry_foreach(e, udev_device_get_devlinks_list_entry(dev))
    {
        const char *link = udev_list_entry_get_name(e);
        if (!strncmp(link, "/dev/serial/by-id/", 18))
            copy_text(d->by_id, sizeof d->by_id, link);
        else if (!strcmp(link, SHEEN_TURNTABLE_LINK))
            d->is_turntable = true;
    }
    copy_text(d->name, sizeof d->name, udev_device_get_sysattr_value(usb, "product"));
    copy_text(d->serial, sizeof d->serial, udev_device_get_sysattr_value(usb, "serial"));
    d->vendor_id = number(udev_device_get_sysattr_value(usb, "idVendor"), 16);
    d->product_id = number(udev_device_get_sysattr_value(usb, "idProduct"), 16);
}

static sheen_status collect_serials(void *self, struct udev_enumerate *all, struct udev *udev, sheen_err *err)
{
    serial_list *list = self;
    struct udev_list_entry *e;
    udev_list_entry_foreach(e, udev_enumerate_get_list_entry(all))
    {
        struct udev_device *dev = udev_device_new_from_syspath(udev, udev_list_entry_get_name(e));
        struct udev_device *usb =
            dev ? udev_device_get_parent_with_subsystem_devtype(dev, "usb", "usb_device") : NULL;
        if (!usb || !udev_device_get_devnode(dev)) { // gone meanwhile, or soldered to the board
            udev_device_unref(dev);
            continue;
        }
        sheen_serial_device *grown = realloc(list->devices, (list->n + 1) * sizeof *grown);
        if (grown) {
            list->devices = grown;
            describe_serial(&grown[list->n++], dev, usb);
        }
        udev_device_unref(dev);
        if (!grown)
            return sheen_fail_memory(err, (double)(list->n + 1) * sizeof *grown, "the list of serial lines");
    }
    return SHEEN_OK;
}

static int compare_serials(const void *a, const void *b)
{
    return strcmp(((const sheen_serial_device *)a)->path, ((const sheen_serial_device *)b)->path);
}

sheen_status sheen_serial_devices_list(sheen_serial_device **devices_out, size_t *n_out, sheen_err *err)
{
    serial_list list = {0};
    *devices_out = NULL;
    *n_out = 0;
    const sheen_status s = enumerate("tty", collect_serials, &list, err);
    if (s) {
        free(list.devices);
        return s;
    }
    if (list.n)
        qsort(list.devices, list.n, sizeof *list.devices, compare_serials);
    *devices_out = list.devices;
    *n_out = list.n;
    return SHEEN_OK;
}

// The device behind a node or a link to it; NULL where there is none.
static struct udev_device *device_of(struct udev *udev, const char *path)
{
    struct stat st;
    return udev && !stat(path, &st) && S_ISCHR(st.st_mode)
               ? udev_device_new_from_devnum(udev, 'c', st.st_rdev)
               : NULL;
}

void sheen_device_lasting_name(char *name, size_t size_bytes, const char *path)
{
    name[0] = 0;
    if (!strncmp(path, "/dev/v4l/", 9)) {
        copy_text(name, size_bytes, path); // it is one
        return;
    }
    struct udev *udev = udev_new();
    struct udev_device *dev = device_of(udev, path);
    if (dev) {
        sheen_device d = {0};
        read_links(&d, dev);
        copy_text(name, size_bytes, d.by_id[0] ? d.by_id : d.by_path);
        udev_device_unref(dev);
    }
    udev_unref(udev);
}

void sheen_device_identity(char *text, size_t size_bytes, const char *path)
{
    text[0] = 0;
    struct udev *udev = udev_new();
    struct udev_device *dev = device_of(udev, path);
    struct udev_device *usb = dev ? udev_device_get_parent_with_subsystem_devtype(dev, "usb", "usb_device")
                                  : NULL;
    if (usb) {
        const char *vendor = udev_device_get_sysattr_value(usb, "idVendor");
        const char *product = udev_device_get_sysattr_value(usb, "idProduct");
        const char *serial = udev_device_get_sysattr_value(usb, "serial");
        snprintf(text, size_bytes, "%.4s:%.4s%s%.60s", vendor ? vendor : "", product ? product : "",
                 serial ? " " : "", serial ? serial : "");
    }
    if (dev)
        udev_device_unref(dev);
    udev_unref(udev);
}

void sheen_device_name(char *text, size_t size_bytes, const char *path)
{
    char device[128];
    int fd;
    struct udev *udev = udev_new();
    struct udev_device *dev = device_of(udev, path);
    const char *name = dev ? udev_device_get_sysattr_value(dev, "name") : NULL;
    snprintf(text, size_bytes, "%s", name ? name : "");
    if (dev)
        udev_device_unref(dev);
    udev_unref(udev);
    // A container may show the node alone; the driver knows the name, too.
    if (!text[0] && !sheen_v4l2_camera_open(&fd, device, &sheen_v4l2_kernel, path, NULL)) {
        sheen_v4l2_kernel.close(sheen_v4l2_kernel.self, fd);
        char *bus = strrchr(device, '('); // "Name (where it is plugged in)"
        if (bus && bus > device)
            bus[-1] = 0;
        snprintf(text, size_bytes, "%s", device);
    }
}

// udevd has made the links when it tells of a device; without udevd looking again does.
int sheen_device_await(const char *path, int wake_fd, int timeout_ms)
{
    if (!access(path, F_OK))
        return 1;
    struct udev *udev = udev_new();
    struct udev_monitor *m = udev ? udev_monitor_new_from_netlink(udev, "udev") : NULL;
    struct pollfd fds[2] = {{.fd = -1, .events = POLLIN}, {.fd = wake_fd, .events = POLLIN}};
    if (m && udev_monitor_filter_add_match_subsystem_devtype(m, "video4linux", NULL) >= 0 &&
        udev_monitor_enable_receiving(m) >= 0)
        fds[0].fd = udev_monitor_get_fd(m);
    if (access(path, F_OK)) // it may have come before the monitor was there
        poll(fds, 2, timeout_ms);
    udev_monitor_unref(m);
    udev_unref(udev);
    return !access(path, F_OK);
}

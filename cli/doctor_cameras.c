// SPDX-License-Identifier: Apache-2.0
// doctor_cameras.c - what may be wrong with cameras, by what they say of themselves.
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <linux/videodev2.h>

#include "cli/doctor.h"

void sheen_cli_found(sheen_cli_findings *f, sheen_cli_severity severity, const char *about, const char *fmt,
                     ...)
{
    sheen_cli_finding g = {.severity = severity};
    va_list args;
    va_start(args, fmt);
    vsnprintf(g.text, sizeof g.text, fmt, args); // NOLINT(clang-analyzer-valist.Uninitialized): va_start did
    va_end(args);
    if (f->n_findings == SHEEN_CLI_MAX_FINDINGS)
        return;
    snprintf(g.about, sizeof g.about, "%s", about);
    f->findings[f->n_findings++] = g;
    f->n_wrong += severity == SHEEN_CLI_WRONG;
}

static bool is_jpeg(const sheen_v4l2_mode *m)
{
    return m->fourcc == V4L2_PIX_FMT_MJPEG || m->fourcc == V4L2_PIX_FMT_JPEG;
}

static void check_modes(sheen_cli_findings *f, const sheen_device *d, const char *about)
{
    bool recorded = false, uncompressed = false;
    for (size_t i = 0; i < d->n_modes; i++) {
        recorded = recorded || d->modes[i].recorded;
        uncompressed = uncompressed || (d->modes[i].recorded && !is_jpeg(&d->modes[i]));
    }
    if (!recorded)
        sheen_cli_found(
            f, SHEEN_CLI_WRONG, about,
            "none of its formats can be recorded ('sheen devices' lists them): use another camera");
    else if (!uncompressed)
        sheen_cli_found(f, SHEEN_CLI_NOTE, about,
                        "it gives JPEG only: blocks and the maker's tone curve are in the pictures; measure "
                        "its response, "
                        "or use a camera with YUYV, NV12 or Bayer formats");
}

static void check_lock(sheen_cli_findings *f, const sheen_device *d, const char *about)
{
    const sheen_v4l2_control *mode = sheen_v4l2_controls_find(&d->controls, V4L2_CID_EXPOSURE_AUTO);
    const sheen_v4l2_control *time = sheen_v4l2_controls_find(&d->controls, V4L2_CID_EXPOSURE_ABSOLUTE);
    const sheen_v4l2_control *balance = sheen_v4l2_controls_find(&d->controls, V4L2_CID_AUTO_WHITE_BALANCE);
    if (!time && !sheen_v4l2_controls_find(&d->controls, V4L2_CID_EXPOSURE))
        sheen_cli_found(f, SHEEN_CLI_WRONG, about,
                        "it has no control of its exposure, so that it cannot be locked: use another camera "
                        "for measuring");
    else if (mode && (mode->min > V4L2_EXPOSURE_MANUAL || mode->read_only))
        sheen_cli_found(f, SHEEN_CLI_WRONG, about,
                        "its exposure cannot be made manual: use another camera for measuring");
    else
        sheen_cli_found(f, SHEEN_CLI_FINE, about,
                        "exposure can be fixed; whether it obeys is proven at the start of each capture");
    if (balance && balance->read_only)
        sheen_cli_found(f, SHEEN_CLI_WRONG, about,
                        "its white balance cannot be fixed: use another camera for measuring");
}

static void check_link(sheen_cli_findings *f, const sheen_device *d, const char *about)
{
    char node[64];
    if (!d->by_id[0] && !d->by_path[0])
        sheen_cli_found(f, SHEEN_CLI_NOTE, about,
                        "it has no lasting name under /dev/v4l: its number may be another one tomorrow; "
                        "udevd makes these "
                        "names");
    if (!d->is_usb)
        return;
    if (!strcmp(d->usb_speed, "12 Mbit/s") || !strcmp(d->usb_speed, "1.5 Mbit/s"))
        sheen_cli_found(f, SHEEN_CLI_WRONG, about,
                        "its USB link has fallen back to %s: another cable, another port, no hub between",
                        d->usb_speed);
    else if (!strcmp(d->usb_speed, "480 Mbit/s"))
        sheen_cli_found(
            f, SHEEN_CLI_NOTE, about,
            "USB 2 (480 Mbit/s): YUYV of 1280x720 at about 10 frames a second, and one camera for each "
            "controller");
    snprintf(node, sizeof node, "/dev/bus/usb/%03d/%03d", d->usb_bus, d->usb_address);
    if (access(node, W_OK))
        sheen_cli_found(f, SHEEN_CLI_NOTE, about,
                        "its raw USB node '%s' may not be written: a camera that hangs cannot be reset, and "
                        "you will be asked "
                        "to unplug it; sheen's udev rules give this right",
                        node);
}

void sheen_cli_check_cameras(sheen_cli_findings *f, const sheen_device *devices, size_t n_devices)
{
    for (size_t i = 0; i < n_devices; i++) {
        const sheen_device *d = &devices[i];
        char about[160];
        snprintf(about, sizeof about, "camera '%.100s'", d->path);
        if (d->status) {
            sheen_cli_found(f, SHEEN_CLI_WRONG, about, "%s", d->problem);
            continue;
        }
        check_modes(f, d, about);
        check_lock(f, d, about);
        check_link(f, d, about);
        size_t twin = 0;
        while (twin < i && (!d->by_id[0] || strcmp(d->by_id, devices[twin].by_id) != 0))
            twin++;
        if (twin < i)
            sheen_cli_found(f, SHEEN_CLI_NOTE, about,
                            "it has the same serial number as '%.100s': name both by /dev/v4l/by-path",
                            devices[twin].path);
    }
}

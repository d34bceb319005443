// SPDX-License-Identifier: Apache-2.0
// cmd_devices.c - sheen devices: cameras and turntables, how each is connected, what it can do.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "capture/devices.h"
#include "capture/libcamera_source.h"
#include "capture/serial_devices.h"
#include "cli/cli.h"
#include "cli/commands.h"
#include "cli/devices_json.h"

static void put_modes(sheen_json_writer *w, const sheen_device *d)
{
    sheen_json_open(w, "modes", '[');
    for (size_t i = 0; i < d->n_modes; i++) {
        const sheen_v4l2_mode *m = &d->modes[i];
        sheen_json_open(w, NULL, '{');
        sheen_json_put_string(w, "format", m->format);
        sheen_json_put_bool(w, "recorded", m->recorded);
        sheen_json_put_int(w, "width_px", m->width_px);
        sheen_json_put_int(w, "height_px", m->height_px);
        sheen_json_put_numbers(w, "rates_hz", m->rates_hz, (size_t)m->n_rates);
        sheen_json_close(w);
    }
    sheen_json_close(w);
}

static void put_controls(sheen_json_writer *w, const sheen_device *d)
{
    sheen_json_open(w, "controls", '[');
    for (size_t i = 0; i < d->controls.n_controls; i++) {
        const sheen_v4l2_control *c = &d->controls.controls[i];
        sheen_json_open(w, NULL, '{');
        sheen_json_put_int(w, "id", c->id);
        sheen_json_put_string(w, "name", c->name);
        sheen_json_put_int(w, "min", c->min);
        sheen_json_put_int(w, "max", c->max);
        sheen_json_put_int(w, "step", c->step);
        sheen_json_put_int(w, "default", c->fallback);
        if (c->has_value)
            sheen_json_put_int(w, "value", c->value);
        sheen_json_put_bool(w, "inactive", c->inactive);
        sheen_json_put_bool(w, "read_only", c->read_only);
        sheen_json_close(w);
    }
    sheen_json_close(w);
}

void sheen_cli_put_device(sheen_json_writer *w, const sheen_device *d)
{
    char usb_id[16];
    sheen_json_open(w, NULL, '{');
    sheen_json_put_string(w, "path", d->path);
    sheen_json_put_string(w, "name", d->name);
    sheen_json_put_string(w, "by_id", d->by_id[0] ? d->by_id : NULL);
    sheen_json_put_string(w, "by_path", d->by_path[0] ? d->by_path : NULL);
    snprintf(usb_id, sizeof usb_id, "%04x:%04x", (unsigned)d->vendor_id & 0xffff,
             (unsigned)d->product_id & 0xffff);
    sheen_json_put_string(w, "usb_id", d->is_usb ? usb_id : NULL);
    sheen_json_put_string(w, "usb_port", d->usb_port[0] ? d->usb_port : NULL);
    sheen_json_put_string(w, "usb_speed", d->usb_speed[0] ? d->usb_speed : NULL);
    sheen_json_put_string(w, "serial", d->serial[0] ? d->serial : NULL);
    sheen_json_put_string(w, "problem", d->status ? d->problem : NULL);
    put_modes(w, d);
    put_controls(w, d);
    sheen_json_close(w);
}

// "MJPG  1280x720 at 30, 15", one line a format and size.
static void say_mode(const sheen_cli *cli, const sheen_v4l2_mode *m)
{
    char rates[160] = "";
    for (int i = 0; i < m->n_rates; i++) {
        const size_t n = strlen(rates);
        snprintf(rates + n, sizeof rates - n, "%s%.4g", i ? ", " : " at ", m->rates_hz[i]);
    }
    sheen_cli_say(cli, "    %-7s %5dx%-5d%s%s", m->format, m->width_px, m->height_px, rates,
                  m->recorded ? "" : "   (not recorded)");
}

static void say_control(const sheen_cli *cli, const sheen_v4l2_control *c)
{
    char value[24] = "?";
    if (c->has_value)
        snprintf(value, sizeof value, "%ld", (long)c->value);
    sheen_cli_say(cli, "    0x%08lx %-32s %s  (%ld to %ld)%s", (unsigned long)c->id, c->name, value,
                  (long)c->min, (long)c->max,
                  c->read_only  ? ", fixed"
                  : c->inactive ? ", under an automatic"
                                : "");
}

static void say_device(const sheen_cli *cli, const sheen_device *d)
{
    sheen_cli_say(cli, "%s  %s", d->path, d->name);
    if (d->is_usb)
        sheen_cli_say(cli, "  USB %04x:%04x%s%s%s%s%s%s", (unsigned)d->vendor_id & 0xffff,
                      (unsigned)d->product_id & 0xffff, d->serial[0] ? ", serial " : "", d->serial,
                      d->usb_port[0] ? ", port " : "", d->usb_port, d->usb_speed[0] ? ", " : "",
                      d->usb_speed);
    if (d->by_id[0])
        sheen_cli_say(cli, "  %s", d->by_id);
    if (d->by_path[0])
        sheen_cli_say(cli, "  %s", d->by_path);
    if (d->status)
        sheen_cli_say(cli, "  %s", d->problem);
    if (d->n_modes)
        sheen_cli_say(cli, "  formats, sizes, frames a second:");
    for (size_t i = 0; i < d->n_modes; i++)
        say_mode(cli, &d->modes[i]);
    if (d->controls.n_controls)
        sheen_cli_say(cli, "  controls:");
    for (size_t i = 0; i < d->controls.n_controls; i++)
        say_control(cli, &d->controls.controls[i]);
}

#ifdef SHEEN_LIBCAMERA
// Cameras by libcamera's names: USB cameras, which V4L2 has too, and ones that V4L2 alone cannot run. A libcamera that
// does not start is no reason to hide the others.
static void list_libcamera(sheen_cli *cli)
{
    enum { MAX_NAMES = 16 };
    sheen_libcamera_name names[MAX_NAMES];
    sheen_err err;
    int n = 0;
    if (sheen_libcamera_list(names, MAX_NAMES, &n, &err))
        sheen_cli_warn(cli, "%s", err.msg);
    sheen_json_open(&cli->out, "libcamera", '[');
    for (int i = 0; i < n && i < MAX_NAMES; i++) {
        sheen_cli_say(cli, "libcamera:%d  %s", i, names[i].model);
        sheen_cli_say(cli, "  libcamera:%s", names[i].id);
        sheen_json_open(&cli->out, NULL, '{');
        sheen_json_put_string(&cli->out, "id", names[i].id);
        sheen_json_put_string(&cli->out, "name", names[i].model);
        sheen_json_close(&cli->out);
    }
    sheen_json_close(&cli->out);
}
#endif

// Serial lines over USB: any of them may be a turntable's controller, and nothing is sent to find out.
static sheen_status list_serial(sheen_cli *cli, sheen_err *err)
{
    sheen_serial_device *lines;
    size_t n;
    const sheen_status s = sheen_serial_devices_list(&lines, &n, err);
    if (s)
        return s;
    sheen_json_open(&cli->out, "serial", '[');
    for (size_t i = 0; i < n; i++) {
        const sheen_serial_device *d = &lines[i];
        char usb_id[16];
        snprintf(usb_id, sizeof usb_id, "%04x:%04x", (unsigned)d->vendor_id & 0xffff,
                 (unsigned)d->product_id & 0xffff);
        sheen_cli_say(cli, "%s  %s", d->path, d->is_turntable ? "the turntable" : "a serial line");
        sheen_cli_say(cli, "  USB %s%s%s%s%s", usb_id, *d->name ? ", " : "", d->name,
                      *d->serial ? ", serial " : "", d->serial);
        if (*d->by_id)
            sheen_cli_say(cli, "  %s", d->by_id);
        sheen_json_open(&cli->out, NULL, '{');
        sheen_json_put_string(&cli->out, "path", d->path);
        sheen_json_put_string(&cli->out, "by_id", *d->by_id ? d->by_id : NULL);
        sheen_json_put_string(&cli->out, "name", d->name);
        sheen_json_put_string(&cli->out, "serial", *d->serial ? d->serial : NULL);
        sheen_json_put_string(&cli->out, "usb_id", usb_id);
        sheen_json_put_bool(&cli->out, "turntable", d->is_turntable);
        sheen_json_close(&cli->out);
    }
    sheen_json_close(&cli->out);
    free(lines);
    return SHEEN_OK;
}

static sheen_status run(sheen_cli *cli, sheen_err *err)
{
    const sheen_option options[] = {{0}};
    sheen_device *devices;
    size_t n;
    sheen_status s = sheen_cli_parse(cli, options, 0, 0, err);
    if (s || cli->wants_help)
        return s;
    s = sheen_devices_list(&devices, &n, err);
    if (s)
        return s;
    sheen_json_open(&cli->out, "devices", '[');
    for (size_t i = 0; i < n; i++) {
        say_device(cli, &devices[i]);
        sheen_cli_put_device(&cli->out, &devices[i]);
    }
    sheen_json_close(&cli->out);
#ifdef SHEEN_LIBCAMERA
    list_libcamera(cli);
#endif
    if (!n)
        sheen_cli_say(cli,
                      "no camera was found: plug one in, or look whether its driver made a /dev/video node");
    sheen_devices_release(devices, n);
    return list_serial(cli, err);
}

const sheen_command sheen_cmd_devices = {
    .name = "devices",
    .synopsis = "[options]",
    .summary = "cameras and turntables, how each is connected",
    .about =
        "Lists the cameras that V4L2 knows. The number of /dev/videoN changes with the order of "
        "plugging in: the\n"
        "names under /dev/v4l/by-id stay with the camera, those under /dev/v4l/by-path with the port.\n"
        "Serial lines over USB follow: one of them may be a turntable's controller (docs/turntable.md).\n",
    .example = "  sheen devices\n"
               "  sheen devices --json\n",
    .run = run,
};

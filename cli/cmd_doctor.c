// SPDX-License-Identifier: Apache-2.0
// cmd_doctor.c - sheen doctor: what is wrong with this set-up, and a bundle for a bug report.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/utsname.h>
#include <unistd.h>

#include "base/session.h"
#include "cli/cli.h"
#include "cli/commands.h"
#include "cli/devices_json.h"
#include "cli/doctor.h"

static const char *const severities[] = {
    [SHEEN_CLI_FINE] = "fine", [SHEEN_CLI_NOTE] = "note", [SHEEN_CLI_WRONG] = "wrong"};

static void put_system(sheen_json_writer *w)
{
    struct utsname u;
    sheen_json_open(w, "system", '{');
    sheen_json_put_string(w, "sheen", SHEEN_VERSION);
    sheen_json_put_string(w, "compiler", __VERSION__);
    if (!uname(&u)) { // not its name in the network
        sheen_json_put_string(w, "kernel", u.release);
        sheen_json_put_string(w, "machine", u.machine);
    }
    sheen_json_put_int(w, "processors", sysconf(_SC_NPROCESSORS_ONLN));
    sheen_json_close(w);
}

static void put_findings(sheen_json_writer *w, const sheen_cli_findings *f)
{
    sheen_json_open(w, "findings", '[');
    for (size_t i = 0; i < f->n_findings; i++) {
        sheen_json_open(w, NULL, '{');
        sheen_json_put_string(w, "severity", severities[f->findings[i].severity]);
        sheen_json_put_string(w, "about", f->findings[i].about);
        sheen_json_put_string(w, "text", f->findings[i].text);
        sheen_json_close(w);
    }
    sheen_json_close(w);
}

static void put_all(sheen_json_writer *w, const sheen_cli_findings *f, const sheen_device *devices, size_t n)
{
    put_system(w);
    put_findings(w, f);
    sheen_json_open(w, "devices", '[');
    for (size_t i = 0; i < n; i++)
        sheen_cli_put_device(w, &devices[i]);
    sheen_json_close(w);
}

// No photographs, and nothing of the person but what the findings name.
static sheen_status write_bundle(const char *path, const sheen_cli_findings *f, const sheen_device *devices,
                                 size_t n, sheen_err *err)
{
    sheen_json_writer w = {0};
    sheen_json_open(&w, NULL, '{');
    sheen_json_put_string(&w, "schema", "sheen-doctor/1");
    put_all(&w, f, devices, n);
    sheen_json_close(&w);
    return sheen_json_save(&w, path, err);
}

static void say(sheen_cli *cli, const sheen_cli_findings *f)
{
    static const char *const marks[] = {"  fine ", "  note ", "! WRONG"};
    for (size_t i = 0; i < f->n_findings; i++)
        sheen_cli_say(cli, "%s  %s: %s", marks[f->findings[i].severity], f->findings[i].about,
                      f->findings[i].text);
    if (f->n_wrong)
        sheen_cli_say(cli, "%zu thing%s in the way", f->n_wrong, f->n_wrong == 1 ? " stands" : "s stand");
    else
        sheen_cli_say(cli, "nothing stands in the way");
}

static sheen_status examine(sheen_cli *cli, const char *bundle, sheen_cli_findings *f, sheen_err *err)
{
    sheen_device *devices = NULL;
    size_t n = 0;
    sheen_err e;
    const char *session = cli->n_args ? cli->args[0] : NULL;
    if (sheen_devices_list(&devices, &n, &e))
        sheen_cli_found(f, SHEEN_CLI_WRONG, "cameras", "%s", e.msg);
    sheen_cli_check_machine(f, "", n);
    sheen_cli_check_cameras(f, devices, n);
    sheen_cli_check_disk(f, session ? session : ".");
    if (session)
        sheen_cli_check_session(f, session);
    say(cli, f);
    put_all(&cli->out, f, devices, n);
    const sheen_status s = bundle ? write_bundle(bundle, f, devices, n, err) : SHEEN_OK;
    if (!s && bundle)
        sheen_cli_say(
            cli, "'%s' holds this and all that the cameras say, no pictures: add it to a bug report", bundle);
    sheen_devices_release(devices, n);
    return s;
}

static sheen_status run(sheen_cli *cli, sheen_err *err)
{
    const char *bundle = NULL;
    const sheen_option options[] = {
        {"bundle", 0, SHEEN_OPTION_TEXT, &bundle, "FILE", "write all of it as JSON, for a bug report", 0, 0},
        {0},
    };
    sheen_status s = sheen_cli_parse(cli, options, 0, 1, err);
    if (s || cli->wants_help)
        return s;
    sheen_cli_findings *f = calloc(1, sizeof *f);
    if (!f)
        return sheen_fail_memory(err, sizeof *f, "findings");
    s = examine(cli, bundle, f, err);
    cli->limit_missed = f->n_wrong > 0;
    free(f);
    return s;
}

const sheen_command sheen_cmd_doctor = {
    .name = "doctor",
    .synopsis = "[SESSION] [options]",
    .summary = "what is wrong with this set-up, and a bundle for a bug report",
    .about =
        "Looks at the cameras (rights, formats, whether they can be locked, USB link, lasting names), the\n"
        "machine (drivers, udev, programs in the way, memory), the disk (room, speed: 16 MB are written and\n"
        "removed in the folder of SESSION, or here), and SESSION (whether its frames are whole, what it "
        "lacks).\n"
        "Changes no setting. Exit code 3: something stands in the way.\n",
    .example = "  sheen doctor\n"
               "  sheen doctor penguin.session --bundle report.json\n",
    .run = run,
};

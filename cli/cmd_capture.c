// SPDX-License-Identifier: Apache-2.0
// cmd_capture.c - sheen capture: frames from a source into a session.
#include "capture/record.h"
#include "cli/cli.h"
#include "cli/commands.h"

typedef struct capture_args {
    const char *device, *role, *moving;
    int count;
    sheen_record_options o;
    sheen_moving moved;
} capture_args;

static sheen_status parse(sheen_cli *cli, capture_args *a, sheen_err *err)
{
    const sheen_option options[] = {
        {"device", 0, SHEEN_OPTION_TEXT, &a->device, "URI",
         "where frames come from: replay:SESSION plays a recorded\nsession, replay:SESSION?role=test its "
         "frames of one "
         "role",
         0, 0},
        {"count", 0, SHEEN_OPTION_INT, &a->count, "N", "stop after N frames (default: when the source ends)",
         1, 1e6},
        {"role", 0, SHEEN_OPTION_TEXT, &a->role, "ROLE",
         "record them as input, calibration or test\n(default: what the source says)", 0, 0},
        {"moving", 0, SHEEN_OPTION_TEXT, &a->moving, "WHAT",
         "of a new session: what moves between the frames,\ncamera (default) or object", 0, 0},
        {0},
    };
    sheen_status s = sheen_cli_parse(cli, options, 1, 1, err);
    if (s || cli->wants_help)
        return s;
    if (!a->device)
        return sheen_cli_usage(cli, err, "no source was named: give --device URI");
    if (a->role)
        s = sheen_role_from_name(&a->o.role, a->role, err);
    if (!s && a->moving)
        s = sheen_moving_from_name(&a->moved, a->moving, err);
    a->o.set_role = a->role != NULL;
    a->o.count = (size_t)a->count;
    return sheen_cli_option_status(cli, s);
}

static void report(sheen_cli *cli, const sheen_session *s, const sheen_record_report *r)
{
    sheen_cli_say(cli, "%zu frame%s recorded into '%s'%s", r->n_recorded, sheen_cli_plural(r->n_recorded),
                  s->path, r->n_present ? ", the others were there already" : "");
    sheen_json_put_string(&cli->out, "session", s->path);
    sheen_json_put_int(&cli->out, "recorded_frames", (long long)r->n_recorded);
    sheen_json_put_int(&cli->out, "present_frames", (long long)r->n_present);
}

static sheen_status run(sheen_cli *cli, sheen_err *err)
{
    capture_args a = {0};
    sheen_source *src = NULL;
    sheen_cli_session s = {0};
    sheen_record_report r = {0};
    sheen_status st = parse(cli, &a, err);
    if (st || cli->wants_help)
        return st;
    a.o.progress = sheen_cli_progress(cli);
    st = sheen_source_open(&src, a.device, err);
    if (!st)
        st = sheen_cli_session_create(&s, cli->args[0], a.moved, err);
    if (!st)
        st = sheen_record(&s.session, src, &a.o, &r, err);
    sheen_cli_clear_bar(cli);
    if (!st)
        report(cli, &s.session, &r);
    else if (r.n_recorded)
        sheen_cli_warn(cli, "%zu new frame%s recorded before that; the same command goes on from there",
                       r.n_recorded, r.n_recorded == 1 ? " was" : "s were");
    sheen_cli_session_close(&s, st != SHEEN_OK);
    sheen_source_close(&src);
    return st;
}

const sheen_command sheen_cmd_capture = {
    .name = "capture",
    .synopsis = "SESSION --device URI [options]",
    .summary = "frames from a camera or a recording into a session",
    .about =
        "Makes the session where there is none. Every frame is stored exactly as it was delivered, with a\n"
        "description beside it. A frame that the session has already is not recorded twice, so that an\n"
        "interrupted capture goes on where it was.\n",
    .example = "  sheen capture penguin.session --device replay:recorded.session\n",
    .run = run,
};

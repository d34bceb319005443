// SPDX-License-Identifier: Apache-2.0
// cmd_capture.c - sheen capture: frames from a source into a session.
#include <unistd.h>

#include "capture/record.h"
#include "cli/cli.h"
#include "cli/commands.h"
#include "cli/shutter.h"
#include "cli/white.h"

typedef struct capture_args {
    const char *device, *role, *moving;
    int count;
    sheen_record_options o;
    sheen_moving moved;
    bool by_hand; // a camera without --count: a frame for each Enter or SIGUSR1
} capture_args;

static sheen_status parse(sheen_cli *cli, capture_args *a, sheen_err *err)
{
    const sheen_option options[] = {
        {"device", 0, SHEEN_OPTION_TEXT, &a->device, "URI",
         "where frames come from: v4l2:/dev/videoN is a camera\n(options: "
         "v4l2:/dev/video0?format=MJPG&size=1280x720"
         "&rate=30\n&exposure_ms=20&mains=60&lock=off), replay:SESSION plays\na recorded session, "
         "replay:SESSION?role=test its frames of\none role",
         0, 0},
        {"count", 0, SHEEN_OPTION_INT, &a->count, "N",
         "stop after N frames (default: when the recording ends; of a\ncamera one is taken for each Enter or "
         "SIGUSR1, until q)",
         1, 1e6},
        {"patience", 0, SHEEN_OPTION_NUMBER, &a->o.patience_s, "S",
         "how long to wait for a camera that is unplugged or hangs to\nbe plugged in again (default 300)", 0,
         86400},
        {"role", 0, SHEEN_OPTION_TEXT, &a->role, "ROLE",
         "record them as input, calibration or test\n(default: what the source says)", 0, 0},
        {"moving", 0, SHEEN_OPTION_TEXT, &a->moving, "WHAT",
         "of a new session: what moves between the frames,\ncamera (default) or object", 0, 0},
        {0},
    };
    a->o.patience_s = 300;
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

// What a camera lost; nothing of a recording, which loses none.
static void report_counts(sheen_cli *cli, const sheen_source *src)
{
    sheen_source_counts c;
    if (!sheen_source_is_live(src))
        return;
    sheen_source_counters(&c, src);
    sheen_cli_say(cli,
                  "the camera delivered %lld good frames; %lld dropped, %lld flagged as damaged, %lld cut "
                  "short, %lld late, "
                  "%lld with other settings",
                  (long long)c.n_frames, (long long)c.n_dropped, (long long)c.n_flagged, (long long)c.n_short,
                  (long long)c.n_late, (long long)c.n_unlocked);
    sheen_json_open(&cli->out, "camera_frames", '{');
    sheen_json_put_int(&cli->out, "good", c.n_frames);
    sheen_json_put_int(&cli->out, "dropped", c.n_dropped);
    sheen_json_put_int(&cli->out, "flagged", c.n_flagged);
    sheen_json_put_int(&cli->out, "short", c.n_short);
    sheen_json_put_int(&cli->out, "late", c.n_late);
    sheen_json_put_int(&cli->out, "unlocked", c.n_unlocked);
    sheen_json_close(&cli->out);
}

static void report(sheen_cli *cli, const sheen_session *s, const sheen_record_report *r,
                   const sheen_cli_white *w)
{
    sheen_cli_say(cli, "%zu frame%s recorded into '%s'%s", r->n_recorded, sheen_cli_plural(r->n_recorded),
                  s->path, r->n_present ? ", the others were there already" : "");
    if (r->n_skipped)
        sheen_cli_warn(cli, "%zu frame%s passed over because the disk was slower than the camera",
                       r->n_skipped, r->n_skipped == 1 ? " was" : "s were");
    if (w->detector && w->n_unseen)
        sheen_cli_warn(cli,
                       "%zu of them did not show the board: whether the light changed there is not known",
                       w->n_unseen);
    sheen_json_put_string(&cli->out, "session", s->path);
    sheen_json_put_int(&cli->out, "recorded_frames", (long long)r->n_recorded);
    sheen_json_put_int(&cli->out, "present_frames", (long long)r->n_present);
    sheen_json_put_int(&cli->out, "skipped_frames", (long long)r->n_skipped);
    sheen_json_put_int(&cli->out, "recovered_stalls", r->n_recovered);
}

static void on_notice(void *self, const char *text)
{
    sheen_cli_clear_bar(self);
    sheen_cli_warn(self, "%s", text);
}

static sheen_status record(sheen_cli *cli, capture_args *a, sheen_session *s, sheen_source *src,
                           sheen_record_report *r, sheen_err *err)
{
    sheen_cli_white white = {0};
    a->o.progress = sheen_cli_progress(cli);
    a->by_hand = sheen_source_is_live(src) && !a->o.count;
    sheen_status st = sheen_source_is_live(src) ? sheen_cli_white_init(&white, s, err) : SHEEN_OK;
    if (st)
        return st;
    a->o.notice = on_notice;
    a->o.notice_self = cli;
    a->o.check = sheen_cli_white_check;
    a->o.check_self = &white;
    if (a->by_hand) {
        sheen_cli_shutter_open();
        a->o.policy.ask = sheen_cli_shutter_ask;
        sheen_cli_say(cli, "Enter takes a frame (kill -USR1 %ld, too), q ends", (long)getpid());
    }
    st = sheen_record(s, src, &a->o, r, err);
    sheen_cli_clear_bar(cli);
    if (st == SHEEN_ECANCEL && a->by_hand && r->n_recorded) // Ctrl-C ends it as q does
        st = SHEEN_OK;
    if (!st) {
        report(cli, s, r, &white);
        report_counts(cli, src);
    }
    sheen_cli_white_release(&white);
    return st;
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
    st = sheen_source_open(&src, a.device, err);
    if (!st)
        st = sheen_cli_session_create(&s, cli->args[0], a.moved, err);
    if (!st)
        st = record(cli, &a, &s.session, src, &r, err);
    sheen_cli_clear_bar(cli);
    if (st && r.n_recorded)
        sheen_cli_warn(cli, "%zu new frame%s recorded before that; the same command goes on from there",
                       r.n_recorded, r.n_recorded == 1 ? " was" : "s were");
    if (st && r.n_lost)
        sheen_cli_warn(cli, "%zu frame%s taken and could not be stored", r.n_lost,
                       r.n_lost == 1 ? " was" : "s were");
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
        "interrupted capture goes on where it was. A camera's automatics are switched off and its settings "
        "read\n"
        "back with each frame; docs/capture.md says how, and what a refusal means.\n",
    .example = "  sheen capture penguin.session --device v4l2:/dev/video0 --count 12\n"
               "  sheen capture penguin.session --device replay:recorded.session\n",
    .run = run,
};

// SPDX-License-Identifier: Apache-2.0
// cmd_capture.c - sheen capture: frames from a source into a session.
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "capture/record.h"
#include "capture/turn_steps.h"
#include "cli/choose.h"
#include "cli/cli.h"
#include "cli/commands.h"
#include "cli/hook.h"
#include "cli/shutter.h"
#include "cli/table_arg.h"
#include "cli/table_eye.h"
#include "cli/white.h"

typedef struct capture_args {
    const char *device, *role, *moving, *hook, *turntable, *turntable_file;
    int count, n_steps, n_rounds;
    bool choose; // --auto
    double spread_deg, max_blur_px, max_motion_px;
    sheen_record_options o;
    sheen_moving moved;
    bool by_hand; // a camera without --count: a frame for each Enter or SIGUSR1
} capture_args;

// One capture at work.
typedef struct capture_job {
    sheen_cli *cli;
    const capture_args *args;
    const sheen_session *session;
    sheen_cli_white white;
    sheen_cli_choose choose;
} capture_job;

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
        {"auto", 0, SHEEN_OPTION_FLAG, &a->choose, NULL,
         "of a camera in the hand: take a frame when the board is in\nview, the picture sharp and still and "
         "the "
         "viewpoint new;\nstop when the ring about the board is covered",
         0, 0},
        {"spread", 0, SHEEN_OPTION_NUMBER, &a->spread_deg, "DEG",
         "--auto: angle between viewpoints (default 15)", 1, 90},
        {"max-motion", 0, SHEEN_OPTION_NUMBER, &a->max_motion_px, "PX",
         "--auto: how far tags may move in 1/30 s (default 0.5)", 0.01, 100},
        {"max-blur", 0, SHEEN_OPTION_NUMBER, &a->max_blur_px, "PX",
         "--auto: how wide edges of tags may be, from 10 to 90 % of\ntheir step (default 3)", 0.5, 100},
        {"bracket", 0, SHEEN_OPTION_INT, &a->o.bracket, "N",
         "of a camera that stands still: put each frame together from\nN exposures, each four times as long "
         "as the "
         "one before",
         2, SHEEN_BRACKET_MAX},
        {"hook", 0, SHEEN_OPTION_TEXT, &a->hook, "CMD",
         "run CMD by the shell at each step, with ACTION (init,\ndownload, stop) and ARGUMENT (the frame's "
         "file) in its\nenvironment",
         0, 0},
        {"patience", 0, SHEEN_OPTION_NUMBER, &a->o.patience_s, "S",
         "how long to wait for a camera that is unplugged or hangs to\nbe plugged in again (default 300)", 0,
         86400},
        {"turntable", 0, SHEEN_OPTION_TEXT, &a->turntable, "DEV",
         "turn this table from frame to frame: a serial line, auto,\nor manual: (docs/turntable.md)", 0, 0},
        {"steps", 0, SHEEN_OPTION_INT, &a->n_steps, "N", "frames a turn (default: 24)", 3, 3600},
        {"rounds", 0, SHEEN_OPTION_INT, &a->n_rounds, "K",
         "turns, each with the camera at another height (default: 1)", 1, 9},
        {"turntable-file", 0, SHEEN_OPTION_TEXT, &a->turntable_file, "FILE",
         "what is known of it (default:\n~/.config/sheen/turntable.json)", 0, 0},
        {"role", 0, SHEEN_OPTION_TEXT, &a->role, "ROLE",
         "record them as input, calibration or test\n(default: what the source says)", 0, 0},
        {"moving", 0, SHEEN_OPTION_TEXT, &a->moving, "WHAT",
         "of a new session: what moves between the frames,\ncamera (default) or object", 0, 0},
        {0},
    };
    a->o.patience_s = 300;
    a->spread_deg = 15;
    a->max_motion_px = 0.5;
    a->max_blur_px = 3;
    a->n_steps = 24;
    a->n_rounds = 1;
    sheen_status s = sheen_cli_parse(cli, options, 1, 1, err);
    if (s || cli->wants_help)
        return s;
    if (!a->device)
        return sheen_cli_usage(cli, err, "no source was named: give --device URI");
    if (a->role)
        s = sheen_role_from_name(&a->o.role, a->role, err);
    if (!s && a->moving)
        s = sheen_moving_from_name(&a->moved, a->moving, err);
    if (!s && a->turntable && (a->count || a->moving))
        return sheen_cli_usage(cli, err,
                               "with --turntable the frames are counted by --steps and --rounds, and the "
                               "object moves: leave --count and --moving out");
    if (!s && a->turntable && (a->choose || a->hook))
        return sheen_cli_usage(cli, err, "a turntable decides itself when frames are taken: leave %s out",
                               a->choose ? "--auto" : "--hook");
    if (a->turntable)
        a->moved = SHEEN_MOVING_OBJECT;
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

// A frame is safe on the disk.
static sheen_status on_stored(void *self, const sheen_frame_info *f, sheen_err *err)
{
    const capture_job *job = self;
    char file[160], path[SHEEN_PATH_MAX], missing[120];
    if (job->args->choose) {
        sheen_cli_choose_missing(missing, &job->choose);
        sheen_cli_clear_bar(job->cli);
        sheen_cli_say(job->cli, "%s taken: %s", f->name, missing);
    }
    snprintf(file, sizeof file, SHEEN_SESSION_FRAMES "/%s", f->file);
    const sheen_status s = sheen_session_path(path, job->session, file, err);
    return s ? s : sheen_cli_hook(job->args->hook, "download", path, err);
}

static sheen_status ask_chooser(void *self, int64_t *since_ns, sheen_err *err)
{
    return sheen_cli_choose_ask(&((capture_job *)self)->choose, since_ns, err);
}

static sheen_status ask_chooser_to_look(void *self, sheen_frame *frame, sheen_verdict *verdict,
                                        sheen_err *err)
{
    return sheen_cli_choose_look(&((capture_job *)self)->choose, frame, verdict, err);
}

static sheen_status begin_choosing(capture_job *job, capture_args *a, sheen_err *err)
{
    job->choose = (sheen_cli_choose){.spread_rad = a->spread_deg * 0.017453292519943295,
                                     .max_motion_px = a->max_motion_px,
                                     .max_blur_px = a->max_blur_px,
                                     .hint = on_notice,
                                     .hint_self = job->cli};
    a->o.policy.ask = ask_chooser;
    a->o.policy.look = ask_chooser_to_look;
    return sheen_cli_choose_init(&job->choose, job->session, err);
}

// Who decides which frames are taken.
static sheen_status set_policy(capture_job *job, capture_args *a, const sheen_source *src, sheen_err *err)
{
    const bool live = sheen_source_is_live(src);
    if (a->turntable) // it has set its own
        return SHEEN_OK;
    a->by_hand = live && (a->choose || !a->o.count);
    a->o.policy.self = job;
    a->o.policy.stored = on_stored;
    if (a->by_hand) {
        sheen_cli_shutter_open();
        sheen_cli_say(job->cli, "Enter takes a frame (kill -USR1 %ld, too), q ends", (long)getpid());
    }
    if (a->choose)
        return begin_choosing(job, a, err);
    if (a->by_hand)
        a->o.policy.ask = sheen_cli_shutter_ask;
    return SHEEN_OK;
}

static sheen_status record(sheen_cli *cli, capture_args *a, sheen_session *s, sheen_source *src,
                           sheen_record_report *r, sheen_err *err)
{
    capture_job job = {.cli = cli, .args = a, .session = s};
    a->o.progress = sheen_cli_progress(cli);
    sheen_status st = sheen_source_is_live(src) ? sheen_cli_white_init(&job.white, s, err) : SHEEN_OK;
    a->o.notice = on_notice;
    a->o.notice_self = cli;
    a->o.check = sheen_cli_white_check;
    a->o.check_self = &job.white;
    if (!st)
        st = set_policy(&job, a, src, err);
    if (!st)
        st = sheen_cli_hook(a->hook, "init", s->path, err);
    if (!st)
        st = sheen_record(s, src, &a->o, r, err);
    sheen_cli_clear_bar(cli);
    if (st == SHEEN_ECANCEL && a->by_hand && r->n_recorded) // Ctrl-C ends it as q does
        st = SHEEN_OK;
    if (!st) {
        report(cli, s, r, &job.white);
        report_counts(cli, src);
        st = sheen_cli_hook(a->hook, "stop", s->path, err);
    }
    a->o.policy.self = a->o.check_self = NULL; // they were of this call
    sheen_cli_choose_release(&job.choose);
    sheen_cli_white_release(&job.white);
    return st;
}

// ---- by turntable

typedef struct turning {
    sheen_cli *cli;
    sheen_cli_eye eye;
} turning;

static sheen_status see(void *self, const sheen_frame *frame, const sheen_frame_info *reference,
                        double *angle_deg, sheen_err *err)
{
    return sheen_cli_eye_see(&((turning *)self)->eye, frame, reference, angle_deg, err);
}

static sheen_status next_round(void *self, int i_round, sheen_err *err)
{
    const turning *t = self;
    char line[16];
    sheen_cli_clear_bar(t->cli);
    fprintf(stderr, "round %d: put the camera at its next height, then press Enter ", i_round);
    return fgets(line, sizeof line, stdin) && !sheen_cli_interrupted()
               ? SHEEN_OK
               : sheen_fail(err, SHEEN_ECANCEL, "round %d was not begun", i_round);
}

// Turns and records what is missing of the rounds.
static sheen_status record_turns(sheen_cli *cli, capture_args *a, sheen_session *s, sheen_source *src,
                                 sheen_record_report *r, sheen_err *err)
{
    turning t = {.cli = cli};
    sheen_table *table = NULL;
    sheen_table_config config;
    sheen_turn_steps steps = {0};
    const bool by_hand = !strncmp(a->turntable, "manual:", 7);
    sheen_status st = sheen_cli_eye_init(&t.eye, s, err);
    const sheen_turn_options o = {.n_steps = a->n_steps,
                                  .n_rounds = a->n_rounds,
                                  .see = t.eye.detector ? see : NULL,
                                  .next_round = next_round,
                                  .self = &t,
                                  .tolerance_deg = by_hand ? 180.0 / a->n_steps : 0};
    if (!st && s->moving != SHEEN_MOVING_OBJECT)
        st = sheen_fail(err, SHEEN_EARG,
                        "'%s' is a session of a camera that moves: a turntable wants one of its own",
                        s->path);
    if (!st && !sheen_source_is_live(src))
        st = sheen_fail(err, SHEEN_EARG, "a turntable wants a camera: '%s' is none", a->device);
    if (!st && !t.eye.detector)
        sheen_cli_warn(
            cli,
            "'%s' has no camera model or no board: the angles are those commanded, and a broken turn "
            "cannot be gone on with",
            s->path);
    a->o.count = sheen_turn_steps_missing(s, &o);
    if (!st && !a->o.count)
        sheen_cli_say(cli, "all %d frames are there", a->n_steps * a->n_rounds);
    if (!st && a->o.count &&
        !(st = sheen_cli_table_open(&table, &config, cli, a->turntable, a->turntable_file, err)) &&
        !(st = sheen_turn_steps_init(&steps, s, table, &o, err))) {
        a->o.policy = sheen_turn_steps_policy(&steps);
        sheen_cli_say(cli, "Ctrl-C (or s and Enter) stops the turntable at once");
        st = record(cli, a, s, src, r, err);
    }
    sheen_turn_steps_release(&steps);
    sheen_table_close(&table);
    sheen_cli_eye_release(&t.eye);
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
        st = a.turntable ? record_turns(cli, &a, &s.session, src, &r, err)
                         : record(cli, &a, &s.session, src, &r, err);
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
               "  sheen capture penguin.session --device v4l2:/dev/video0 --auto --spread 15\n"
               "  sheen capture penguin.session --device v4l2:/dev/video0 --turntable auto --steps 24\n"
               "  sheen capture penguin.session --device replay:recorded.session\n",
    .run = run,
};

// SPDX-License-Identifier: Apache-2.0
// cmd_capture.c - sheen capture: frames from a source into a session, or objects one after the other into sessions.
#include <string.h>

#include "cli/capture_job.h"
#include "cli/commands.h"
#include "cli/stages.h"

// What cannot go together. free_count: --count or --moving is given.
static sheen_status check(sheen_cli *cli, sheen_cli_capture *a, bool free_count, sheen_err *err)
{
    if (!a->device)
        return sheen_cli_usage(cli, err, "no source was named: give --device URI");
    if (a->turntable && free_count)
        return sheen_cli_usage(cli, err,
                               "with --turntable the frames are counted by --steps and --rounds, and the "
                               "object moves: leave --count and --moving out");
    if (a->turntable && a->choose)
        return sheen_cli_usage(cli, err,
                               "a turntable decides itself when frames are taken: leave --auto out");
    if (a->choose && a->o.bracket)
        return sheen_cli_usage(
            cli, err,
            "--bracket wants a camera that stands still, --auto one in the hand: leave one of "
            "them out");
    const int n_measures = a->measure.dark + a->measure.flat + a->measure.response;
    if (n_measures > 1)
        return sheen_cli_usage(cli, err, "--dark, --flat and --response are measured one at a time");
    if (n_measures && (a->turntable || a->choose || a->o.count || a->hook || a->then_run))
        return sheen_cli_usage(cli, err,
                               "--dark, --flat and --response record no frames: leave --turntable, --auto, "
                               "--count, --hook and --then out");
    if (a->o.bracket && (a->measure.flat || a->measure.response))
        return sheen_cli_usage(cli, err, "only --dark is taken for each exposure of --bracket");
    if (a->background && !a->turntable)
        return sheen_cli_usage(cli, err, "--background is of a turntable: give --turntable DEV");
    if (a->background && a->batch)
        return sheen_cli_usage(
            cli, err,
            "--background asks for each object to be taken off and put on, --batch for one "
            "key between objects: leave one of them out");
    if (a->batch && !a->turntable)
        return sheen_cli_usage(cli, err, "--batch is of a turntable: give --turntable DEV");
    if (a->turntable)
        a->moved = SHEEN_MOVING_OBJECT;
    return SHEEN_OK;
}

// What has to be understood yet.
typedef struct words {
    const char *role, *moving, *then;
    int count;
} words;

static sheen_status take_words(sheen_cli *cli, sheen_cli_capture *a, const words *w, sheen_err *err)
{
    sheen_status s = SHEEN_OK;
    if (w->role)
        s = sheen_role_from_name(&a->o.role, w->role, err);
    if (!s && w->moving)
        s = sheen_moving_from_name(&a->moved, w->moving, err);
    if (s)
        return sheen_cli_option_status(cli, s);
    a->o.set_role = w->role != NULL;
    a->o.count = (size_t)w->count;
    a->then_run = w->then != NULL;
    if (w->then && strcmp(w->then, "run") != 0)
        return sheen_cli_usage(cli, err, "after a capture comes 'run', not '%.40s'", w->then);
    return check(cli, a, w->count || w->moving, err);
}

static sheen_status parse(sheen_cli *cli, sheen_cli_capture *a, sheen_err *err)
{
    words w = {0};
    const sheen_option options[] = {
        {"device", 0, SHEEN_OPTION_TEXT, &a->device, "URI",
         "where frames come from: a camera, v4l2:/dev/video0 (options:\n?format=MJPG&size=1280x720&rate=30"
         "&exposure_ms=20&mains=60\n&lock=off) or libcamera:0; replay:SESSION plays a recorded\n"
         "session, replay:SESSION?role=test its frames of one role",
         0, 0},
        {"count", 0, SHEEN_OPTION_INT, &w.count, "N",
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
         "of a camera that stands still: each frame from N exposures,\neach four times as long as the one "
         "before",
         2, SHEEN_BRACKET_MAX},
        {"remember", 0, SHEEN_OPTION_FLAG, &a->remember, NULL,
         "remember with this camera what URI says of its colours and\nexposures (nothing: forget it)", 0, 0},
        {"dark", 0, SHEEN_OPTION_FLAG, &a->measure.dark, NULL,
         "measure the camera instead: the lens is covered (with\n--bracket N: for each of its exposures)", 0,
         0},
        {"flat", 0, SHEEN_OPTION_FLAG, &a->measure.flat, NULL,
         "measure the camera instead: an even white fills the picture", 0, 0},
        {"response", 0, SHEEN_OPTION_FLAG, &a->measure.response, NULL,
         "measure the camera instead: its curve, from exposures of a\nscene that stands still", 0, 0},
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
        {"background", 0, SHEEN_OPTION_FLAG, &a->background, NULL,
         "begin with a frame of the table without the object: what\nhides what it shows is the object", 0, 0},
        {"turntable-file", 0, SHEEN_OPTION_TEXT, &a->turntable_file, "FILE",
         "what is known of it (default:\n~/.config/sheen/turntable.json)", 0, 0},
        {"batch", 0, SHEEN_OPTION_TEXT, &a->batch, "FILE",
         "by turntable: one object after the other, in sessions below\nthe folder SESSION. FILE is a table "
         "(CSV) with a column\nname, and code and mesh where wanted (docs/turntable.md)",
         0, 0},
        {"like", 0, SHEEN_OPTION_TEXT, &a->like, "OTHER",
         "take camera model, what was measured of the camera, its\nsettings, board and mesh from that "
         "session",
         0, 0},
        {"then", 0, SHEEN_OPTION_TEXT, &w.then, "run",
         "after it the model, as 'sheen run' makes it; of a batch,\nof all objects that are complete", 0, 0},
        {"role", 0, SHEEN_OPTION_TEXT, &w.role, "ROLE",
         "record them as input, calibration, test or background\n(default: what the source says)", 0, 0},
        {"moving", 0, SHEEN_OPTION_TEXT, &w.moving, "WHAT",
         "of a new session: what moves between the frames,\ncamera (default) or object", 0, 0},
        {0},
    };
    sheen_status s = sheen_cli_parse(cli, options, 1, 1, err);
    if (s || cli->wants_help)
        return s;
    return take_words(cli, a, &w, err);
}

static sheen_status run(sheen_cli *cli, sheen_err *err)
{
    sheen_cli_capture a = {.n_steps = 24,
                           .n_rounds = 1,
                           .spread_deg = 15,
                           .max_motion_px = 0.5,
                           .max_blur_px = 3,
                           .o.patience_s = 300};
    sheen_status st = parse(cli, &a, err);
    if (st || cli->wants_help)
        return st;
    if (a.batch)
        return sheen_cli_capture_batch(cli, &a, cli->args[0], err);
    st = sheen_cli_capture_session(cli, &a, cli->args[0], err);
    if (st || !a.then_run)
        return st;
    const sheen_cli_run_options o = {0};
    st = sheen_cli_run_stages(cli, cli->args[0], &o, err);
    return st ? sheen_wrap(err, st, "the capture is complete, but no model was made of it") : st;
}

const sheen_command sheen_cmd_capture = {
    .name = "capture",
    .synopsis = "SESSION|FOLDER --device URI [options]",
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
               "  sheen capture today --batch today.csv --like station.session --device v4l2:/dev/video0 \\\n"
               "      --turntable auto --steps 24 --then run\n"
               "  sheen capture penguin.session --device replay:recorded.session\n",
    .run = run,
};

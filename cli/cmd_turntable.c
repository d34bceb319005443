// SPDX-License-Identifier: Apache-2.0
// cmd_turntable.c - sheen turntable: what it says, a turn by hand, and its set-up by the camera.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/clock.h"
#include "cli/camera_open.h"
#include "cli/commands.h"
#include "cli/keys.h"
#include "cli/table_arg.h"
#include "cli/table_eye.h"
#include "cli/table_setup.h"

enum { MAX_OLD = 12, MAX_FRAMES = 200 };

typedef struct turntable_args {
    const char *device, *file, *setup, *camera;
    double move_deg;
    bool home, unlock;
} turntable_args;

static sheen_status parse(sheen_cli *cli, turntable_args *a, sheen_err *err)
{
    const sheen_option options[] = {
        {"device", 0, SHEEN_OPTION_TEXT, &a->device, "DEV",
         "the controller's serial line, or auto (default): the link\n/dev/sheen/turntable, else the only one "
         "there is",
         0, 0},
        {"file", 0, SHEEN_OPTION_TEXT, &a->file, "FILE",
         "what is known of it (default:\n~/.config/sheen/turntable.json)", 0, 0},
        {"move", 0, SHEEN_OPTION_NUMBER, &a->move_deg, "DEG", "turn by so much, counter-clockwise", -36000,
         36000},
        {"home", 0, SHEEN_OPTION_FLAG, &a->home, NULL, "run the controller's homing", 0, 0},
        {"unlock", 0, SHEEN_OPTION_FLAG, &a->unlock, NULL, "end an alarm where it stands", 0, 0},
        {"setup", 0, SHEEN_OPTION_TEXT, &a->setup, "SESSION",
         "measure degrees a unit, direction, play and axis from the\nboard on the table, with this session's "
         "camera "
         "model and\nboard, and write the file",
         0, 0},
        {"camera", 0, SHEEN_OPTION_TEXT, &a->camera, "URI",
         "of --setup: where frames come from (v4l2:/dev/videoN)", 0, 0},
        {0},
    };
    a->move_deg = (double)NAN;
    a->device = "auto";
    const sheen_status s = sheen_cli_parse(cli, options, 0, 0, err);
    if (s || cli->wants_help)
        return s;
    if (!a->setup != !a->camera)
        return sheen_cli_usage(cli, err, "--setup SESSION and --camera URI belong together");
    if (isfinite(a->move_deg) + a->home + a->unlock + (a->setup != NULL) > 1)
        return sheen_cli_usage(cli, err, "one thing at a time: --move, --home, --unlock or --setup");
    return SHEEN_OK;
}

static sheen_status say_state(sheen_cli *cli, sheen_table *table, sheen_err *err)
{
    sheen_table_state now;
    const sheen_status s = sheen_table_get(&now, table, err);
    if (s)
        return s;
    sheen_cli_say(cli, "%s: %s; the controller counts %.3f degrees", now.controller, now.what,
                  now.position_deg);
    sheen_json_put_string(&cli->out, "controller", now.controller);
    sheen_json_put_string(&cli->out, "state", now.what);
    sheen_json_put_bool(&cli->out, "ready", now.ready);
    sheen_json_put_number(&cli->out, "position_deg", now.position_deg);
    return SHEEN_OK;
}

// ---- set-up

typedef struct watcher {
    sheen_source *src;
    sheen_cli_eye eye;
} watcher;

// The board at rest: two frames in a row, both exposed after the table stood, show the same pose.
static sheen_status observe(void *self, sheen_turntable_pose *pose, sheen_err *err)
{
    static const double same_deg = 0.02;
    watcher *w = self;
    sheen_board_pose now, before = {0};
    const int64_t since_ns = sheen_clock_ns();
    int n_old = 0, n_seen = 0;
    for (int i = 0; i < MAX_FRAMES; i++) {
        sheen_frame frame;
        sheen_status s = sheen_source_next(w->src, 5000, &frame, err);
        if (s)
            return s;
        if (sheen_cli_interrupted())
            return sheen_fail(err, SHEEN_ECANCEL, "stopped");
        if (frame.info.t_ns < 0 ? n_old++ < MAX_OLD : frame.info.t_ns < since_ns)
            continue;
        if ((s = sheen_cli_eye_pose(&now, &w->eye, &frame, err)))
            return s;
        if (n_seen++ && fabs(sheen_cli_eye_turn_deg(before.rt_cam_board, now.rt_cam_board)) < same_deg) {
            memcpy(pose->rt_cam_board, now.rt_cam_board, sizeof pose->rt_cam_board);
            memcpy(pose->covariance, now.covariance, sizeof pose->covariance);
            return SHEEN_OK;
        }
        before = now;
    }
    return sheen_fail(err, SHEEN_EDATA, "the board does not come to rest although the turntable stands");
}

static void say_setup(sheen_cli *cli, const sheen_cli_setup_result *r, const char *path)
{
    const sheen_table_config *c = &r->config;
    sheen_cli_say(
        cli,
        "%.5f degrees a unit (known to %.4f %%), %s; play %.3f degrees; steps %.3f degrees rms beside "
        "the command (worst %.3f); axis known to %.4f degrees\nwritten to '%s'",
        c->degrees_per_unit, 100 * r->sigma_share,
        c->direction > 0 ? "counter-clockwise" : "its numbers grow clockwise", c->backlash_deg, r->rms_deg,
        r->worst_deg, r->sigma_axis_deg, path);
    sheen_json_put_number(&cli->out, "degrees_per_unit", c->degrees_per_unit);
    sheen_json_put_number(&cli->out, "degrees_per_unit_sigma_share", r->sigma_share);
    sheen_json_put_int(&cli->out, "direction", c->direction);
    sheen_json_put_number(&cli->out, "backlash_deg", c->backlash_deg);
    sheen_json_put_number(&cli->out, "rms_deg", r->rms_deg);
    sheen_json_put_number(&cli->out, "worst_deg", r->worst_deg);
    sheen_json_put_numbers(&cli->out, "axis_board", c->axis_board, 6);
    sheen_json_put_string(&cli->out, "file", path);
}

// The file's folder may not be there yet.
static sheen_status write_file(const sheen_table_config *c, const char *path, sheen_err *err)
{
    char dir[SHEEN_PATH_MAX];
    const size_t n = (size_t)(sheen_path_base(path) - path);
    snprintf(dir, sizeof dir, "%.*s", (int)(n ? n - 1 : 0), path);
    const sheen_status s = n > 1 ? sheen_dir_make(dir, err) : SHEEN_OK;
    return s ? s : sheen_table_config_save(c, path, err);
}

static sheen_status set_up(sheen_cli *cli, const turntable_args *a, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    sheen_session s = {0};
    watcher w = {0};
    sheen_table *table = NULL;
    sheen_table_config config;
    sheen_cli_setup_result result;
    sheen_status st = sheen_cli_table_path(path, a->file, err);
    if (st || (st = sheen_session_open(&s, a->setup, err)))
        return st;
    if ((st = sheen_cli_eye_init(&w.eye, &s, err)))
        goto done;
    if (!w.eye.detector) {
        st = sheen_fail(
            err, SHEEN_EDATA,
            "'%s' has no camera or no board: import both ('sheen import %s --camera FILE --board FILE')",
            s.path, s.path);
        goto done;
    }
    if ((st = sheen_cli_camera_open(cli, &w.src, a->camera, false, err)) ||
        (st = sheen_cli_table_open_plain(&table, &config, cli, a->device, a->file, err)))
        goto done;
    const sheen_cli_setup setup = {observe, &w};
    if (!(st = sheen_cli_table_setup(&result, table, &config, &setup, err)) &&
        !(st = write_file(&result.config, path, err)))
        say_setup(cli, &result, path);

done:
    sheen_table_close(&table);
    sheen_source_close(&w.src);
    sheen_cli_eye_release(&w.eye);
    sheen_session_release(&s);
    return st;
}

static sheen_status act(sheen_cli *cli, const turntable_args *a, sheen_table *table, sheen_err *err)
{
    sheen_status s = SHEEN_OK;
    if (a->unlock)
        s = sheen_table_unlock(table, err);
    else if (a->home)
        s = sheen_table_home(table, err);
    else if (isfinite(a->move_deg) && !(s = sheen_table_set_angle(table, 0, err)))
        s = sheen_table_turn_to(table, a->move_deg, err);
    return s ? s : say_state(cli, table, err);
}

static sheen_status run(sheen_cli *cli, sheen_err *err)
{
    turntable_args a = {0};
    sheen_table *table = NULL;
    sheen_table_config config;
    sheen_status s = parse(cli, &a, err);
    if (s || cli->wants_help)
        return s;
    sheen_cli_keys_open();
    if (a.setup)
        s = set_up(cli, &a, err);
    else if (!(s = sheen_cli_table_open(&table, &config, cli, a.device, a.file, err)))
        s = act(cli, &a, table, err);
    sheen_table_close(&table);
    sheen_cli_keys_close();
    return s;
}

const sheen_command sheen_cmd_turntable = {
    .name = "turntable",
    .synopsis = "[options]",
    .summary = "a motor turntable: its state, a turn, its set-up",
    .about = "Without options it says what the controller says; nothing moves. Ctrl-C, or the key s, "
             "stops a turn at\n"
             "once. docs/turntable.md says which controllers, and what each refusal means.\n",
    .example = "  sheen turntable --move 30\n"
               "  sheen turntable --setup penguin.session --camera v4l2:/dev/video0\n",
    .run = run,
};

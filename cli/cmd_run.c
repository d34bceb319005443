// SPDX-License-Identifier: Apache-2.0
// cmd_run.c - sheen run: every stage whose result is missing or was made from other inputs, in order.
#include <stdio.h>
#include <string.h>

#include "base/json_write.h"
#include "calib/calibrate_session.h"
#include "cli/cli.h"
#include "cli/commands.h"
#include "cli/stages.h"
#include "pose/pose_session.h"

#define FILM SHEEN_SESSION_RENDERS "/orbit.mp4"
#define RENDERS SHEEN_SESSION_RENDERS "/renders.json"

// One run on its way.
typedef struct run_state {
    sheen_cli *cli;
    sheen_session s;
    sheen_cli_run_options args;
    sheen_progress progress;
} run_state;

// Why a stage need not run; NULL: it must.
typedef const char *why_not(const run_state *r);
// Runs it and says the result.
typedef sheen_status stage_run(run_state *r, sheen_err *err);

// ---- calibrate

// True where a file of the session is JSON in which this member is true.
static bool is_imported(const sheen_session *s, const char *file)
{
    char path[SHEEN_PATH_MAX];
    sheen_json *root = NULL;
    bool imported = false;
    if (sheen_session_path(path, s, file, NULL) || !sheen_file_exists(path) ||
        sheen_json_load(&root, path, NULL))
        return false;
    if (sheen_json_bool(root, "imported", &imported, NULL))
        imported = false;
    sheen_json_free(&root);
    return imported;
}

static const char *why_not_calibrate(const run_state *r)
{
    if (!sheen_session_has(&r->s, SHEEN_SESSION_CAMERA))
        return NULL;
    if (!sheen_session_has(&r->s, SHEEN_SESSION_CALIBRATION) || is_imported(&r->s, SHEEN_SESSION_CALIBRATION))
        return "the camera was given";
    return sheen_calibration_is_current(&r->s) ? "the camera is current" : NULL;
}

static sheen_status run_calibrate(run_state *r, sheen_err *err)
{
    sheen_calibration c;
    const sheen_calibrate_options o = {.progress = r->progress, .n_threads = r->args.n_threads};
    const sheen_status st = sheen_calibrate_session(&c, &r->s, &o, err);
    if (st)
        return st;
    sheen_cli_clear_bar(r->cli);
    sheen_cli_say_calibration(r->cli, &c);
    sheen_calibration_release(&c);
    return SHEEN_OK;
}

// ---- pose

static const char *why_not_pose(const run_state *r)
{
    char path[SHEEN_PATH_MAX];
    sheen_json *root = NULL;
    if (is_imported(&r->s, SHEEN_SESSION_POSES))
        return "the poses were given";
    if (sheen_session_path(path, &r->s, SHEEN_SESSION_POSES, NULL) || sheen_json_load(&root, path, NULL))
        return NULL;
    const bool current = sheen_stamp_is_current(root, &r->s, sheen_poses_inputs);
    sheen_json_free(&root);
    return current ? "the poses are current" : NULL;
}

static sheen_status run_pose(run_state *r, sheen_err *err)
{
    sheen_pose_summary summary;
    sheen_poses poses = {0};
    const sheen_pose_options o = {.progress = r->progress, .n_threads = r->args.n_threads};
    const sheen_status st = sheen_pose_session(&summary, &poses, &r->s, &o, err);
    sheen_cli_clear_bar(r->cli);
    if (!st)
        sheen_cli_say_poses(r->cli, &summary, &poses);
    if (!st)
        sheen_cli_check_camera(r->cli, &r->s, summary.rms_median_px);
    sheen_poses_release(&poses);
    return st;
}

// ---- fit

static const char *why_not_fit(const run_state *r)
{
    return sheen_fit_is_current(&r->s) ? "the model is current" : NULL;
}

// Lights that stand still neither to the camera nor to the object cannot be fitted. Who knows better asks for the fit itself.
static sheen_status refuse_both_moved(run_state *r, sheen_err *err)
{
    sheen_poses poses = {0};
    bool both = false;
    if (is_imported(&r->s, SHEEN_SESSION_POSES) || !sheen_session_has(&r->s, SHEEN_SESSION_BOARD))
        return SHEEN_OK;
    sheen_status st = sheen_poses_load(&poses, &r->s, err);
    if (!st)
        st = sheen_cli_check_moved(r->cli, &r->s, &poses, &both, err);
    sheen_poses_release(&poses);
    if (!st && both)
        st = sheen_fail(
            err, SHEEN_EDATA,
            "camera and object both moved in '%s': it is not fitted ('sheen fit %s' does so all the same)",
            r->s.path, r->s.path);
    return st;
}

static sheen_status run_fit(run_state *r, sheen_err *err)
{
    sheen_fit_summary summary;
    const sheen_paper_options o = {.progress = r->progress, .n_threads = r->args.n_threads};
    sheen_status st = refuse_both_moved(r, err);
    if (st)
        return st;
    st = sheen_fit_session(&summary, &r->s, SHEEN_FIT_REFINED, &o, err);
    sheen_cli_clear_bar(r->cli);
    if (!st)
        sheen_cli_say_fit(r->cli, &summary);
    sheen_fit_summary_release(&summary);
    return st;
}

// ---- eval

static const char *why_not_eval(const run_state *r)
{
    if (!sheen_session_count_role(&r->s, SHEEN_ROLE_TEST))
        return "there are no test frames";
    return sheen_evaluation_is_current(&r->s) ? "the evaluation is current" : NULL;
}

static sheen_status run_eval(run_state *r, sheen_err *err)
{
    sheen_evaluation e = {0};
    const sheen_evaluate_session_options o = {
        .fit = {.progress = r->progress, .n_threads = r->args.n_threads}};
    sheen_status st = sheen_evaluate_session(&e, &r->s, &o, err);
    sheen_cli_clear_bar(r->cli);
    if (!st)
        st = sheen_cli_say_evaluation(r->cli, &e, err);
    sheen_evaluation_release(&e);
    return st;
}

// ---- film

static void film_inputs(const char *inputs[5], const sheen_session *s)
{
    inputs[0] = SHEEN_SESSION_MODEL "/model.json";
    inputs[1] = SHEEN_SESSION_REGISTRATION;
    inputs[2] = SHEEN_SESSION_CAMERA;
    inputs[3] = sheen_session_mesh_file(s);
    inputs[4] = NULL;
}

static const char *why_not_film(const run_state *r)
{
    char path[SHEEN_PATH_MAX];
    const char *inputs[5];
    sheen_json *root = NULL;
    if (r->args.no_film)
        return "not asked for";
    if (!sheen_session_has(&r->s, FILM) || sheen_session_path(path, &r->s, RENDERS, NULL) ||
        sheen_json_load(&root, path, NULL))
        return NULL;
    film_inputs(inputs, &r->s);
    const bool current = sheen_stamp_is_current(root, &r->s, inputs);
    sheen_json_free(&root);
    return current ? "the film is current" : NULL;
}

static sheen_status stamp_film(const sheen_session *s, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    const char *inputs[5];
    sheen_json_writer w = {0};
    film_inputs(inputs, s);
    sheen_json_open(&w, NULL, '{');
    sheen_json_put_string(&w, "schema", "sheen-renders/1");
    sheen_json_put_string(&w, "orbit", "orbit.mp4");
    sheen_status st = sheen_stamp_write(&w, s, inputs, err);
    if (!st)
        st = sheen_session_path(path, s, RENDERS, err);
    sheen_json_close(&w);
    if (!st)
        return sheen_json_save(&w, path, err);
    sheen_json_writer_release(&w);
    return st;
}

static sheen_status run_film(run_state *r, sheen_err *err)
{
    enum { WIDTH_PX = 640 };
    char dir[SHEEN_PATH_MAX], path[SHEEN_PATH_MAX];
    sheen_cli_view v;
    sheen_status st = sheen_session_path(dir, &r->s, SHEEN_SESSION_RENDERS, err);
    if (!st)
        st = sheen_dir_make(dir, err);
    if (!st)
        st = sheen_session_path(path, &r->s, FILM, err);
    if (!st)
        st = sheen_cli_view_open(&v, &r->s, err);
    if (st)
        return st;
    v.options.n_threads = r->args.n_threads;
    v.options.mark_holes = 0;
    const sheen_cli_changes filled = {.k_s_factor = 1, .tint_rgb = {1, 1, 1}, .fill_holes = true};
    st = sheen_cli_view_change(&v, &filled, err);
    sheen_cli_orbit o = {.size_px = {r->args.film_size_px[0], r->args.film_size_px[1]},
                         .elevation_deg = 25,
                         .duration_s = 4,
                         .frames_per_s = 25};
    if (!o.size_px[0]) {
        o.size_px[0] = WIDTH_PX;
        o.size_px[1] = (int)((double)WIDTH_PX * v.camera.height_px / v.camera.width_px + 0.5);
    }
    if (!st)
        st = sheen_cli_orbit_film(&v, path, &o, &r->progress, err);
    sheen_cli_view_close(&v);
    return st ? st : stamp_film(&r->s, err);
}

// ---- all of them

static const struct stage {
    const char *name;
    why_not *why_not;
    stage_run *run;
    bool may_lack; // goes without where this machine cannot (EUNSUP)
} stages[] = {
    {"calibrate", why_not_calibrate, run_calibrate, false},
    {"pose", why_not_pose, run_pose, false},
    {"fit", why_not_fit, run_fit, false},
    {"eval", why_not_eval, run_eval, false},
    {"film", why_not_film, run_film, true},
};

static sheen_status run_stage(run_state *r, const struct stage *stage, sheen_err *err)
{
    sheen_cli *cli = r->cli;
    const char *why = stage->why_not(r);
    sheen_json_open(&cli->out, stage->name, '{');
    sheen_json_put_bool(&cli->out, "ran", !why);
    sheen_status st = SHEEN_OK;
    if (why) {
        sheen_cli_say(cli, "%s: nothing to do: %s", stage->name, why);
        sheen_json_put_string(&cli->out, "why", why);
    } else {
        sheen_cli_say(cli, "%s:", stage->name);
        const sheen_stopwatch start = sheen_stopwatch_now();
        cli->stage = stage->name;
        st = stage->run(r, err);
        cli->stage = "";
        const sheen_stopwatch end = sheen_stopwatch_now();
        sheen_cli_add_timing(cli, stage->name, end.wall_s - start.wall_s, end.cpu_s - start.cpu_s);
    }
    if (st == SHEEN_EUNSUP && stage->may_lack) {
        sheen_cli_warn(cli, "%s left out: %s", stage->name, err->msg);
        st = SHEEN_OK;
    }
    sheen_json_close(&cli->out);
    return st;
}

// Names one thing that is there to look at.
static void say_made(run_state *r, const char *what, const char *file)
{
    char path[SHEEN_PATH_MAX];
    if (!sheen_session_has(&r->s, file) || sheen_session_path(path, &r->s, file, NULL))
        return;
    sheen_cli_say(r->cli, "%-14s %s", what, path);
    sheen_json_put_string(&r->cli->out, what, path);
}

static void say_all_made(run_state *r)
{
    sheen_json_open(&r->cli->out, "made", '{');
    sheen_cli_say(r->cli, "\nmade:");
    say_made(r, "film", FILM);
    for (size_t i = 0; i < r->s.n_frames; i++) {
        char file[120];
        if (r->s.frames[i].role != SHEEN_ROLE_TEST)
            continue;
        snprintf(file, sizeof file, SHEEN_SESSION_EVALUATION "/%s.png", r->s.frames[i].name);
        say_made(r, "side by side", file);
        break;
    }
    say_made(r, "table", SHEEN_SESSION_EVALUATION "/evaluation.md");
    say_made(r, "model", SHEEN_SESSION_MODEL "/model.json");
    sheen_json_close(&r->cli->out);
}

sheen_status sheen_cli_run_stages(sheen_cli *cli, const char *path, const sheen_cli_run_options *options,
                                  sheen_err *err)
{
    run_state r = {.cli = cli, .args = *options, .progress = sheen_cli_progress(cli)};
    sheen_status st = sheen_session_open(&r.s, path, err);
    for (size_t i = 0; !st && i < sizeof stages / sizeof *stages; i++)
        st = run_stage(&r, &stages[i], err);
    if (!st)
        say_all_made(&r);
    sheen_session_release(&r.s);
    return st;
}

static sheen_status run(sheen_cli *cli, sheen_err *err)
{
    sheen_cli_run_options o = {0};
    const sheen_option options[] = {
        {"no-film", 0, SHEEN_OPTION_FLAG, &o.no_film, NULL, "without the film once about the object", 0, 0},
        {"film-size", 0, SHEEN_OPTION_SIZE, o.film_size_px, "WxH", "default: 640 wide", 16, 8192},
        {"threads", 0, SHEEN_OPTION_INT, &o.n_threads, "N", "default: one a processor", 1, 1024},
        {0},
    };
    const sheen_status st = sheen_cli_parse(cli, options, 1, 1, err);
    return st || cli->wants_help ? st : sheen_cli_run_stages(cli, cli->args[0], &o, err);
}

const sheen_command sheen_cmd_run = {
    .name = "run",
    .synopsis = "SESSION [options]",
    .summary = "every stage that is missing or out of date, in order",
    .about =
        "calibrate, pose, fit, eval (where there are test frames), and a film once about the object\n"
        "(surface that no photograph saw is filled from what lies around it). A stage whose result was made\n"
        "from the very files that are there now is skipped, so that a second run does nothing.\n",
    .example = "  sheen import penguin.session photos/*.jpg --board board.json --mesh penguin.ply\n"
               "  sheen import penguin.session board/*.jpg --role calibration\n"
               "  sheen run penguin.session\n",
    .run = run,
};

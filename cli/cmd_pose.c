// SPDX-License-Identifier: Apache-2.0
// cmd_pose.c - sheen pose: where the camera was, frame by frame, from the board.
#include <math.h>

#include "cli/cli.h"
#include "cli/commands.h"
#include "cli/stages.h"
#include "pose/pose_report.h"
#include "pose/pose_session.h"
#include "pose/turntable_session.h"

void sheen_cli_say_poses(sheen_cli *cli, const sheen_pose_summary *p, const sheen_poses *poses)
{
    sheen_json_put_bool(&cli->out, "imported", p->left_alone);
    if (p->left_alone) {
        sheen_cli_say(cli, "the session's poses were imported and are left alone");
        return;
    }
    sheen_cli_say(
        cli,
        "%d of %d frames have a pose; reprojection error %.3f px rms an axis (median), position known to "
        "%.3f mm (median; worst %.3f mm)",
        p->n_found, p->n_frames, p->rms_median_px, 1e3 * p->sigma_median_m, 1e3 * p->sigma_worst_m);
    for (size_t i = 0; i < poses->n_poses; i++)
        if (poses->poses[i].reason[0])
            sheen_cli_say(cli, "  %s%s: %s", poses->poses[i].found ? "" : "no pose: ", poses->poses[i].name,
                          poses->poses[i].reason);
    sheen_json_put_int(&cli->out, "frames", p->n_frames);
    sheen_json_put_int(&cli->out, "posed_frames", p->n_found);
    sheen_json_put_int(&cli->out, "from_tags_alone", p->n_from_tags);
    sheen_json_put_number(&cli->out, "rms_median_px", p->rms_median_px);
    sheen_json_put_number(&cli->out, "sigma_median_m", p->sigma_median_m);
    sheen_json_put_number(&cli->out, "sigma_worst_m", p->sigma_worst_m);
}

// The boards of a set, and where they are to each other.
static void say_boards(sheen_cli *cli, const sheen_poses *poses)
{
    if (!poses->n_boards)
        return;
    sheen_json_open(&cli->out, "boards", '[');
    for (size_t i = 0; i < poses->n_boards; i++) {
        const sheen_board_place *b = &poses->boards[i];
        double var_r = 0, var_t = 0;
        for (size_t k = 0; k < 3; k++) {
            var_r = fmax(var_r, b->covariance[7 * k]);
            var_t = fmax(var_t, b->covariance[7 * (3 + k)]);
        }
        if (!b->found)
            sheen_cli_say(cli, "board '%s': %s", b->name, b->reason);
        else
            sheen_cli_say(cli, "board '%s': in %d frames; its place is %s%.3f mm and %.4f degrees%s%s",
                          b->name, b->n_frames, i ? "known to " : "the reference, ", 1e3 * sqrt(var_t),
                          57.29577951308232 * sqrt(var_r), b->reason[0] ? "; it " : "", b->reason);
        cli->limit_missed = cli->limit_missed || b->n_moved;
        sheen_json_open(&cli->out, NULL, '{');
        sheen_json_put_string(&cli->out, "name", b->name);
        sheen_json_put_bool(&cli->out, "found", b->found);
        sheen_json_put_numbers(&cli->out, "rt_ref_board", b->rt_ref_board, 6);
        sheen_json_put_number(&cli->out, "sigma_m", sqrt(var_t));
        sheen_json_put_number(&cli->out, "sigma_rad", sqrt(var_r));
        sheen_json_put_int(&cli->out, "frames", b->n_frames);
        sheen_json_put_int(&cli->out, "moved_frames", b->n_moved);
        sheen_json_close(&cli->out);
    }
    sheen_json_close(&cli->out);
}

static void check_limit(sheen_cli *cli, const sheen_poses *poses, double max_rms_px)
{
    for (size_t i = 0; i < poses->n_poses; i++)
        if (poses->poses[i].found && poses->poses[i].rms_px > max_rms_px) {
            sheen_cli_warn(cli, "the reprojection error of frame '%s', %.3f px, is above the limit of %g px",
                           poses->poses[i].name, poses->poses[i].rms_px, max_rms_px);
            cli->limit_missed = true;
        }
}

static const double DEG_PER_RAD = 57.29577951308232;

static void say_gain(sheen_cli *cli, const sheen_session_turntable *t)
{
    const sheen_turntable_gain *g = &t->gain;
    if (!t->has_gain) {
        sheen_cli_say(cli, "  commanded against measured: %s", t->reason);
        return;
    }
    sheen_cli_say(
        cli, "  commanded against measured: %.5f +- %.5f degrees a degree, rms %.4f degrees, worst %.4f (%s)",
        g->gain, g->sigma_gain, DEG_PER_RAD * g->rms_rad, DEG_PER_RAD * g->worst_rad,
        t->frames[g->i_worst]->name);
    sheen_json_put_number(&cli->out, "gain", g->gain);
    sheen_json_put_number(&cli->out, "sigma_gain", g->sigma_gain);
    sheen_json_put_number(&cli->out, "asked_rms_deg", DEG_PER_RAD * g->rms_rad);
}

// The turntable, as the boards show it.
static void say_turntable(sheen_cli *cli, const sheen_session *s, const sheen_poses *poses)
{
    sheen_session_turntable t;
    sheen_err why = {0};
    if (sheen_session_turntable_find(&t, s, poses, &why)) {
        sheen_cli_say(cli, "turntable: %s", why.msg);
        return;
    }
    sheen_cli_say(
        cli,
        "turntable: axis known to %.4f degrees and %.3f mm from %zu of %zu frames; poses scatter %.1f "
        "times what is predicted",
        DEG_PER_RAD * t.table.sigma_axis_rad, 1e3 * t.table.sigma_origin_m, t.table.n_used, t.table.n_views,
        t.table.scatter);
    sheen_json_open(&cli->out, "turntable", '{');
    sheen_json_put_numbers(&cli->out, "rt_cam_table", t.table.rt_cam_table, 6);
    sheen_json_put_numbers(&cli->out, "rt_table_board", t.table.rt_table_board, 6);
    sheen_json_put_number(&cli->out, "sigma_axis_deg", DEG_PER_RAD * t.table.sigma_axis_rad);
    sheen_json_put_number(&cli->out, "sigma_origin_m", t.table.sigma_origin_m);
    sheen_json_put_number(&cli->out, "scatter", t.table.scatter);
    say_gain(cli, &t);
    sheen_json_open(&cli->out, "views", '[');
    for (size_t i = 0; i < t.table.n_views; i++) {
        const sheen_turntable_view *v = &t.table.views[i];
        if (!v->used)
            sheen_cli_say(cli, "  left out: %s does not turn about the axis of the others (%.0f sigma)",
                          t.frames[i]->name, v->misfit);
        sheen_json_open(&cli->out, NULL, '{');
        sheen_json_put_string(&cli->out, "frame", t.frames[i]->name);
        sheen_json_put_bool(&cli->out, "used", v->used);
        sheen_json_put_number(&cli->out, "angle_deg", DEG_PER_RAD * v->angle_rad);
        sheen_json_put_number(&cli->out, "sigma_deg", DEG_PER_RAD * v->sigma_rad);
        sheen_json_put_number(&cli->out, "asked_deg", DEG_PER_RAD * t.asked_rad[i]);
        sheen_json_close(&cli->out);
    }
    sheen_json_close(&cli->out);
    sheen_json_close(&cli->out);
    sheen_session_turntable_release(&t);
}

static sheen_status run(sheen_cli *cli, sheen_err *err)
{
    double max_rms_px = (double)INFINITY;
    const char *report = NULL;
    sheen_pose_options o = {0};
    const sheen_option options[] = {
        {"max-rms-px", 0, SHEEN_OPTION_NUMBER, &max_rms_px, "X",
         "exit with 3 where a frame's reprojection error is\nlarger", 0, 1e6},
        {"report", 0, SHEEN_OPTION_TEXT, &report, "FILE", "one HTML page with plots", 0, 0},
        {"force", 0, SHEEN_OPTION_FLAG, &o.force, NULL, "measure anew where poses were imported", 0, 0},
        {"threads", 0, SHEEN_OPTION_INT, &o.n_threads, "N", "default: one a processor", 1, 1024},
        {0},
    };
    sheen_session s;
    sheen_poses poses = {0};
    sheen_pose_summary summary;
    bool moved_both;
    sheen_status st = sheen_cli_parse(cli, options, 1, 1, err);
    if (st || cli->wants_help)
        return st;
    o.progress = sheen_cli_progress(cli);
    st = sheen_session_open(&s, cli->args[0], err);
    if (st)
        return st;
    st = sheen_pose_session(&summary, &poses, &s, &o, err);
    sheen_cli_clear_bar(cli);
    if (!st) {
        sheen_cli_say_poses(cli, &summary, &poses);
        if (summary.alike) {
            sheen_cli_warn(cli, "all frames are from the same place: take them from several sides");
            cli->limit_missed = true;
        }
        say_boards(cli, &poses);
        if (s.moving == SHEEN_MOVING_OBJECT)
            say_turntable(cli, &s, &poses);
        check_limit(cli, &poses, max_rms_px);
        sheen_cli_check_camera(cli, &s, summary.rms_median_px);
        if (!summary.left_alone)
            st = sheen_cli_check_moved(cli, &s, &poses, &moved_both, err);
        if (!st && report)
            st = sheen_pose_report(report, &s, &poses, err);
    }
    sheen_poses_release(&poses);
    sheen_session_release(&s);
    return st;
}

const sheen_command sheen_cmd_pose = {
    .name = "pose",
    .synopsis = "SESSION [options]",
    .summary = "where the camera was, frame by frame, from the board",
    .about = "Wants a camera and board.json in the session. Writes poses.json, with what each pose is worth, "
             "and for\n"
             "frames without one the reason. Several boards are surveyed together. Exit code 3: all frames "
             "are from one\n"
             "place, a board was moved, not that moved what the session says, or --max-rms-px is exceeded.\n",
    .example = "  sheen pose penguin.session --max-rms-px 0.3 --report poses.html\n",
    .run = run,
};

// SPDX-License-Identifier: Apache-2.0
// cmd_fit.c - sheen fit: texture, lights and gloss from a session's photographs.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cli/cli.h"
#include "cli/commands.h"
#include "cli/stages.h"
#include "fit/evaluate_session.h"
#include "fit/fit_report.h"
#include "fit/fit_session.h"

typedef struct fit_args {
    const char *method, *loss, *report, *without;
    sheen_fit_method chosen;
    double sigma0_deg;
    int max_samples;
    sheen_paper_options o;
} fit_args;

static sheen_status parse(sheen_cli *cli, fit_args *a, sheen_err *err)
{
    const sheen_option options[] = {
        {"method", 0, SHEEN_OPTION_TEXT, &a->method, "NAME",
         "refined (default): lamps with place and extent, shadows,\nmirrored surroundings; paper: Nishino, "
         "Zhang, Ikeuchi 2001,\nto the letter",
         0, 0},
        {"texels", 0, SHEEN_OPTION_INT, &a->o.texels_per_edge, "N",
         "texels along a triangle's edge (default: as fine as\nthe photographs)", 2, 64},
        {"frequency", 0, SHEEN_OPTION_INT, &a->o.frequency, "N",
         "subdivision of the light hemisphere: about 5 N^2 nodes\n(default: 60)", 1, 400},
        {"threshold", 0, SHEEN_OPTION_NUMBER, &a->o.threshold_lin, "X",
         "residual that counts as highlight, share of white\n(default: 0.04)", 1e-6, 1},
        {"consistency", 0, SHEEN_OPTION_NUMBER, &a->o.consistency, "X",
         "share of the views that must agree on a light\n(default: 1, as in the paper)", 0.01, 1},
        {"sigma0-deg", 0, SHEEN_OPTION_NUMBER, &a->sigma0_deg, "X",
         "where the lobe's width starts (default: found)", 0.1, 60},
        {"samples", 0, SHEEN_OPTION_INT, &a->max_samples, "N", "most samples to fit (default: 30000)", 100,
         1e8},
        {"loss", 0, SHEEN_OPTION_TEXT, &a->loss, "NAME",
         "lorentzian (default) or quartic: equations 10 and 11\nto the letter", 0, 0},
        {"report", 0, SHEEN_OPTION_TEXT, &a->report, "FILE",
         "write what was found, how sure it is, and the pictures as\none HTML file", 0, 0},
        {"keep-poses", 0, SHEEN_OPTION_FLAG, &a->o.keep_poses, NULL,
         "refined: take the poses as they are (default: made to\nagree on the surface)", 0, 0},
        {"keep-exposures", 0, SHEEN_OPTION_FLAG, &a->o.keep_exposures, NULL,
         "refined: take exposure and white balance as equal in all\nphotographs (default: measured)", 0, 0},
        {"without", 0, SHEEN_OPTION_TEXT, &a->without, "NAME,...",
         "refined: leave these out: lamps, shadows, board, ambient,\nfresnel, tail, regions, poses, "
         "exposures, normals",
         0, 0},
        {"threads", 0, SHEEN_OPTION_INT, &a->o.n_threads, "N", "default: one a processor", 1, 1024},
        {0},
    };
    const sheen_status s = sheen_cli_parse(cli, options, 1, 1, err);
    if (s || cli->wants_help)
        return s;
    if (a->method && sheen_fit_method_from_name(&a->chosen, a->method, NULL))
        return sheen_cli_usage(cli, err, "unknown method '%.40s': use 'refined' or 'paper'", a->method);
    sheen_err why;
    if (a->without && sheen_extensions_parse(&a->o.without, a->without, &why))
        return sheen_cli_usage(cli, err, "%s", why.msg);
    if (a->loss && strcmp(a->loss, "lorentzian") != 0 && strcmp(a->loss, "quartic") != 0)
        return sheen_cli_usage(cli, err, "unknown loss '%.40s': use 'lorentzian' or 'quartic'", a->loss);
    a->o.loss = a->loss && !strcmp(a->loss, "quartic") ? SHEEN_LOSS_QUARTIC : SHEEN_LOSS_LORENTZIAN;
    a->o.sigma0_rad = a->sigma0_deg * 3.14159265358979323846 / 180;
    a->o.max_samples = (size_t)a->max_samples;
    return SHEEN_OK;
}

// E of eq. (9) after each turn, on one line.
static void say_turns(sheen_cli *cli, const sheen_fit_summary *f)
{
    char text[1024] = "";
    size_t n = 0;
    for (size_t i = 0; i < f->n_turns && n + 16 < sizeof text; i++)
        n += (size_t)snprintf(text + n, sizeof text - n, " %.4f", f->turns[i].objective);
    sheen_cli_say(cli, "objective by turn:%s", text);
}

static void put_turns(sheen_cli *cli, const sheen_fit_summary *f)
{
    sheen_json_open(&cli->out, "turns", '[');
    for (size_t i = 0; i < f->n_turns; i++) {
        const sheen_refine_turn *t = &f->turns[i];
        sheen_json_open(&cli->out, NULL, '{');
        sheen_json_put_number(&cli->out, "sigma_rad", t->sigma_rad);
        sheen_json_put_number(&cli->out, "k_s", t->k_s);
        sheen_json_put_number(&cli->out, "objective", t->objective);
        sheen_json_put_int(&cli->out, "nodes_left", (long long)t->n_nodes_left);
        sheen_json_close(&cli->out);
    }
    sheen_json_close(&cli->out);
}

static void put_certainty(sheen_cli *cli, const sheen_certainty *c)
{
    sheen_json_put_number(&cli->out, "sigma_share", c->sigma_share);
    sheen_json_put_number(&cli->out, "k_s_share", c->k_s_share);
    sheen_json_open(&cli->out, "not_determined", '[');
    for (size_t i = 0; i < c->n_sentences; i++)
        sheen_json_put_string(&cli->out, NULL, c->sentences[i]);
    sheen_json_close(&cli->out);
}

void sheen_cli_say_fit(sheen_cli *cli, const sheen_fit_summary *f)
{
    sheen_cli_say(cli, "%zu photographs, %zu samples; %.1f %% of the surface was seen", f->n_views,
                  f->n_samples, 100 * f->seen_share);
    sheen_cli_say(cli, "lights: of %zu nodes %zu were reached by a mirror shot, %zu kept, %zu lit at the end",
                  f->n_nodes, f->n_reached, f->n_assigned, f->n_left);
    sheen_cli_say(cli, "k_S %.4g, sigma %.4f rad (started at %.4f), objective %.4g after %zu turns%s", f->k_s,
                  f->sigma_rad, f->sigma0_rad, f->objective, f->n_turns,
                  f->converged ? "" : ", not converged");
    say_turns(cli, f);
    if (f->poses_refined)
        sheen_cli_say(cli, "poses: moved by %.2f px (rms), known to %.2f px", f->pose_moved_px,
                      f->pose_sigma_px);
    if (f->exposures_refined)
        sheen_cli_say(cli, "exposures: differ by up to %.2f EV, and were evened out", f->exposure_range_ev);
    if (!isnan(f->f0))
        sheen_cli_say(cli, "surroundings: reflectance %.3f at normal incidence, with the mesh's own shadows",
                      f->f0);
    if (f->n_dark)
        sheen_cli_say(cli, "note: %zu photograph%s black and left out ('%s'%s)", f->n_dark,
                      f->n_dark == 1 ? " is" : "s are", f->dark_name, f->n_dark == 1 ? "" : " is the first");
    for (size_t i = 0; i < f->certainty.n_sentences; i++)
        sheen_cli_say(cli, "note: %s", f->certainty.sentences[i]);
    put_certainty(cli, &f->certainty);
    sheen_json_put_string(&cli->out, "method", f->method);
    sheen_json_put_number(&cli->out, "f0", f->f0);
    sheen_json_put_int(&cli->out, "photographs", (long long)f->n_views);
    sheen_json_put_int(&cli->out, "photographs_black", (long long)f->n_dark);
    sheen_json_put_int(&cli->out, "samples", (long long)f->n_samples);
    sheen_json_put_number(&cli->out, "seen_share", f->seen_share);
    sheen_json_put_int(&cli->out, "nodes", (long long)f->n_nodes);
    sheen_json_put_int(&cli->out, "nodes_reached", (long long)f->n_reached);
    sheen_json_put_int(&cli->out, "nodes_assigned", (long long)f->n_assigned);
    sheen_json_put_int(&cli->out, "nodes_left", (long long)f->n_left);
    sheen_json_put_number(&cli->out, "k_s", f->k_s);
    sheen_json_put_number(&cli->out, "sigma_rad", f->sigma_rad);
    sheen_json_put_number(&cli->out, "sigma0_rad", f->sigma0_rad);
    sheen_json_put_number(&cli->out, "sigma_err", f->sigma_err);
    sheen_json_put_number(&cli->out, "objective", f->objective);
    put_turns(cli, f);
    sheen_json_put_bool(&cli->out, "poses_refined", f->poses_refined);
    sheen_json_put_number(&cli->out, "pose_moved_px", f->pose_moved_px);
    sheen_json_put_number(&cli->out, "pose_sigma_px", f->pose_sigma_px);
    sheen_json_put_bool(&cli->out, "exposures_refined", f->exposures_refined);
    sheen_json_put_number(&cli->out, "exposure_range_ev", f->exposure_range_ev);
    sheen_json_put_bool(&cli->out, "converged", f->converged);
    sheen_json_put_numbers(&cli->out, "light_rgb", f->light_rgb, 3);
}

// With the scores on the session's test frames where it has some.
static sheen_status write_report(sheen_cli *cli, const fit_args *a, const sheen_session *s,
                                 const sheen_fit_summary *summary, sheen_err *err)
{
    sheen_fit_timing timings[SHEEN_CLI_MAX_TIMINGS];
    sheen_evaluation e = {0};
    const sheen_evaluate_session_options eo = {
        .fit = {.n_threads = a->o.n_threads, .progress = a->o.progress}};
    sheen_fit_report r = {.session = s, .summary = summary, .timings = timings, .n_timings = cli->n_times};
    for (size_t i = 0; i < cli->n_times; i++)
        timings[i] = (sheen_fit_timing){cli->times[i].what, cli->times[i].wall_s, cli->times[i].cpu_s};
    sheen_status st = SHEEN_OK;
    if (sheen_session_count_role(s, SHEEN_ROLE_TEST)) {
        if ((st = sheen_evaluate_session(&e, s, &eo, err)))
            return st;
        r.evaluation = &e;
    }
    st = sheen_fit_report_write(a->report, &r, err);
    sheen_evaluation_release(&e);
    return st;
}

static sheen_status run(sheen_cli *cli, sheen_err *err)
{
    fit_args a = {0};
    sheen_session s;
    sheen_fit_summary summary;
    sheen_status st = parse(cli, &a, err);
    if (st || cli->wants_help)
        return st;
    a.o.progress = sheen_cli_progress(cli);
    st = sheen_session_open(&s, cli->args[0], err);
    if (st)
        return st;
    st = sheen_fit_session(&summary, &s, a.chosen, &a.o, err);
    if (!st && a.report)
        st = write_report(cli, &a, &s, &summary, err);
    sheen_cli_clear_bar(cli);
    if (!st)
        sheen_cli_say_fit(cli, &summary);
    sheen_fit_summary_release(&summary);
    sheen_session_release(&s);
    return st;
}

const sheen_command sheen_cmd_fit = {
    .name = "fit",
    .synopsis = "SESSION [options]",
    .summary = "texture, lights and gloss from the photographs",
    .about = "Wants input frames, a camera, poses and a mesh in the session. Replaces model/: parameters and "
             "lights\n"
             "(model.json), the texture, and the pictures of every step of the method.\n",
    .example = "  sheen fit penguin.session --timings\n",
    .run = run,
};

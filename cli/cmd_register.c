// SPDX-License-Identifier: Apache-2.0
// cmd_register.c - sheen register: a mesh into the session, where it stands on the board: told, marked, or found.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/file.h"
#include "base/mesh_foreign.h"
#include "base/pose3.h"
#include "capture/import.h"
#include "cli/cli.h"
#include "cli/commands.h"
#include "cli/pick.h"
#include "cli/serve_here.h"
#include "pose/register_session.h"

static const double DEG_PER_RAD = 57.29577951308232;
static const double WIDE_PX = 0.5; // masks that are so much too wide, or too narrow, are worth a word

// What the person said.
typedef struct request {
    const char *rt, *points, *pick, *unit, *up;
    sheen_serve_options page;
    bool fit_scale, edges, keep;
    double rt_board_obj[6], unit_m;
    unsigned ups;
} request;

// Six numbers with commas between them.
static bool read_rt(double rt[6], const char *text)
{
    for (int i = 0; i < 6; i++) {
        char *end;
        rt[i] = strtod(text, &end);
        if (end == text || !isfinite(rt[i]) || *end != (i < 5 ? ',' : 0))
            return false;
        text = end + 1;
    }
    return true;
}

static sheen_status check(sheen_cli *cli, request *r, sheen_err *err)
{
    static const struct {
        const char *name;
        double unit_m;
    } units[] = {{"m", 1}, {"cm", 1e-2}, {"mm", 1e-3}, {"inch", 0.0254}};
    if (r->rt && !read_rt(r->rt_board_obj, r->rt))
        return sheen_cli_usage(cli, err, "'--rt' wants six numbers such as 0,0,1.57,0.01,0,0, not '%.60s'",
                               r->rt);
    for (size_t i = 0; i < 4 && r->unit; i++)
        if (!strcmp(r->unit, units[i].name))
            r->unit_m = units[i].unit_m;
    if (r->unit && !(r->unit_m > 0))
        return sheen_cli_usage(cli, err, "'--unit' is m, cm, mm or inch, not '%.60s'", r->unit);
    for (unsigned up = 1; up <= SHEEN_UP_MINUS_Z && r->up; up <<= 1)
        if (!strcmp(r->up, sheen_up_name(up)))
            r->ups = up;
    if (r->up && !r->ups)
        return sheen_cli_usage(cli, err, "'--up' is x, -x, y, -y, z or -z, not '%.60s'", r->up);
    if (r->pick && (r->points || r->rt))
        return sheen_cli_usage(cli, err, "'--pick' makes the marks: '--points' and '--rt' do not go with it");
    if (r->rt && (r->points || r->up))
        return sheen_cli_usage(cli, err,
                               "'--rt' says where the mesh stands: '--points' and '--up' do not go with it");
    return SHEEN_OK;
}

static void say_result(sheen_cli *cli, const sheen_register_result *r, const request *asked)
{
    const sheen_registration *g = &r->registration;
    if (r->from_points) {
        sheen_cli_say(cli, "%zu marks fit to %.2f px rms an axis, the worst (mark %zu) to %.2f px",
                      r->points.n, r->points.rms_px, r->points.i_worst + 1, r->points.worst_px);
        sheen_json_put_number(&cli->out, "points_rms_px", r->points.rms_px);
        sheen_json_put_number(&cli->out, "points_worst_px", r->points.worst_px);
    }
    if (r->masks_made)
        sheen_cli_say(
            cli, "the session has no masks: what hides the board%s in %zu frames was taken for the object",
            r->n_backgrounds ? ", or what the picture without the object shows," : "", r->n_masks);
    if (r->from_masks) {
        sheen_json_put_bool(&cli->out, "masks_made", r->masks_made);
        sheen_json_put_int(&cli->out, "backgrounds", (long long)r->n_backgrounds);
        sheen_cli_say(cli,
                      "outlines and masks of %zu frames: %.2f px apart (%.2f px rms), overlap %.2f %%; known "
                      "to %.3f mm (its worst point) and %.3f degrees",
                      g->n_views, g->misfit.border_px, g->misfit.rms_px, 100 * g->misfit.overlap,
                      1e3 * g->sigma_m, DEG_PER_RAD * g->sigma_rad);
        sheen_json_put_number(&cli->out, "border_px", g->misfit.border_px);
        sheen_json_put_number(&cli->out, "rms_px", g->misfit.rms_px);
        const bool fits = g->state != SHEEN_REGISTER_POOR;
        if (fits && fabs(g->misfit.offset_px) > WIDE_PX)
            sheen_cli_say(cli, "the borders lie %.1f px %s the object's outlines all around: allowed for",
                          fabs(g->misfit.offset_px), g->misfit.offset_px > 0 ? "outside of" : "inside of");
        sheen_json_put_number(&cli->out, "overlap", g->misfit.overlap);
        sheen_json_put_number(&cli->out, "offset_px", g->misfit.offset_px);
        sheen_json_put_number(&cli->out, "second_border_px", g->second_border_px);
        sheen_json_put_number(&cli->out, "height_m", g->height_m);
        if (fits && g->up)
            sheen_cli_say(cli, "the mesh's %s points up%s", sheen_up_name(g->up),
                          asked->ups ? ", as told" : "");
        if (fits && fabs(g->height_m) > 1e-3)
            sheen_cli_warn(cli, "the mesh's lowest point is %.1f mm %s the board", 1e3 * fabs(g->height_m),
                           g->height_m > 0 ? "above" : "below");
    }
    const double scale = g->placement.scale, unit_m = asked->unit_m > 0 ? asked->unit_m : g->unit_m;
    if (unit_m > 0)
        sheen_cli_say(cli, "its unit is %s%s", sheen_unit_name(unit_m),
                      asked->unit_m > 0 ? ", as told" : " (found)");
    if (!(unit_m > 0) || fabs(scale / unit_m - 1) > 1e-6)
        sheen_cli_say(cli, "one of its units is %.6g m in the pictures", scale);
    sheen_json_put_number(&cli->out, "scale", scale);
    sheen_json_put_number(&cli->out, "sigma_m", g->sigma_m);
    sheen_json_put_number(&cli->out, "sigma_rad", g->sigma_rad);
    sheen_json_put_string(&cli->out, "up", g->up ? sheen_up_name(g->up) : NULL);
    sheen_json_put_string(&cli->out, "verdict",
                          g->state == SHEEN_REGISTER_SURE        ? "sure"
                          : g->state == SHEEN_REGISTER_AMBIGUOUS ? "ambiguous"
                                                                 : "poor");
    sheen_cli_say(cli, "%zu pictures with the outline drawn in are in '%s'", r->n_overlays,
                  SHEEN_SESSION_OVERLAYS);
}

static sheen_status load_points(sheen_register_point **points, size_t *n, const char *path, sheen_err *err)
{
    uint8_t *data;
    size_t size_bytes;
    sheen_status st = sheen_file_read(&data, &size_bytes, path, 1 << 22, err);
    if (st)
        return st;
    st = sheen_register_points_parse(points, n, data, size_bytes, err);
    free(data);
    return st ? sheen_wrap(err, st, "cannot read '%s'", path) : SHEEN_OK;
}

// Finds the place; request->rt_board_obj and *scale are the outcome.
static sheen_status find(sheen_cli *cli, request *r, double *scale, const sheen_session *s,
                         const sheen_mesh *mesh, sheen_err *err)
{
    sheen_register_result result;
    sheen_register_point *points = NULL;
    sheen_register_session_options o = {.search = {.ups = r->ups,
                                                   .unit_m = r->unit_m,
                                                   .fit_scale = r->fit_scale,
                                                   .edges = r->edges,
                                                   .progress = sheen_cli_progress(cli)}};
    sheen_status st = r->points ? load_points(&points, &o.n_points, r->points, err) : SHEEN_OK;
    o.points = points;
    if (!st)
        st = sheen_register_in_session(&result, s, mesh, &o, err);
    sheen_cli_clear_bar(cli);
    free(points);
    if (st)
        return st;
    const sheen_registration *g = &result.registration;
    say_result(cli, &result, r);
    if (g->state == SHEEN_REGISTER_POOR)
        return sheen_fail(err, SHEEN_EDATA, "%s (see the pictures in '%s'); the session is left as it was",
                          g->reason, SHEEN_SESSION_OVERLAYS);
    if (g->state == SHEEN_REGISTER_AMBIGUOUS) {
        sheen_cli_warn(cli, "%s", g->reason);
        cli->limit_missed = true;
    }
    sheen_rt_from_Rt(r->rt_board_obj, &g->placement.Rt_board_obj);
    *scale = g->placement.scale;
    return SHEEN_OK;
}

// The session's own kinds of mesh in metres enter as they are; all others are written anew as PLY.
static sheen_status enter(sheen_cli *cli, sheen_session *s, const char *path, const sheen_mesh *mesh,
                          double scale, const double rt_board_obj[6], sheen_err *err)
{
    char made[SHEEN_PATH_MAX];
    sheen_import_report report;
    sheen_import_options o = {
        .mesh = path, .rt_board_obj = rt_board_obj, .progress = sheen_cli_progress(cli)};
    const bool as_it_is = scale == 1 && sheen_mesh_is_native(path);
    sheen_status st = as_it_is ? SHEEN_OK : sheen_session_path(made, s, ".registered.ply", err);
    if (!st && !as_it_is) {
        for (size_t i = 0; i < 3 * mesh->n_vertices; i++)
            mesh->p_obj[i] = (float)(scale * (double)mesh->p_obj[i]);
        st = sheen_mesh_save_ply(mesh, made, err);
        o.mesh = made;
    }
    if (!st)
        st = sheen_import(s, &o, &report, err);
    if (!as_it_is)
        sheen_file_remove(made, NULL);
    return st;
}

// The page of marks, until the person has enough.
static sheen_status pick_marks(sheen_cli *cli, const request *r, const sheen_session *s,
                               const sheen_mesh *mesh, sheen_err *err)
{
    sheen_pick *pick;
    sheen_status st = sheen_pick_open(&pick, s, mesh, r->pick, r->ups, r->unit_m, err);
    if (st)
        return st;
    st = sheen_cli_serve(cli, sheen_pick_answer, pick, &r->page, err);
    if (!st) {
        sheen_cli_say(cli, "%zu marks are in '%s': sheen register %s %s --points %s", sheen_pick_count(pick),
                      r->pick, cli->args[0], cli->args[1], r->pick);
        sheen_json_put_int(&cli->out, "marks", (long long)sheen_pick_count(pick));
    }
    sheen_pick_close(&pick);
    return st;
}

static sheen_status work(sheen_cli *cli, request *r, sheen_session *s, sheen_err *err)
{
    sheen_mesh mesh;
    double scale = r->unit_m > 0 ? r->unit_m : 1;
    sheen_status st = sheen_mesh_load_any(&mesh, cli->args[1], err);
    if (st)
        return st;
    if (r->pick) {
        st = pick_marks(cli, r, s, &mesh, err);
        sheen_mesh_release(&mesh);
        return st;
    }
    if (!r->rt)
        st = find(cli, r, &scale, s, &mesh, err);
    if (!st)
        st = enter(cli, s, cli->args[1], &mesh, scale, r->rt_board_obj, err);
    if (!st) {
        sheen_cli_say(cli, "'%s' has the mesh '%s'", s->path, cli->args[1]);
        sheen_json_put_string(&cli->out, "mesh", sheen_session_mesh_file(s));
        sheen_json_put_numbers(&cli->out, "rt_board_obj", r->rt_board_obj, 6);
    }
    sheen_mesh_release(&mesh);
    return st;
}

static sheen_status run(sheen_cli *cli, sheen_err *err)
{
    request r = {0};
    const sheen_option options[] = {
        {"rt", 0, SHEEN_OPTION_TEXT, &r.rt, "R,R,R,T,T,T",
         "rt_board_obj, where it is known: Rodrigues rotation\n(radians), then translation (metres), from "
         "the\n"
         "mesh's frame to the board's; all 0: they are the same",
         0, 0},
        {"points", 0, SHEEN_OPTION_TEXT, &r.points, "FILE",
         "points of the mesh marked in frames: lines of\n'frame x y X Y Z' (pixels; the mesh's unit)", 0, 0},
        {"pick", 0, SHEEN_OPTION_TEXT, &r.pick, "FILE",
         "mark such points on a page in your browser, into\nFILE; the mesh stays where it is until\n--points "
         "FILE",
         0, 0},
        {"port", 0, SHEEN_OPTION_INT, &r.page.port, "N", "of that page (default: any that is free)", 1,
         65535},
        {"no-browser", 0, SHEEN_OPTION_FLAG, &r.page.stay, NULL, "only say the page's address", 0, 0},
        {"unit", 0, SHEEN_OPTION_TEXT, &r.unit, "UNIT", "of the mesh: m, cm, mm, inch (default: found)", 0,
         0},
        {"up", 0, SHEEN_OPTION_TEXT, &r.up, "AXIS",
         "side of the mesh that points up: z, y, -x, ...\n(default: found)", 0, 0},
        {"fit-scale", 0, SHEEN_OPTION_FLAG, &r.fit_scale, NULL, "find the exact size, too, not only the unit",
         0, 0},
        {"edges", 0, SHEEN_OPTION_FLAG, &r.edges, NULL, "end at the pictures' edges: masks are rough", 0, 0},
        {0},
    };
    sheen_session s;
    sheen_status st = sheen_cli_parse(cli, options, 2, 2, err);
    if (st || cli->wants_help)
        return st;
    st = check(cli, &r, err);
    if (st)
        return st;
    st = sheen_session_open(&s, cli->args[0], err);
    if (st)
        return st;
    st = work(cli, &r, &s, err);
    sheen_session_release(&s);
    return st;
}

const sheen_command sheen_cmd_register = {
    .name = "register",
    .synopsis = "SESSION MESH [options]",
    .summary = "a mesh into the session, where it stands on the board",
    .about = "Finds where the mesh stands on the board from the frames' masks (and marked points), or takes "
             "the place\n"
             "that is given. Wants camera and poses. Exit code 3: another place fits as well.\n",
    .example = "  sheen register penguin.session penguin.stl --unit mm\n"
               "  sheen register penguin.session penguin.ply --rt 0,0,1.5708,0.02,0,0\n",
    .run = run,
};

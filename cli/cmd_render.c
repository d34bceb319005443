// SPDX-License-Identifier: Apache-2.0
// cmd_render.c - sheen render: pictures of a session's model from given poses, from one side, or once about it.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/pose3.h"
#include "base/pose_file.h"
#include "base/vec.h"
#include "cli/cli.h"
#include "cli/commands.h"
#include "cli/picture.h"
#include "cli/stages.h"

static const double rad_per_deg = 3.14159265358979323846 / 180;

typedef struct render_args {
    const char *poses, *output, *orbit, *view, *spin, *format;
    const char *tint, *background, *holes, *lights, *turn_axis;
    int size_px[2];
    double elevation_deg, distance_m, duration_s, turn_lights_deg;
    int frames_per_s, samples, n_threads, count;
    bool black_holes;
    double look[3]; // azimuth, elevation (degrees), distance (metres)
    double background_rgb[3], turn_axis_board[3];
    sheen_cli_changes changes;
    sheen_cli_picture picture;
} render_args;

// Up to three numbers between commas; how many there were, 0: something else.
static int read_numbers(double out[3], const char *text)
{
    for (int i = 0; i < 3; i++) {
        char *end;
        out[i] = strtod(text, &end);
        if (end == text || !isfinite(out[i]))
            return 0;
        if (!*end)
            return i + 1;
        if (*end != ',')
            return 0;
        text = end + 1;
    }
    return 0;
}

static sheen_status check_colours(sheen_cli *cli, render_args *a, sheen_err *err)
{
    if (a->tint && (read_numbers(a->changes.tint_rgb, a->tint) != 3 || a->changes.tint_rgb[0] < 0 ||
                    a->changes.tint_rgb[1] < 0 || a->changes.tint_rgb[2] < 0))
        return sheen_cli_usage(cli, err, "'--tint' wants red, green and blue such as 1,0.9,0.7, not '%.40s'",
                               a->tint);
    a->picture.transparent = a->background && !strcmp(a->background, "none");
    if (a->picture.transparent && a->orbit)
        return sheen_cli_usage(cli, err, "a film cannot be transparent: give '--background' a colour");
    if (a->background && !a->picture.transparent && read_numbers(a->background_rgb, a->background) != 3)
        return sheen_cli_usage(
            cli, err, "'--background' wants none, or linear red, green and blue such as 1,1,1, not '%.40s'",
            a->background);
    if (a->black_holes && !a->holes)
        a->holes = "black";
    if (a->holes && strcmp(a->holes, "mark") != 0 && strcmp(a->holes, "black") != 0 &&
        strcmp(a->holes, "fill") != 0)
        return sheen_cli_usage(cli, err, "'--holes' is mark, black or fill, not '%.40s'", a->holes);
    a->changes.fill_holes = a->holes && !strcmp(a->holes, "fill");
    return SHEEN_OK;
}

static sheen_status check_lights(sheen_cli *cli, render_args *a, sheen_err *err)
{
    if (a->lights && strcmp(a->lights, "still") != 0 && strcmp(a->lights, "turn") != 0)
        return sheen_cli_usage(cli, err, "unknown lights '%.40s': use still or turn", a->lights);
    if (a->turn_axis &&
        (read_numbers(a->turn_axis_board, a->turn_axis) != 3 || !(sheen_normalize(a->turn_axis_board) > 0)))
        return sheen_cli_usage(cli, err, "'--turn-axis' wants a direction such as 1,0,0, not '%.40s'",
                               a->turn_axis);
    return SHEEN_OK;
}

static sheen_status check(sheen_cli *cli, render_args *a, sheen_err *err)
{
    if (!a->poses + !a->orbit + !a->view + !a->spin != 3)
        return sheen_cli_usage(
            cli, err, "say what to draw: one of --poses FILE, --view AZ,EL,DIST, --orbit FILE, --spin DIR");
    if ((a->poses || a->view) && !a->output)
        return sheen_cli_usage(cli, err, "say where it goes: -o %s", a->poses ? "DIR" : "FILE");
    if (a->view && (read_numbers(a->look, a->view) < 2))
        return sheen_cli_usage(
            cli, err, "'--view' wants azimuth, elevation and distance such as 30,25,0.5, not '%.40s'",
            a->view);
    if (!sheen_cli_layer_known(a->picture.layer))
        return sheen_cli_usage(cli, err,
                               "unknown layer '%.40s': use diffuse, specular, all, depth, normal or mask",
                               a->picture.layer);
    if (a->orbit && sheen_cli_layer_is_geometry(a->picture.layer))
        return sheen_cli_usage(cli, err, "a film has no layer '%s': use --poses, --view or --spin",
                               a->picture.layer);
    if (strcmp(a->format, "png") != 0 && strcmp(a->format, "exr") != 0)
        return sheen_cli_usage(cli, err, "unknown format '%.40s': use png or exr", a->format);
    const char *ending = a->view ? sheen_path_extension(a->output) : a->format;
    if (strcasecmp(ending, "png") != 0 && strcasecmp(ending, "exr") != 0)
        return sheen_cli_usage(cli, err, "'%.100s' should end in .png or .exr", a->output);
    if (a->picture.layer && !strcmp(a->picture.layer, "depth") && strcasecmp(ending, "exr") != 0)
        return sheen_cli_usage(cli, err, "depth in metres wants an .exr%s",
                               a->view ? "" : ": add --format exr");
    const sheen_status s = check_lights(cli, a, err);
    return s ? s : check_colours(cli, a, err);
}

static sheen_status parse(sheen_cli *cli, render_args *a, sheen_err *err)
{
    *a = (render_args){.format = "png",
                       .elevation_deg = 25,
                       .duration_s = 6,
                       .frames_per_s = 30,
                       .samples = 2,
                       .count = 36,
                       .changes = {.k_s_factor = 1, .tint_rgb = {1, 1, 1}}};
    const sheen_option options[] = {
        {"poses", 0, SHEEN_OPTION_TEXT, &a->poses, "FILE",
         "from these poses and cameras: transforms.json, a COLMAP\ntext model's folder, poses.json; in the "
         "board's frame",
         0, 0},
        {"view", 0, SHEEN_OPTION_TEXT, &a->view, "AZ,EL,DIST",
         "from this azimuth and elevation (degrees; 0 is the\nboard's x, counter-clockwise) and distance "
         "(metres;\nwithout: the "
         "object fills the picture)",
         0, 0},
        {"orbit", 0, SHEEN_OPTION_TEXT, &a->orbit, "FILE", "a film once about the object: .mp4, .webm", 0, 0},
        {"spin", 0, SHEEN_OPTION_TEXT, &a->spin, "DIR",
         "stills once about the object, with index.json and a\npage that turns them", 0, 0},
        {"count", 0, SHEEN_OPTION_INT, &a->count, "N", "stills of --spin (default: 36)", 2, 3600},
        {"output", 'o', SHEEN_OPTION_TEXT, &a->output, "PATH",
         "of --view: the picture, .png (sRGB) or .exr (linear);\nof --poses: a folder of <pose's name>.png",
         0, 0},
        {"layer", 0, SHEEN_OPTION_TEXT, &a->picture.layer, "NAME",
         "all (default), diffuse, specular, mask, normal (camera\naxes), depth (metres along the optical "
         "axis; .exr)",
         0, 0},
        {"format", 0, SHEEN_OPTION_TEXT, &a->format, "NAME", "of --poses, --spin: png (default) or exr", 0,
         0},
        {"size", 0, SHEEN_OPTION_SIZE, a->size_px, "WxH", "default: the camera's", 16, 16384},
        {"background", 0, SHEEN_OPTION_TEXT, &a->background, "COLOUR",
         "none (transparent), or linear red,green,blue", 0, 0},
        {"holes", 0, SHEEN_OPTION_TEXT, &a->holes, "HOW",
         "surface that no photograph saw: mark (magenta, the\ndefault), black, or fill from what lies around "
         "it",
         0, 0},
        {"lights", 0, SHEEN_OPTION_TEXT, &a->lights, "WHICH",
         "of an object on a turntable: still, it turns under them as\nit did (default); turn, they turn with "
         "it as in the first\nphotograph, and the camera goes round both",
         0, 0},
        {"panorama", 0, SHEEN_OPTION_TEXT, &a->changes.panorama, "FILE",
         "light it by this equirectangular picture instead\n(.hdr, .exr, .png; its top is up, its middle the "
         "board's\nx); the texture keeps the light that was on it",
         0, 0},
        {"turn-lights", 0, SHEEN_OPTION_NUMBER, &a->turn_lights_deg, "DEG",
         "turn the lights about the board's z, counter-clockwise", -360, 360},
        {"turn-axis", 0, SHEEN_OPTION_TEXT, &a->turn_axis, "X,Y,Z",
         "of --turn-lights: another axis, in the board's frame", 0, 0},
        {"k-s", 0, SHEEN_OPTION_NUMBER, &a->changes.k_s_factor, "FACTOR",
         "highlights' strength, as a multiple of the fitted one", 0, 1000},
        {"sigma", 0, SHEEN_OPTION_NUMBER, &a->changes.sigma_rad, "RAD", "another roughness", 1e-3, 1.5},
        {"tint", 0, SHEEN_OPTION_TEXT, &a->tint, "R,G,B", "times the highlights' colour", 0, 0},
        {"elevation", 0, SHEEN_OPTION_NUMBER, &a->elevation_deg, "DEG", "of --orbit, --spin (default: 25)",
         -89, 89},
        {"distance", 0, SHEEN_OPTION_NUMBER, &a->distance_m, "M",
         "of --orbit, --spin (default: the object fills the picture)", 1e-3, 1e3},
        {"seconds", 0, SHEEN_OPTION_NUMBER, &a->duration_s, "S", "of --orbit (default: 6)", 0.1, 600},
        {"fps", 0, SHEEN_OPTION_INT, &a->frames_per_s, "N", "of --orbit (default: 30)", 1, 120},
        {"samples", 0, SHEEN_OPTION_INT, &a->samples, "N", "N x N samples a pixel (default: 2)", 1, 8},
        {"black-holes", 0, SHEEN_OPTION_FLAG, &a->black_holes, NULL, "the same as --holes black", 0, 0},
        {"threads", 0, SHEEN_OPTION_INT, &a->n_threads, "N", "default: one a processor", 1, 1024},
        {0},
    };
    const sheen_status s = sheen_cli_parse(cli, options, 1, 1, err);
    return s || cli->wants_help ? s : check(cli, a, err);
}

static void say_made(sheen_cli *cli, const char *path, size_t n_pictures)
{
    sheen_cli_clear_bar(cli);
    sheen_cli_say(cli, "%s", path);
    sheen_json_put_string(&cli->out, "made", path);
    sheen_json_put_int(&cli->out, "pictures", (long long)n_pictures);
}

static sheen_status render_view(sheen_cli *cli, const sheen_cli_view *v, const render_args *a, sheen_err *err)
{
    sheen_camera cam;
    double rt_cam_obj[6];
    sheen_status st = sheen_cli_view_pinhole(&cam, v, a->size_px, err);
    if (!st)
        st = sheen_cli_view_pose(rt_cam_obj, v, &cam, a->look, err);
    if (!st)
        st = sheen_cli_picture_save(&a->picture, v, &cam, rt_cam_obj, a->output, err);
    if (!st)
        say_made(cli, a->output, 1);
    return st;
}

// The camera of a view, scaled to the asked size.
static sheen_status camera_of(sheen_camera *out, sheen_cli *cli, const sheen_cli_view *v,
                              const sheen_pose_file *file, const sheen_view *view, const render_args *a,
                              sheen_err *err)
{
    const sheen_camera *cam = view->i_camera >= 0 ? &file->cameras[view->i_camera] : &v->camera;
    *out = *cam;
    memset(out->rt_cam_ref, 0, sizeof out->rt_cam_ref);
    if (!a->size_px[0])
        return SHEEN_OK;
    const double factor = (double)a->size_px[0] / cam->width_px;
    if (fabs(factor * cam->height_px - a->size_px[1]) > 1)
        return sheen_cli_usage(cli, err, "'--size' must keep the proportions of the poses' pictures, %d x %d",
                               cam->width_px, cam->height_px);
    const sheen_status st = sheen_camera_scale(out, cam, factor, err);
    out->width_px = a->size_px[0];
    out->height_px = a->size_px[1];
    return st;
}

static sheen_status render_pose(sheen_cli *cli, const sheen_cli_view *v, const sheen_pose_file *file,
                                const sheen_view *view, const render_args *a, sheen_err *err)
{
    char name[160], path[SHEEN_PATH_MAX];
    double rt_cam_obj[6];
    sheen_camera cam;
    snprintf(name, sizeof name, "%s.%s", view->name, a->format);
    sheen_rt_compose(rt_cam_obj, view->rt_cam_world, v->rt_board_obj);
    sheen_status st = sheen_path_join(path, a->output, name, err);
    if (!st)
        st = camera_of(&cam, cli, v, file, view, a, err);
    return st ? st : sheen_cli_picture_save(&a->picture, v, &cam, rt_cam_obj, path, err);
}

static sheen_status render_poses(sheen_cli *cli, const sheen_cli_view *v, const render_args *a,
                                 const sheen_progress *progress, sheen_err *err)
{
    sheen_pose_file file;
    sheen_status st = sheen_pose_file_load(&file, a->poses, err);
    if (st)
        return st;
    st = sheen_dir_make(a->output, err);
    for (size_t i = 0; !st && i < file.n_views; i++) {
        st = sheen_progress_step(progress, "pictures", (int)i, (int)file.n_views, err);
        if (!st)
            st = render_pose(cli, v, &file, &file.views[i], a, err);
    }
    if (!st)
        say_made(cli, a->output, file.n_views);
    sheen_pose_file_release(&file);
    return st;
}

static sheen_status render_orbit(sheen_cli *cli, const sheen_cli_view *v, const render_args *a,
                                 const sheen_progress *progress, sheen_err *err)
{
    const sheen_cli_orbit o = {.size_px = {a->size_px[0], a->size_px[1]},
                               .elevation_deg = a->elevation_deg,
                               .distance_m = a->distance_m,
                               .duration_s = a->duration_s,
                               .frames_per_s = a->frames_per_s,
                               .layer = a->picture.layer};
    const sheen_status st = sheen_cli_orbit_film(v, a->orbit, &o, progress, err);
    if (!st)
        say_made(cli, a->orbit, (size_t)fmax(1, round(a->duration_s * a->frames_per_s)));
    return st;
}

static sheen_status render_spin(sheen_cli *cli, const sheen_cli_view *v, const render_args *a,
                                const sheen_progress *progress, sheen_err *err)
{
    const sheen_cli_spin spin = {.size_px = {a->size_px[0], a->size_px[1]},
                                 .elevation_deg = a->elevation_deg,
                                 .distance_m = a->distance_m,
                                 .count = a->count,
                                 .format = a->format,
                                 .picture = a->picture};
    const sheen_status st = sheen_cli_spin_save(v, a->spin, &spin, progress, err);
    if (!st)
        say_made(cli, a->spin, (size_t)a->count);
    return st;
}

static sheen_status draw(sheen_cli *cli, const sheen_cli_view *v, const render_args *a, sheen_err *err)
{
    const sheen_progress progress = sheen_cli_progress(cli);
    if (a->view)
        return render_view(cli, v, a, err);
    if (a->poses)
        return render_poses(cli, v, a, &progress, err);
    return a->spin ? render_spin(cli, v, a, &progress, err) : render_orbit(cli, v, a, &progress, err);
}

static sheen_status run(sheen_cli *cli, sheen_err *err)
{
    render_args a;
    sheen_session s;
    sheen_cli_view v;
    sheen_status st = parse(cli, &a, err);
    if (st || cli->wants_help)
        return st;
    st = sheen_session_open(&s, cli->args[0], err);
    if (st)
        return st;
    st = sheen_cli_view_open(&v, &s, err);
    if (!st) {
        v.options.samples_per_side = a.samples;
        v.options.n_threads = a.n_threads;
        v.options.mark_holes = !a.changes.fill_holes;
        if (a.holes && !strcmp(a.holes, "black")) // a fit may have filled them
            memset(v.options.hole_rgb, 0, sizeof v.options.hole_rgb);
        v.lights_turn = a.lights && !strcmp(a.lights, "turn");
        v.turn_lights_rad = a.turn_lights_deg * rad_per_deg;
        if (a.turn_axis)
            memcpy(v.turn_axis_board, a.turn_axis_board, sizeof v.turn_axis_board);
        for (int c = 0; c < 3 && a.background; c++)
            v.options.background_rgb[c] = (float)a.background_rgb[c];
        st = sheen_cli_view_change(&v, &a.changes, err);
        if (!st)
            st = draw(cli, &v, &a, err);
        sheen_cli_view_close(&v);
    }
    sheen_session_release(&s);
    return st;
}

const sheen_command sheen_cmd_render = {
    .name = "render",
    .synopsis =
        "SESSION --poses FILE -o DIR | --view AZ,EL,DIST -o FILE | --orbit FILE | --spin DIR [options]",
    .summary = "pictures and films of the model from anywhere",
    .about = "Wants a fitted model in the session. With --poses through the lens of the cameras that the "
             "file names\n"
             "(or the session's own), otherwise through a pinhole of the session's field of view.\n",
    .example = "  sheen render penguin.session --view 30,25 -o penguin.png\n"
               "  sheen render penguin.session --orbit penguin.mp4 --size 640x480\n"
               "  sheen render penguin.session --spin penguin-360 --background 1,1,1 --holes fill\n",
    .run = run,
};

// SPDX-License-Identifier: Apache-2.0
// export_gltf.c - model.glb, its panorama and a reference picture.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/image_file.h"
#include "base/pose3.h"
#include "cli/export.h"
#include "fit/metrics.h"
#include "render/gltf.h"
#include "render/gltf_view.h"
#include "render/orbit.h"

// What shops ask of a model for the web: 3 MB, 150,000 triangles, textures of 2048 px.
enum { MAX_TRIANGLES = 150000, MAX_SIDE_PX = 2048, QUALITY = 90, LEAST_QUALITY = 60, LEAST_TRIANGLES = 1000 };
static const double max_bytes = 3e6;
static const double rad_per_deg = 3.14159265358979323846 / 180;

// Reference picture: size and what it is drawn over.
static const int reference_size_px[2] = {1920, 1080};

// "<folder>/<name><ending>" beside the output, which ends in .glb.
static sheen_status beside(char path[SHEEN_PATH_MAX], const char *output, const char *ending, sheen_err *err)
{
    const size_t stem = strlen(output) - strlen(sheen_path_extension(output)) - 1;
    const int n = snprintf(path, SHEEN_PATH_MAX, "%.*s%s", (int)stem, output, ending);
    return n > 0 && n < SHEEN_PATH_MAX
               ? SHEEN_OK
               : sheen_fail(err, SHEEN_EARG, "the path '%.80s...' is too long", output);
}

// How the object stands under the lights. Where it was turned before lights that stand still in front of the camera, no
// panorama can follow: it is right for the first view.
static sheen_status light_pose(double rt_world_obj[6], const sheen_cli_view *v, const double look_deg[2],
                               sheen_err *err)
{
    sheen_camera cam;
    memcpy(rt_world_obj, v->model.rt_world_obj, sizeof v->model.rt_world_obj);
    if (v->model.moving != SHEEN_MOVING_OBJECT)
        return SHEEN_OK;
    const sheen_status s = sheen_cli_view_pinhole(&cam, v, reference_size_px, err);
    return s ? s
             : sheen_view_pose(rt_world_obj, &v->model.mesh, v->rt_board_obj, &cam, look_deg[0] * rad_per_deg,
                               look_deg[1] * rad_per_deg, 0, err);
}

// Coarser pictures first, then fewer triangles, until the file is within its size.
static sheen_status make(sheen_gltf *out, const sheen_model *model, sheen_gltf_options *o, sheen_err *err)
{
    for (;;) {
        const sheen_status s = sheen_gltf_make(out, model, o, err);
        if (s || (double)out->glb_bytes <= max_bytes)
            return s;
        if (o->jpeg_quality > LEAST_QUALITY)
            o->jpeg_quality -= 15;
        else if (out->n_triangles > LEAST_TRIANGLES && o->max_triangles > LEAST_TRIANGLES)
            o->max_triangles = out->n_triangles * 3 / 4;
        else
            return SHEEN_OK;
        sheen_gltf_release(out);
    }
}

// How well a viewer that keeps to glTF agrees with `sheen render`, over surface that a photograph saw.
typedef struct agreement {
    double mean_db, worst_db;
} agreement;

enum { N_VIEWS = 6 };
static const int measured_size_px[2] = {400, 300};
static const double most_db = 99; // identical pictures have no finite figure

static sheen_status compare(double *db, const sheen_gltf *g, const sheen_gltf_options *o,
                            const sheen_drawing *d, const sheen_camera *cam, const double rt_cam_obj[6],
                            int n_threads, sheen_err *err)
{
    const sheen_draw_options options = {.samples_per_side = 1, .n_threads = n_threads};
    sheen_layers model = {0};
    sheen_image shown = {0};
    uint8_t *select = NULL;
    sheen_status s = sheen_draw(&model, d, cam, rt_cam_obj, o->rt_world_obj, &options, err);
    if (!s)
        s = sheen_gltf_view(&shown, g, cam, rt_cam_obj, options.background_rgb, n_threads, err);
    const size_t n = (size_t)cam->width_px * (size_t)cam->height_px;
    if (!s && !(select = malloc(n)))
        s = sheen_fail_memory(err, (double)n, "a mask");
    for (size_t i = 0; !s && i < n; i++)
        select[i] = model.coverage.data[i] > 0.5f && !(model.holes.data[i] > 0);
    if (!s)
        *db = sheen_psnr_of(&shown, &model.composite, select).srgb_db;
    free(select);
    sheen_image_release(&shown);
    sheen_layers_release(&model);
    return s;
}

// Views all around, at the first one's elevation.
static sheen_status measure(agreement *out, const sheen_gltf *g, const sheen_gltf_options *o,
                            const sheen_cli_view *v, const double look_deg[2], int n_threads, sheen_err *err)
{
    sheen_camera cam;
    sheen_drawing *d = NULL;
    int n_counted = 0;
    *out = (agreement){.worst_db = most_db};
    sheen_status s = sheen_cli_view_pinhole(&cam, v, measured_size_px, err);
    if (!s)
        s = sheen_drawing_new(&d, &v->model, err);
    for (int i = 0; !s && i < N_VIEWS; i++) {
        double rt_cam_obj[6], db = (double)NAN;
        s = sheen_view_pose(rt_cam_obj, &v->model.mesh, v->rt_board_obj, &cam,
                            (look_deg[0] + 360.0 * i / N_VIEWS) * rad_per_deg, look_deg[1] * rad_per_deg, 0,
                            err);
        if (!s)
            s = compare(&db, g, o, d, &cam, rt_cam_obj, n_threads, err);
        if (isnan(db))
            continue;
        n_counted++;
        out->mean_db += fmin(db, most_db);
        out->worst_db = fmin(out->worst_db, db);
    }
    sheen_drawing_free(&d);
    out->mean_db = n_counted ? out->mean_db / n_counted : (double)NAN;
    return s;
}

static sheen_status write_reference(const char *path, const sheen_cli_view *v, const double look_deg[2],
                                    sheen_err *err)
{
    sheen_camera cam;
    sheen_layers layers = {0};
    const double look[3] = {look_deg[0], look_deg[1], 0};
    sheen_status s = sheen_cli_view_pinhole(&cam, v, reference_size_px, err);
    if (!s)
        s = sheen_cli_view_look(&layers, v, &cam, look, err);
    if (!s)
        s = sheen_png_write_srgb(path, &layers.composite, err);
    sheen_layers_release(&layers);
    return s;
}

static void say_agreement(sheen_cli *cli, const agreement *a)
{
    if (isnan(a->mean_db))
        return;
    sheen_cli_say(
        cli,
        "  under its panorama within %.1f dB of this model's own drawings (mean of %d views; worst %.1f)",
        a->mean_db, N_VIEWS, a->worst_db);
    sheen_json_put_number(&cli->out, "agreement_db", a->mean_db);
    sheen_json_put_number(&cli->out, "worst_agreement_db", a->worst_db);
}

static void say(sheen_cli *cli, const sheen_gltf *g, const char *output, const char *panorama,
                const char *reference, const double look_deg[2], double focal_per_width)
{
    sheen_cli_say(cli, "%s: %.0f kB, %zu triangles, texture of %d px a side", output,
                  (double)g->glb_bytes / 1e3, g->n_triangles, g->side_px);
    sheen_cli_say(cli, "  roughness %.3f, reflectance %.3f; y up, metres, the foot at the origin",
                  g->roughness, g->f0);
    if (g->moved_m > 0)
        sheen_cli_say(cli, "  simplified: the surface moved by up to about %.2g mm", 1e3 * g->moved_m);
    if (g->n_lights)
        sheen_cli_say(cli, "  %d punctual lights", g->n_lights);
    sheen_cli_say(cli, "%s: the light; %s: how it should look from azimuth %.0f, elevation %.0f", panorama,
                  reference, round(look_deg[0]) + 0.0, round(look_deg[1]) + 0.0); // + 0: no minus before a 0
    sheen_json_put_string(&cli->out, "made", output);
    sheen_json_put_string(&cli->out, "panorama", panorama);
    sheen_json_put_string(&cli->out, "reference", reference);
    sheen_json_put_int(&cli->out, "size_bytes", (long long)g->glb_bytes);
    sheen_json_put_int(&cli->out, "triangles", (long long)g->n_triangles);
    sheen_json_put_int(&cli->out, "texture_px", g->side_px);
    sheen_json_put_int(&cli->out, "lights", g->n_lights);
    sheen_json_put_number(&cli->out, "roughness", g->roughness);
    sheen_json_put_number(&cli->out, "reflectance", g->f0);
    sheen_json_put_number(&cli->out, "moved_m", g->moved_m);
    sheen_json_put_number(&cli->out, "dome", g->dome_lin);
    sheen_json_put_number(&cli->out, "clipped", g->clipped);
    sheen_json_put_numbers(&cli->out, "first_view_deg", look_deg, 2);
    sheen_json_put_numbers(&cli->out, "middle_gltf", g->middle_gltf, 3);
    sheen_json_put_number(&cli->out, "focal_per_width", focal_per_width);
    sheen_json_put_numbers(&cli->out, "R_gltf_obj", &g->R_gltf_obj[0][0], 9);
    sheen_json_put_numbers(&cli->out, "t_gltf_obj", g->t_gltf_obj, 3);
    if ((double)g->glb_bytes > max_bytes) {
        sheen_cli_warn(cli, "'%s' is larger than the %g MB that shops take", output, max_bytes / 1e6);
        cli->limit_missed = true;
    }
}

sheen_status sheen_export_gltf(sheen_cli *cli, const sheen_export_args *a, const sheen_session *s,
                               const sheen_cli_view *v, sheen_err *err)
{
    char panorama[SHEEN_PATH_MAX], reference[SHEEN_PATH_MAX], title[256];
    double look_deg[2], rt_world_obj[6];
    sheen_gltf g = {0};
    agreement near = {0};
    sheen_export_title(title, a, s);
    sheen_gltf_options o = {.title = title,
                            .rt_board_obj = v->rt_board_obj,
                            .rt_world_obj = rt_world_obj,
                            .max_triangles = MAX_TRIANGLES,
                            .max_side_px = MAX_SIDE_PX,
                            .jpeg_quality = QUALITY,
                            .n_lights = a->n_lights,
                            .n_threads = a->n_threads};
    sheen_status st = beside(panorama, a->output, "-environment.hdr", err);
    if (!st)
        st = beside(reference, a->output, "-reference.png", err);
    if (!st)
        st = sheen_export_first_view(look_deg, v, s, err);
    if (!st)
        st = light_pose(rt_world_obj, v, look_deg, err);
    if (!st)
        st = make(&g, &v->model, &o, err);
    if (st)
        return st;
    st = sheen_file_write(a->output, g.glb, g.glb_bytes, err);
    if (!st)
        st = sheen_hdr_write(panorama, &g.panorama, err);
    if (!st)
        st = write_reference(reference, v, look_deg, err);
    if (!st)
        st = measure(&near, &g, &o, v, look_deg, a->n_threads, err);
    if (!st) {
        say(cli, &g, a->output, panorama, reference, look_deg, v->camera.intrinsics[0] / v->camera.width_px);
        say_agreement(cli, &near);
    }
    sheen_gltf_release(&g);
    return st;
}

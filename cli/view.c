// SPDX-License-Identifier: Apache-2.0
// view.c - a session's model seen from anywhere: single pictures and a film once about it.
#include <math.h>
#include <string.h>

#include <stdbool.h>

#include "base/image_file.h"
#include "base/pose3.h"
#include "cli/stages.h"
#include "fit/fill_holes.h"
#include "render/orbit.h"
#include "render/panorama_lamps.h"

static const double rad_per_deg = 3.14159265358979323846 / 180;

sheen_status sheen_cli_view_open(sheen_cli_view *v, const sheen_session *s, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    *v = (sheen_cli_view){
        .turn_axis_board = {0, 0, 1},
        .options = {.mark_holes = 1, .hole_rgb = {1, 0, 1}, .background_rgb = {0.03f, 0.03f, 0.03f}}};
    sheen_model_init(&v->model);
    sheen_status st = sheen_model_load(&v->model, s, err);
    if (!st)
        st = sheen_registration_load(v->rt_board_obj, s, err);
    if (!st)
        st = sheen_session_path(path, s, SHEEN_SESSION_CAMERA, err);
    if (!st)
        st = sheen_camera_load(&v->camera, path, err);
    if (!st)
        st = sheen_drawing_new(&v->drawing, &v->model, err);
    if (st)
        sheen_cli_view_close(v);
    return st;
}

void sheen_cli_view_close(sheen_cli_view *v)
{
    sheen_drawing_free(&v->drawing);
    sheen_model_release(&v->model);
}

sheen_status sheen_cli_view_pinhole(sheen_camera *out, const sheen_cli_view *v, const int size_px[2],
                                    sheen_err *err)
{
    const sheen_camera *c = &v->camera;
    const int width_px = size_px[0] ? size_px[0] : c->width_px,
              height_px = size_px[1] ? size_px[1] : c->height_px;
    const double f_px = c->intrinsics[0] * width_px / c->width_px;
    const double fxycxy[4] = {f_px, f_px, (width_px - 1) / 2.0, (height_px - 1) / 2.0};
    return sheen_camera_opencv(out, width_px, height_px, fxycxy, NULL, 0, err);
}

sheen_status sheen_cli_view_draw(sheen_layers *layers, const sheen_cli_view *v, const sheen_camera *cam,
                                 const double rt_cam_obj[6], sheen_err *err)
{
    // Turning the lights one way is turning the object the other way under them.
    const double *axis = v->turn_axis_board,
                 rt_turn[6] = {-v->turn_lights_rad * axis[0], -v->turn_lights_rad * axis[1],
                               -v->turn_lights_rad * axis[2]};
    double rt_obj_board[6], rt_turned_obj[6], rt_obj_turned[6], rt_world_obj[6], rt_place[6];
    sheen_rt_invert(rt_obj_board, v->rt_board_obj);
    sheen_rt_compose(rt_turned_obj, rt_turn, v->rt_board_obj);
    sheen_rt_compose(rt_obj_turned, rt_obj_board, rt_turned_obj);
    sheen_model_place(rt_place, &v->model, rt_cam_obj);
    sheen_rt_compose(rt_world_obj, v->lights_turn ? v->model.rt_world_obj : rt_place, rt_obj_turned);
    if (v->turn_lights_rad == 0)
        memcpy(rt_world_obj, v->lights_turn ? v->model.rt_world_obj : rt_place, sizeof rt_world_obj);
    return sheen_redraw(layers, v->drawing, cam, rt_cam_obj, rt_world_obj, &v->options, err);
}

sheen_status sheen_cli_view_pose(double rt_cam_obj[6], const sheen_cli_view *v, const sheen_camera *cam,
                                 const double look[3], sheen_err *err)
{
    return sheen_view_pose(rt_cam_obj, &v->model.mesh, v->rt_board_obj, cam, look[0] * rad_per_deg,
                           look[1] * rad_per_deg, look[2], err);
}

sheen_status sheen_cli_view_look(sheen_layers *layers, const sheen_cli_view *v, const sheen_camera *cam,
                                 const double look[3], sheen_err *err)
{
    double rt_cam_obj[6];
    const sheen_status st = sheen_cli_view_pose(rt_cam_obj, v, cam, look, err);
    return st ? st : sheen_cli_view_draw(layers, v, cam, rt_cam_obj, err);
}

// The picture's light, as a surface with the reflectance of glass mirrors it.
static sheen_status light_by_panorama(sheen_model *m, const char *path, sheen_err *err)
{
    enum { LAMPS = 512 };
    sheen_raster raster;
    sheen_image panorama = {0};
    sheen_status st = sheen_raster_load(&raster, path, err);
    if (st)
        return st;
    st = sheen_image_from_raster(&panorama, &raster, SHEEN_TRANSFER_SRGB, err);
    sheen_raster_release(&raster);
    if (!st)
        st = sheen_model_light_by_panorama(m, &panorama, LAMPS, SHEEN_DIELECTRIC_F0, err);
    sheen_image_release(&panorama);
    return st ? sheen_wrap(err, st, "cannot light the model by '%s'", path) : SHEEN_OK;
}

sheen_status sheen_cli_view_change(sheen_cli_view *v, const sheen_cli_changes *c, sheen_err *err)
{
    sheen_model *m = &v->model;
    const double rgb[3] = {c->k_s_factor * c->tint_rgb[0], c->k_s_factor * c->tint_rgb[1],
                           c->k_s_factor * c->tint_rgb[2]};
    m->sigma_rad = c->sigma_rad > 0 ? c->sigma_rad : m->sigma_rad;
    sheen_drawing_free(&v->drawing); // keeps what it made of the model before
    sheen_status st = c->panorama ? light_by_panorama(m, c->panorama, err) : SHEEN_OK;
    sheen_model_scale_highlights(m, rgb);
    if (!st && c->fill_holes)
        st = sheen_fill_holes(&m->texture, &m->mesh, err);
    return st ? st : sheen_drawing_new(&v->drawing, m, err);
}

const sheen_image *sheen_cli_layer(const sheen_layers *l, const char *layer)
{
    if (layer && !strcmp(layer, "diffuse"))
        return &l->diffuse;
    if (layer && !strcmp(layer, "specular"))
        return &l->specular;
    return &l->composite;
}

sheen_status sheen_cli_orbit_film(const sheen_cli_view *v, const char *path, const sheen_cli_orbit *o,
                                  const sheen_progress *progress, sheen_err *err)
{
    sheen_camera cam;
    sheen_film *film = NULL;
    sheen_layers layers = {0};
    const int n = (int)fmax(1, round(o->duration_s * o->frames_per_s));
    sheen_status st = sheen_cli_view_pinhole(&cam, v, o->size_px, err);
    if (!st)
        st = sheen_film_open(&film, path, cam.width_px, cam.height_px, o->frames_per_s, err);
    for (int i = 0; !st && i < n; i++) {
        const double look[3] = {360.0 * i / n, o->elevation_deg, o->distance_m};
        st = sheen_progress_step(progress, "film", i, n, err);
        if (!st)
            st = sheen_cli_view_look(&layers, v, &cam, look, err);
        if (!st)
            st = sheen_film_add(film, sheen_cli_layer(&layers, o->layer), err);
    }
    sheen_layers_release(&layers);
    if (film) {
        const sheen_status closed = sheen_film_close(&film, !st, st ? NULL : err);
        st = st ? st : closed;
    }
    return st ? st : sheen_progress_step(progress, "film", n, n, err);
}

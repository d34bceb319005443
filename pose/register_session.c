// SPDX-License-Identifier: Apache-2.0
// register_session.c - registration on a session's files: camera, poses, masks and pictures in, overlays out.
#include "pose/register_session.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/image_file.h"
#include "pose/session_masks.h"

enum { MAX_VIEWS = 24, MAX_MADE = 12, MAX_OVERLAYS = 12 };

// A frame with a pose, and what it shows.
typedef struct seen {
    const sheen_frame_info *frame;
    const sheen_frame_pose *pose;
    sheen_image mask, light;
} seen;

typedef struct inputs {
    sheen_camera camera;
    sheen_poses poses;
    seen *seen;
    size_t n_seen, n_masks, n_backgrounds;
} inputs;

static sheen_status load_files(inputs *in, const sheen_session *s, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    if (!sheen_session_has(s, SHEEN_SESSION_CAMERA))
        return sheen_fail(err, SHEEN_EDATA, "session '%s' has no '%s': calibrate first, or import a camera",
                          s->path, SHEEN_SESSION_CAMERA);
    if (!sheen_session_has(s, SHEEN_SESSION_POSES))
        return sheen_fail(err, SHEEN_EDATA, "session '%s' has no poses: run sheen pose first, or import them",
                          s->path);
    sheen_status st = sheen_session_path(path, s, SHEEN_SESSION_CAMERA, err);
    if (!st)
        st = sheen_camera_load(&in->camera, path, err);
    return st ? st : sheen_poses_load(&in->poses, s, err);
}

// The frames to look at: input frames with a pose, at most MAX_VIEWS of them, evenly chosen.
static sheen_status load_views(inputs *in, const sheen_session *s, sheen_err *err)
{
    size_t n = 0;
    in->seen = calloc(s->n_frames + 1, sizeof *in->seen);
    if (!in->seen)
        return sheen_fail_memory(err, (double)s->n_frames * sizeof *in->seen, "frames");
    for (size_t i = 0; i < s->n_frames; i++) {
        const sheen_frame_pose *p = sheen_poses_find(&in->poses, s->frames[i].name);
        if (s->frames[i].role == SHEEN_ROLE_INPUT && p && p->found)
            in->seen[n++] = (seen){.frame = &s->frames[i], .pose = p};
    }
    if (!n)
        return sheen_fail(err, SHEEN_EDATA, "no input frame of session '%s' has a pose", s->path);
    for (size_t i = 0; i < n; i++)
        if (n <= MAX_VIEWS || i * MAX_VIEWS / n != (i + 1) * MAX_VIEWS / n)
            in->seen[in->n_seen++] = in->seen[i];
    for (size_t i = 0; i < in->n_seen; i++) {
        seen *v = &in->seen[i];
        if (v->frame->width_px != in->camera.width_px || v->frame->height_px != in->camera.height_px)
            return sheen_fail(err, SHEEN_EDATA, "frame '%s' is %d x %d px but '%s' is for %d x %d",
                              v->frame->name, v->frame->width_px, v->frame->height_px, SHEEN_SESSION_CAMERA,
                              in->camera.width_px, in->camera.height_px);
        sheen_status st = sheen_session_mask(&v->mask, s, v->frame, err);
        if (!st)
            st = sheen_session_grey(&v->light, s, v->frame, err);
        if (st)
            return st;
        in->n_masks += v->mask.data != NULL;
    }
    return SHEEN_OK;
}

static sheen_status by_masks(sheen_register_result *out, const inputs *in, const sheen_mesh *mesh,
                             const sheen_register_session_options *o, sheen_err *err)
{
    sheen_register_view views[MAX_VIEWS];
    size_t n = 0;
    for (size_t i = 0; i < in->n_seen; i++)
        if (in->seen[i].mask.data) {
            views[n] = (sheen_register_view){.mask = &in->seen[i].mask, .light = &in->seen[i].light};
            memcpy(views[n++].rt_cam_board, in->seen[i].pose->rt_cam_board, sizeof views[0].rt_cam_board);
        }
    sheen_register_options search = o->search;
    search.rough_masks = out->masks_made;
    search.edges = search.edges || out->masks_made; // there the pictures themselves are sharper
    out->from_masks = true;
    return out->from_points
               ? sheen_register_refine(&out->registration, mesh, &in->camera, views, n,
                                       &out->points.placement, &search, err)
               : sheen_register_search(&out->registration, mesh, &in->camera, views, n, &search, err);
}

// Masks of at most MAX_MADE frames, evenly chosen, where the session has none.
static sheen_status make_masks(inputs *in, const sheen_session *s, int n_threads, sheen_err *err)
{
    const sheen_frame_info *frames[MAX_MADE];
    sheen_image masks[MAX_MADE] = {{0}};
    const size_t n = in->n_seen < MAX_MADE ? in->n_seen : MAX_MADE;
    for (size_t i = 0; i < n; i++)
        frames[i] = in->seen[i * in->n_seen / n].frame;
    sheen_session_masks made = {.masks = masks};
    const sheen_status st = sheen_session_masks_make(&made, s, &in->camera, &in->poses, frames, n, n_threads,
                                                     err);
    for (size_t i = 0; i < n && !st; i++)
        in->seen[i * in->n_seen / n].mask = masks[i];
    in->n_masks = st ? 0 : n;
    in->n_backgrounds = made.n_backgrounds;
    return st;
}

static sheen_status find(sheen_register_result *out, inputs *in, const sheen_session *s,
                         const sheen_mesh *mesh, const sheen_register_session_options *o, sheen_err *err)
{
    sheen_status st = SHEEN_OK;
    if (o->points) {
        st = sheen_register_points_solve(&out->points, o->points, o->n_points, &in->camera, &in->poses,
                                         o->search.unit_m, err);
        out->from_points = true;
        out->registration.placement = out->points.placement;
        out->registration.sigma_rad = out->points.sigma_rad;
        out->registration.sigma_m = out->points.sigma_m;
    }
    if (st)
        return st;
    if (!in->n_masks && !o->points) {
        if ((st = make_masks(in, s, o->search.n_threads, err)))
            return sheen_wrap(
                err, st,
                "the session has no masks to find the mesh by (sheen import --masks), no points are "
                "marked (--points), and what hides the board cannot be told");
        out->masks_made = true;
        out->n_backgrounds = in->n_backgrounds;
    }
    return in->n_masks ? by_masks(out, in, mesh, o, err) : SHEEN_OK;
}

// The frame, darker, with the outline over it.
static sheen_status draw_overlay(const char *path, const seen *v, const inputs *in,
                                 const sheen_outline_mesh *mesh, const sheen_placement *placement,
                                 sheen_outline *outline, sheen_err *err)
{
    const int w = in->camera.width_px, h = in->camera.height_px;
    sheen_outline_canvas canvas = {.camera = &in->camera, .factor = 1, .width_px = w, .height_px = h};
    sheen_raster picture;
    sheen_Rt_from_rt(&canvas.Rt_cam_board, v->pose->rt_cam_board);
    sheen_status st = sheen_outline_draw(outline, mesh, placement, &canvas, 0.4, err);
    if (!st)
        st = sheen_raster_init(&picture, w, h, 3, 8, err);
    if (st)
        return st;
    uint8_t *pixels = picture.data;
    for (size_t i = 0; i < (size_t)w * (size_t)h; i++)
        for (size_t c = 0; c < 3; c++)
            pixels[3 * i + c] = (uint8_t)(170 * v->light.data[i]);
    for (size_t i = 0; i < outline->n_samples; i++) {
        const long x = lrint(outline->samples[i].q_px[0]), y = lrint(outline->samples[i].q_px[1]);
        if (x >= 0 && y >= 0 && x < w && y < h)
            memcpy(pixels + 3 * ((size_t)y * (size_t)w + (size_t)x), (const uint8_t[3]){40, 255, 90}, 3);
    }
    st = sheen_png_write(path, &picture, err);
    sheen_raster_release(&picture);
    return st;
}

static sheen_status write_overlays(sheen_register_result *out, const sheen_session *s, const inputs *in,
                                   const sheen_mesh *mesh, sheen_err *err)
{
    char folder[SHEEN_PATH_MAX], path[SHEEN_PATH_MAX], name[80];
    sheen_outline_mesh outlined;
    sheen_outline outline = {0};
    sheen_status st = sheen_outline_mesh_make(&outlined, mesh, err);
    if (st)
        return st;
    st = sheen_session_path(folder, s, SHEEN_SESSION_OVERLAYS, err);
    if (!st)
        st = sheen_dir_make(folder, err);
    for (size_t i = 0; i < in->n_seen && i < MAX_OVERLAYS && !st; i++) {
        snprintf(name, sizeof name, "%s.png", in->seen[i].frame->name);
        st = sheen_path_join(path, folder, name, err);
        if (!st)
            st = draw_overlay(path, &in->seen[i], in, &outlined, &out->registration.placement, &outline, err);
        out->n_overlays += !st;
    }
    sheen_outline_release(&outline);
    sheen_outline_mesh_release(&outlined);
    return st;
}

sheen_status sheen_register_in_session(sheen_register_result *out, const sheen_session *s,
                                       const sheen_mesh *mesh, const sheen_register_session_options *options,
                                       sheen_err *err)
{
    inputs in = {0};
    *out = (sheen_register_result){0};
    sheen_status st = load_files(&in, s, err);
    if (!st)
        st = load_views(&in, s, err);
    if (!st)
        st = find(out, &in, s, mesh, options, err);
    out->n_masks = in.n_masks;
    if (!st)
        st = write_overlays(out, s, &in, mesh, err);
    for (size_t i = 0; i < in.n_seen; i++) {
        sheen_image_release(&in.seen[i].mask);
        sheen_image_release(&in.seen[i].light);
    }
    free(in.seen);
    sheen_poses_release(&in.poses);
    return st;
}

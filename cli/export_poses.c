// SPDX-License-Identifier: Apache-2.0
// export_poses.c - photographs and their poses for other programs: transforms.json, or a COLMAP text model.
//
// World is the board's frame, metres. Pictures are put beside as they are (JPEG, PNG), developed to PNG where they are raw.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/camera_undistort.h"
#include "base/file.h"
#include "base/image_file.h"
#include "base/pose3.h"
#include "base/pose_file.h"
#include "cli/export.h"

typedef struct posed {
    sheen_view *views;
    size_t count;
} posed;

// straight: the pinhole to which pictures are straightened, or NULL: as they are.
static sheen_status put_picture(char name[sizeof((sheen_view *)0)->file], const sheen_session *s,
                                const sheen_frame_info *f, const char *dir, const sheen_camera *cam,
                                const sheen_camera *straight, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    const char *ending = sheen_path_extension(f->file);
    const bool as_it_is = !straight && (!strcasecmp(ending, "jpg") || !strcasecmp(ending, "jpeg") ||
                                        !strcasecmp(ending, "png"));
    snprintf(name, sizeof((sheen_view *)0)->file, "%s.%s", f->name, as_it_is ? ending : "png");
    sheen_status st = sheen_path_join(path, dir, name, err);
    if (st)
        return st;
    if (as_it_is) {
        uint8_t *data;
        size_t size_bytes;
        if ((st = sheen_session_payload(&data, &size_bytes, s, f, err)))
            return st;
        st = sheen_file_write(path, data, size_bytes, err);
        free(data);
        return st;
    }
    sheen_image lin, straightened = {0};
    if ((st = sheen_session_image(&lin, s, f, err)))
        return st;
    if (straight)
        st = sheen_image_undistort(&straightened, &lin, cam, straight, 0, err);
    if (!st)
        st = sheen_png_write_srgb(path, straight ? &straightened : &lin, err);
    sheen_image_release(&straightened);
    sheen_image_release(&lin);
    return st;
}

// Input and scoring frames that have a pose, and their pictures in dir: as they are where the file has a place for the
// lens, otherwise straightened. *written is the camera that belongs to them.
static sheen_status gather(posed *out, sheen_camera *written, const sheen_session *s, const char *dir,
                           const sheen_cli_view *v, bool holds, const sheen_progress *progress,
                           sheen_err *err)
{
    static const int own_size_px[2] = {0, 0};
    sheen_poses poses;
    *out = (posed){.count = 0};
    *written = v->camera;
    sheen_status st = holds ? SHEEN_OK : sheen_cli_view_pinhole(written, v, own_size_px, err);
    if (!st)
        st = sheen_poses_load(&poses, s, err);
    if (st)
        return st;
    out->views = calloc(poses.n_poses + 1, sizeof *out->views);
    st = out->views ? sheen_dir_make(dir, err)
                    : sheen_fail_memory(err, (double)(poses.n_poses * sizeof *out->views), "poses");
    for (size_t i = 0; !st && i < poses.n_poses; i++) {
        const sheen_frame_info *f = sheen_session_find(s, poses.poses[i].name);
        if (!f || !poses.poses[i].found || !sheen_role_shows_object(f->role))
            continue;
        sheen_view *view = &out->views[out->count];
        st = sheen_progress_step(progress, "pictures", (int)i, (int)poses.n_poses, err);
        if (!st)
            st = put_picture(view->file, s, f, dir, &v->camera, holds ? NULL : written, err);
        snprintf(view->name, sizeof view->name, "%s", f->name);
        memcpy(view->rt_cam_world, poses.poses[i].rt_cam_board, sizeof view->rt_cam_world);
        out->count += !st;
    }
    sheen_poses_release(&poses);
    if (!st && !out->count)
        st = sheen_fail(err, SHEEN_EDATA, "session '%s' has no frame with a pose yet", s->path);
    if (st)
        free(out->views);
    return st;
}

static void say(sheen_cli *cli, const char *output, size_t n, const sheen_camera *written,
                const sheen_camera *own)
{
    sheen_cli_clear_bar(cli);
    sheen_cli_say(cli, "%s: %zu picture%s with poses in the board's frame, metres", output, n,
                  sheen_cli_plural(n));
    const bool straightened = strcmp(written->lensmodel, own->lensmodel) != 0;
    if (straightened)
        sheen_cli_say(cli, "its pictures are straightened: files of its kind have no place for the lens %s",
                      own->lensmodel);
    sheen_json_put_bool(&cli->out, "straightened", straightened);
    sheen_json_put_string(&cli->out, "made", output);
    sheen_json_put_int(&cli->out, "views", (long long)n);
}

sheen_status sheen_export_transforms(sheen_cli *cli, const sheen_export_args *a, const sheen_session *s,
                                     const sheen_cli_view *v, sheen_err *err)
{
    char dir[SHEEN_PATH_MAX];
    const sheen_progress progress = sheen_cli_progress(cli);
    posed p;
    const size_t parent = (size_t)(sheen_path_base(a->output) - a->output);
    const int n = snprintf(dir, sizeof dir, "%.*simages", (int)parent, a->output);
    if (n < 0 || n >= SHEEN_PATH_MAX)
        return sheen_fail(err, SHEEN_EARG, "the path '%.80s...' is too long", a->output);
    sheen_camera written;
    sheen_status st = gather(&p, &written, s, dir, v, sheen_transforms_holds(&v->camera), &progress, err);
    if (st)
        return st;
    for (size_t i = 0; i < p.count; i++) {
        char file[sizeof p.views[i].file];
        snprintf(file, sizeof file, "images/%.500s", p.views[i].file);
        memcpy(p.views[i].file, file, sizeof file);
    }
    st = sheen_transforms_save(a->output, &written, p.views, p.count, err);
    if (!st)
        say(cli, a->output, p.count, &written, &v->camera);
    free(p.views);
    return st;
}

// The mesh's vertices as COLMAP's points, so that what begins from them has some.
static sheen_status save_colmap(const char *dir, const sheen_cli_view *v, const sheen_camera *written,
                                const posed *p, sheen_err *err)
{
    const sheen_mesh *mesh = &v->model.mesh;
    uint8_t *rgba;
    float *p_board = malloc(3 * mesh->n_vertices * sizeof *p_board);
    uint8_t *rgb = malloc(3 * mesh->n_vertices);
    sheen_status st = sheen_export_vertex_colours(&rgba, &v->model, err);
    if (!st && (!p_board || !rgb))
        st = sheen_fail_memory(err, 15.0 * (double)mesh->n_vertices, "points");
    if (!st) {
        sheen_Rt board_obj;
        sheen_Rt_from_rt(&board_obj, v->rt_board_obj);
        for (size_t i = 0; i < mesh->n_vertices; i++) {
            const double x[3] = {(double)mesh->p_obj[3 * i], (double)mesh->p_obj[3 * i + 1],
                                 (double)mesh->p_obj[3 * i + 2]};
            double x_board[3];
            sheen_Rt_point(x_board, &board_obj, x);
            for (size_t k = 0; k < 3; k++) {
                p_board[3 * i + k] = (float)x_board[k];
                rgb[3 * i + k] = rgba[4 * i + k];
            }
        }
        st = sheen_colmap_save(dir, written, p->views, p->count, p_board, rgb, mesh->n_vertices, err);
    }
    free(rgba);
    free(p_board);
    free(rgb);
    return st;
}

sheen_status sheen_export_colmap(sheen_cli *cli, const sheen_export_args *a, const sheen_session *s,
                                 const sheen_cli_view *v, sheen_err *err)
{
    char images[SHEEN_PATH_MAX], sparse[SHEEN_PATH_MAX];
    const sheen_progress progress = sheen_cli_progress(cli);
    sheen_camera written;
    posed p;
    sheen_status st = sheen_path_join(images, a->output, "images", err);
    if (!st)
        st = sheen_path_join(sparse, a->output, "sparse/0", err);
    if (!st)
        st = gather(&p, &written, s, images, v, sheen_colmap_holds(&v->camera), &progress, err);
    if (st)
        return st;
    st = save_colmap(sparse, v, &written, &p, err);
    if (!st)
        say(cli, a->output, p.count, &written, &v->camera);
    free(p.views);
    return st;
}

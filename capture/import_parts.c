// SPDX-License-Identifier: Apache-2.0
// import_parts.c - the mesh, the masks and the boards: each is read by its own parser first, then copied as it is.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/board.h"
#include "base/mesh.h"
#include "capture/import_job.h"

static const size_t mask_max_bytes = (size_t)256 << 20;

static sheen_status stage_copy(import_job *job, const char *file, const char *from_path, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    const sheen_status s = sheen_session_path(path, &job->staged, file, err);
    return s ? s : sheen_file_copy(path, from_path, err);
}

static sheen_status import_board(import_job *job, const char *file, const char *from_path, sheen_err *err)
{
    if (!from_path)
        return SHEEN_OK;
    sheen_board board;
    const sheen_status s = sheen_board_load(&board, from_path, err);
    if (s)
        return s;
    sheen_board_release(&board);
    return stage_copy(job, file, from_path, err);
}

sheen_status sheen_import_boards(import_job *job, sheen_err *err)
{
    const sheen_status s = import_board(job, SHEEN_SESSION_BOARD, job->options->board, err);
    return s ? s : import_board(job, SHEEN_SESSION_CALIBRATION_BOARD, job->options->calibration_board, err);
}

sheen_status sheen_import_mesh(import_job *job, sheen_err *err)
{
    static const char *const files[] = {"mesh.ply", "mesh.obj", "mesh.glb"};
    static const double rt_identity[6] = {0};
    const char *path = job->options->mesh, *file = NULL;
    if (!path)
        return SHEEN_OK;
    for (size_t i = 0; i < sizeof files / sizeof *files; i++)
        if (!strcasecmp(sheen_path_extension(path), sheen_path_extension(files[i])))
            file = files[i];
    if (!file)
        return sheen_fail(err, SHEEN_EARG, "'%s' is no kind of mesh that is read: use .ply, .obj or .glb",
                          path);
    sheen_mesh mesh;
    sheen_status s = sheen_mesh_load(&mesh, path, err);
    if (s)
        return s;
    sheen_mesh_release(&mesh);
    s = stage_copy(job, file, path, err);
    // The registration of the mesh that was there does not hold for this one.
    if (!s && (job->options->rt_board_obj || sheen_session_has(job->session, SHEEN_SESSION_REGISTRATION)))
        s = sheen_registration_save(job->options->rt_board_obj ? job->options->rt_board_obj : rt_identity,
                                    &job->staged, err);
    return s;
}

static sheen_status import_mask(import_job *job, const char *folder, const sheen_frame_info *f,
                                const char *path, sheen_err *err)
{
    uint8_t *data;
    size_t size_bytes;
    sheen_image mask;
    sheen_status s = sheen_file_read(&data, &size_bytes, path, mask_max_bytes, err);
    if (s)
        return s;
    s = sheen_mask_parse(&mask, data, size_bytes, f->width_px, f->height_px, err);
    if (s)
        sheen_wrap(err, s, "cannot import the mask '%s'", path);
    sheen_image_release(&mask);
    if (!s)
        s = sheen_session_add_mask(&job->staged, folder, f->name, data, size_bytes, err);
    free(data);
    return s;
}

// <dir>/<frame>.png, or, where the picture's own name is none for a frame, that name.
static sheen_status mask_path(char path[SHEEN_PATH_MAX], const char *dir, const sheen_frame_info *f,
                              sheen_err *err)
{
    char name[sizeof f->source + 8];
    snprintf(name, sizeof name, "%s.png", f->name);
    const sheen_status s = sheen_path_join(path, dir, name, err);
    if (s || sheen_file_exists(path) || strchr(f->source, '/'))
        return s;
    const char *dot = strrchr(f->source, '.');
    snprintf(name, sizeof name, "%.*s.png", (int)(dot ? dot - f->source : 0), f->source);
    return sheen_path_join(path, dir, name, err);
}

// From the folder `dir` into the session's `folder`.
static sheen_status import_folder(import_job *job, const char *folder, const char *dir, size_t *n_masks,
                                  sheen_err *err)
{
    const size_t n = sheen_import_n_frames(job);
    sheen_status s = SHEEN_OK;
    if (!dir)
        return SHEEN_OK;
    if (!sheen_dir_exists(dir))
        return sheen_fail(err, SHEEN_EIO, "there is no folder of %s '%s'", folder, dir);
    for (size_t i = 0; !s && i < n; i++) {
        const sheen_frame_info *f = sheen_import_frame(job, i);
        char path[SHEEN_PATH_MAX];
        s = mask_path(path, dir, f, err);
        if (s || !sheen_role_shows_object(f->role) || !sheen_file_exists(path))
            continue;
        s = sheen_progress_step(&job->options->progress, folder, (int)i, (int)n, err);
        if (!s)
            s = import_mask(job, folder, f, path, err);
        *n_masks += !s;
    }
    if (!s && !*n_masks)
        s = sheen_fail(err, SHEEN_EDATA, "nothing in '%s' belongs to a frame: %s are named <frame>.png", dir,
                       folder);
    return s;
}

sheen_status sheen_import_masks(import_job *job, sheen_err *err)
{
    const sheen_import_options *o = job->options;
    const sheen_status s = import_folder(job, SHEEN_SESSION_MASKS, o->masks, &job->report->n_masks, err);
    return s ? s
             : import_folder(job, SHEEN_SESSION_HIGHLIGHTS, o->highlights, &job->report->n_highlights, err);
}

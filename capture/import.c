// SPDX-License-Identifier: Apache-2.0
// import.c - an import as a whole: stage everything, check that it fits together, commit.
#include "capture/import.h"

#include <string.h>

#include "capture/import_job.h"

size_t sheen_import_n_frames(const import_job *job)
{
    return job->session->n_frames + job->staged.n_frames;
}

const sheen_frame_info *sheen_import_frame(const import_job *job, size_t i)
{
    const size_t n = job->session->n_frames;
    return i < n ? &job->session->frames[i] : &job->staged.frames[i - n];
}

// The camera that the session has, where none is imported.
static sheen_status keep_camera(import_job *job, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    if (job->has_camera || !sheen_session_has(job->session, SHEEN_SESSION_CAMERA))
        return SHEEN_OK;
    sheen_status s = sheen_session_path(path, job->session, SHEEN_SESSION_CAMERA, err);
    if (!s)
        s = sheen_camera_load(&job->camera, path, err);
    job->has_camera = !s;
    return s;
}

// One camera took all frames of a session, so all are of its size.
static sheen_status check_sizes(const import_job *job, sheen_err *err)
{
    for (size_t i = 0; job->has_camera && i < sheen_import_n_frames(job); i++) {
        const sheen_frame_info *f = sheen_import_frame(job, i);
        if (f->width_px != job->camera.width_px || f->height_px != job->camera.height_px)
            return sheen_fail(
                err, SHEEN_EFORMAT,
                "frame '%s' is %d x %d px but the camera's pictures are %d x %d: give the camera that "
                "took it",
                f->name, f->width_px, f->height_px, job->camera.width_px, job->camera.height_px);
    }
    return SHEEN_OK;
}

static sheen_status stage_moving(import_job *job, sheen_err *err)
{
    if (!job->options->set_moving || job->options->moving == job->session->moving)
        return SHEEN_OK;
    job->staged.moving = job->options->moving;
    return sheen_session_save(&job->staged, err);
}

static sheen_status stage_all(import_job *job, sheen_err *err)
{
    sheen_status s = sheen_import_boards(job, err);
    if (!s)
        s = sheen_import_images(job, err);
    if (!s)
        s = sheen_import_camera(job, err);
    if (!s)
        s = sheen_import_poses(job, err);
    if (!s)
        s = keep_camera(job, err);
    if (!s)
        s = check_sizes(job, err);
    if (!s)
        s = sheen_import_masks(job, err);
    if (!s)
        s = sheen_import_mesh(job, err);
    return s ? s : stage_moving(job, err);
}

sheen_status sheen_import(sheen_session *session, const sheen_import_options *options,
                          sheen_import_report *report, sheen_err *err)
{
    import_job job = {.session = session, .options = options, .report = report};
    *report = (sheen_import_report){0};
    sheen_status s = sheen_session_stage(&job.staged, session, err);
    if (!s)
        s = stage_all(&job, err);
    if (!s)
        return sheen_session_commit(session, &job.staged, err);
    sheen_session_unstage(&job.staged);
    return s;
}

// SPDX-License-Identifier: Apache-2.0
// import_camera.c - a camera and poses that were found by other means.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/json_write.h"
#include "base/pose_file.h"
#include "capture/import_job.h"

sheen_status sheen_import_stage_camera(import_job *job, const sheen_camera *camera, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    job->camera = *camera;
    memset(job->camera.rt_cam_ref, 0, sizeof job->camera.rt_cam_ref); // poses are in poses.json
    sheen_status s = sheen_camera_check(&job->camera, err);
    if (!s)
        s = sheen_session_path(path, &job->staged, SHEEN_SESSION_CAMERA, err);
    if (!s)
        s = sheen_camera_save(&job->camera, path, err);
    if (!s)
        s = sheen_session_path(path, &job->staged, SHEEN_SESSION_CALIBRATION, err);
    if (s)
        return s;
    job->has_camera = true;
    // Replaces the report of a calibration whose camera is no longer the session's.
    sheen_json_writer w = {0};
    sheen_json_open(&w, NULL, '{');
    sheen_json_put_string(&w, "schema", "sheen-calibration/1");
    sheen_json_put_bool(&w, "imported", true);
    sheen_json_close(&w);
    return sheen_json_save(&w, path, err);
}

sheen_status sheen_import_camera(import_job *job, sheen_err *err)
{
    const char *path = job->options->camera;
    if (!path)
        return SHEEN_OK;
    // The pictures' size, for camera files that state none.
    const sheen_frame_info *first = sheen_import_n_frames(job) ? sheen_import_frame(job, 0) : NULL;
    sheen_camera camera;
    sheen_status s = sheen_camera_load_any(&camera, path, first ? first->width_px : 0,
                                           first ? first->height_px : 0, err);
    if (!s && (camera.width_px < 1 || camera.height_px < 1))
        s = sheen_fail(err, SHEEN_EFORMAT,
                       "'%s' does not state the size of the camera's pictures: import it together "
                       "with a picture",
                       path);
    return s ? s : sheen_import_stage_camera(job, &camera, err);
}

// A session has one camera: the pose file's, where it has one and no other was given.
static sheen_status camera_of_poses(import_job *job, const sheen_pose_file *file, sheen_err *err)
{
    if (job->has_camera || sheen_session_has(job->session, SHEEN_SESSION_CAMERA) || !file->n_cameras)
        return SHEEN_OK;
    for (size_t i = 1; i < file->n_cameras; i++) {
        const sheen_camera *a = &file->cameras[0], *b = &file->cameras[i];
        if (strcmp(a->lensmodel, b->lensmodel) != 0 || a->width_px != b->width_px ||
            a->height_px != b->height_px ||
            memcmp(a->intrinsics, b->intrinsics, (size_t)a->n_intrinsics * sizeof *a->intrinsics) != 0)
            return sheen_fail(err, SHEEN_EUNSUP,
                              "'%s' has %zu different cameras, a session has one: give it with --camera",
                              job->options->poses, file->n_cameras);
    }
    sheen_camera camera = file->cameras[0];
    if (camera.width_px < 1 && file->n_views) {
        camera.width_px = file->views[0].width_px;
        camera.height_px = file->views[0].height_px;
    }
    job->report->camera_from_poses = true;
    return sheen_import_stage_camera(job, &camera, err);
}

static const sheen_view *find_view(const sheen_pose_file *file, const char *frame_name)
{
    for (size_t i = 0; i < file->n_views; i++) {
        char name[64];
        if (!strcmp(file->views[i].name, frame_name))
            return &file->views[i];
        // a view's name has lost its ending already, and may hold what a frame's may not
        char with_ending[sizeof file->views[i].name + 2];
        snprintf(with_ending, sizeof with_ending, "%s.", file->views[i].name);
        if (!sheen_import_name(name, with_ending, NULL) && !strcmp(name, frame_name))
            return &file->views[i];
    }
    return NULL;
}

// One pose for each input and test frame that the session will have, in the order of their names.
static sheen_status match(import_job *job, sheen_poses *poses, const sheen_pose_file *file, sheen_err *err)
{
    const size_t n = sheen_import_n_frames(job);
    *poses = (sheen_poses){.imported = true, .poses = calloc(n + 1, sizeof *poses->poses)};
    if (!poses->poses)
        return sheen_fail_memory(err, (double)n * sizeof *poses->poses, "poses");
    for (size_t i = 0; i < n; i++) {
        const sheen_frame_info *f = sheen_import_frame(job, i);
        if (f->role == SHEEN_ROLE_CALIBRATION)
            continue;
        sheen_frame_pose *p = &poses->poses[poses->n_poses++];
        const sheen_view *v = find_view(file, f->name);
        memcpy(p->name, f->name, sizeof p->name);
        p->rms_px = (double)NAN;
        p->found = v != NULL;
        if (v)
            memcpy(p->rt_cam_board, v->rt_cam_world, sizeof p->rt_cam_board);
        else
            snprintf(p->reason, sizeof p->reason, "the imported file has no pose for it");
        *(v ? &job->report->n_poses : &job->report->n_unposed) += 1;
    }
    if (job->report->n_poses)
        return SHEEN_OK;
    return sheen_fail(
        err, SHEEN_EDATA,
        "no pose in '%s' belongs to a frame: it names '%s', the session has '%s'; names must agree but "
        "for the ending",
        job->options->poses, file->n_views ? file->views[0].name : "nothing",
        poses->n_poses ? poses->poses[0].name : "no frames");
}

sheen_status sheen_import_poses(import_job *job, sheen_err *err)
{
    if (!job->options->poses)
        return SHEEN_OK;
    sheen_pose_file file;
    sheen_poses poses = {0};
    sheen_status s = sheen_pose_file_load(&file, job->options->poses, err);
    if (s)
        return s;
    s = match(job, &poses, &file, err);
    if (!s)
        s = camera_of_poses(job, &file, err);
    if (!s)
        s = sheen_poses_save(&poses, &job->staged, err);
    sheen_poses_release(&poses);
    sheen_pose_file_release(&file);
    return s;
}

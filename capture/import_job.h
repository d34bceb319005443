// SPDX-License-Identifier: Apache-2.0
// import_job.h - what the import_*.c files share: one import on its way.
#ifndef SHEEN_CAPTURE_IMPORT_JOB_H
#define SHEEN_CAPTURE_IMPORT_JOB_H

#include "capture/import.h"

typedef struct import_job {
    const sheen_session *session; // as it is
    sheen_session staged;         // what will enter it
    const sheen_import_options *options;
    sheen_import_report *report;
    bool has_camera; // `camera` is what the session will have
    sheen_camera camera;
} import_job;

// A frame that the session will have, from either place; i < sheen_import_n_frames(job).
size_t sheen_import_n_frames(const import_job *job);
const sheen_frame_info *sheen_import_frame(const import_job *job, size_t i);

// Each checks and stages one kind of file.
sheen_status sheen_import_images(import_job *job, sheen_err *err);
sheen_status sheen_import_camera(import_job *job, sheen_err *err);
sheen_status sheen_import_poses(import_job *job, sheen_err *err); // after images and camera
sheen_status sheen_import_mesh(import_job *job, sheen_err *err);
sheen_status sheen_import_masks(import_job *job, sheen_err *err); // after images
sheen_status sheen_import_boards(import_job *job, sheen_err *err);

// Puts a camera into the staging area, as the one that was given by the person.
sheen_status sheen_import_stage_camera(import_job *job, const sheen_camera *camera, sheen_err *err);

#endif

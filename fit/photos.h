// SPDX-License-Identifier: Apache-2.0
// photos.h - the photographs of a session as the fit sees them: linear light, mask, pose of the object.
#ifndef SHEEN_FIT_PHOTOS_H
#define SHEEN_FIT_PHOTOS_H

#include "base/camera.h"
#include "base/image.h"
#include "base/progress.h"
#include "base/session.h"

typedef struct sheen_photo {
    char name[64];
    sheen_image image;    // RGB, linear
    sheen_image mask;     // 1 channel, 1: object; data NULL: none
    double rt_cam_obj[6]; // camera from mesh
    double covariance
        [36]; // of rt_cam_obj, row-major; zero: not known (given by a person, or the mesh was registered)
    double rt_world_obj[6]; // frame in which the lights stand still, from mesh
} sheen_photo;

typedef struct sheen_photos {
    sheen_camera cam;
    double rt_board_obj[6];
    double rt_world_cam
        [6]; // of an object that turned: world is the board's frame in the session's first input frame,
             // and here the camera stood in the first round (others: fit/rounds.h)
    sheen_photo *photos;
    size_t count;
    size_t n_dark;      // input frames that were left out because they show nothing (dark_photos.h)
    char dark_name[64]; // the first of them
} sheen_photos;

// All posed frames of a role, decoded. Frames without a pose are left out, and input frames that are black. EDATA: no camera, no poses or no
// frame yet (the sentence names the command that makes them), or the object turned and the camera moved as well; EFORMAT: a frame's size is not the camera's.
sheen_status sheen_photos_load(sheen_photos *out, const sheen_session *s, sheen_role role,
                               const sheen_progress *progress, sheen_err *err);
void sheen_photos_release(sheen_photos *p);

#endif

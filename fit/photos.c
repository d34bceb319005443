// SPDX-License-Identifier: Apache-2.0
// photos.c - decodes the posed frames of a session and composes each one's poses.
#include "fit/photos.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "base/vec.h"

static sheen_status load_photo(sheen_photo *p, const sheen_session *s, const sheen_frame_info *f,
                               const sheen_camera *cam, sheen_err *err)
{
    snprintf(p->name, sizeof p->name, "%s", f->name);
    sheen_status st = sheen_session_image(&p->image, s, f, err);
    if (st)
        return st;
    if (p->image.width_px != cam->width_px || p->image.height_px != cam->height_px)
        return sheen_fail(
            err, SHEEN_EFORMAT,
            "frame '%s' is %d x %d px but the camera was calibrated at %d x %d: calibrate again at "
            "the size that is photographed",
            f->name, p->image.width_px, p->image.height_px, cam->width_px, cam->height_px);
    if ((st = sheen_session_mask(&p->mask, s, f, err)))
        return st;
    if (p->mask.data && (p->mask.width_px != cam->width_px || p->mask.height_px != cam->height_px))
        return sheen_fail(err, SHEEN_EFORMAT, "the mask of frame '%s' is %d x %d px, the frame %d x %d",
                          f->name, p->mask.width_px, p->mask.height_px, cam->width_px, cam->height_px);
    return SHEEN_OK;
}

// The lights stand still in the board's frame where the camera moved. Where the object did, the camera and they stand
// still in the board's frame as it lay in the first input frame: the frame is the same for every role of frames, and its z is up.
static void set_world(sheen_photos *out, const sheen_session *s, const sheen_poses *poses)
{
    const sheen_frame_pose *first = NULL;
    bool first_is_input = false;
    for (size_t i = 0; i < s->n_frames && !first_is_input; i++) {
        const sheen_frame_pose *pose = sheen_poses_find(poses, s->frames[i].name);
        const bool is_input = s->frames[i].role == SHEEN_ROLE_INPUT;
        if (pose && pose->found && (!first || is_input)) {
            first = pose;
            first_is_input = is_input;
        }
    }
    if (first && s->moving == SHEEN_MOVING_OBJECT)
        sheen_rt_invert(out->rt_world_cam, first->rt_cam_board);
}

// rt_cam_obj = rt_cam_board rt_board_obj.
static void set_poses(sheen_photo *p, const sheen_photos *all, const double rt_cam_board[6],
                      sheen_moving moving)
{
    sheen_rt_compose(p->rt_cam_obj, rt_cam_board, all->rt_board_obj);
    if (moving == SHEEN_MOVING_OBJECT)
        sheen_rt_compose(p->rt_world_obj, all->rt_world_cam, p->rt_cam_obj);
    else
        memcpy(p->rt_world_obj, all->rt_board_obj, sizeof p->rt_world_obj);
}

// An object that turned on a table did so about one axis. Where the camera moved as well nobody knows where the lights stood
// to it, and the photographs cannot be explained.
static sheen_status check_axis(const sheen_photos *p, const sheen_session *s, sheen_err *err)
{
    static const double least_turn_rad = 0.09, most_off_rad = 0.05, most_screw = 0.02;
    double axis[3] = {0};
    for (size_t i = 1; i < p->count && s->moving == SHEEN_MOVING_OBJECT; i++) {
        double rt_obj_cam[6], turn[6];
        sheen_rt_invert(rt_obj_cam, p->photos[0].rt_cam_obj);
        sheen_rt_compose(turn, p->photos[i].rt_cam_obj, rt_obj_cam);
        const double angle_rad = sheen_norm(turn), distance_m = sheen_norm(p->photos[i].rt_cam_obj + 3);
        if (!(angle_rad > least_turn_rad))
            continue;
        if (!(sheen_norm(axis) > 0))
            for (int k = 0; k < 3; k++)
                axis[k] = turn[k] / angle_rad;
        const double along = fabs(sheen_dot(turn, axis)) / angle_rad;
        if (along < cos(most_off_rad) || fabs(sheen_dot(turn + 3, axis)) > most_screw * distance_m)
            return sheen_fail(
                err, SHEEN_EDATA,
                "frame '%s' does not turn about the axis of the others: the camera moved, too, so that where "
                "its lights are is not known. Fit each height of the camera as a session of its own; if the "
                "object stood still, the session should say so (sheen import --moving camera)",
                p->photos[i].name);
    }
    return SHEEN_OK;
}

static sheen_status load_camera(sheen_camera *cam, const sheen_session *s, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    if (!sheen_session_has(s, SHEEN_SESSION_CAMERA))
        return sheen_fail(err, SHEEN_EDATA, "'%s' has no camera yet: run 'sheen calibrate' or import one",
                          s->path);
    const sheen_status st = sheen_session_path(path, s, SHEEN_SESSION_CAMERA, err);
    return st ? st : sheen_camera_load(cam, path, err);
}

sheen_status sheen_photos_load(sheen_photos *out, const sheen_session *s, sheen_role role,
                               const sheen_progress *progress, sheen_err *err)
{
    *out = (sheen_photos){0};
    sheen_poses poses = {0};
    sheen_status st;
    if ((st = load_camera(&out->cam, s, err)) || (st = sheen_registration_load(out->rt_board_obj, s, err)))
        goto done;
    if (!sheen_session_has(s, SHEEN_SESSION_POSES)) {
        st = sheen_fail(err, SHEEN_EDATA, "'%s' has no poses yet: run 'sheen pose' or import them", s->path);
        goto done;
    }
    if ((st = sheen_poses_load(&poses, s, err)))
        goto done;
    set_world(out, s, &poses);
    const size_t n_role = sheen_session_count_role(s, role);
    out->photos = calloc(n_role ? n_role : 1, sizeof *out->photos);
    if (!out->photos) {
        st = sheen_fail_memory(err, (double)(n_role * sizeof *out->photos), "photographs");
        goto done;
    }
    for (size_t i = 0; i < s->n_frames && !st; i++) {
        const sheen_frame_info *f = &s->frames[i];
        const sheen_frame_pose *pose = sheen_poses_find(&poses, f->name);
        if (f->role != role || !pose || !pose->found)
            continue;
        if ((st = sheen_progress_step(progress, "reading photographs", (int)out->count, (int)n_role, err)))
            break;
        sheen_photo *p = &out->photos[out->count++];
        set_poses(p, out, pose->rt_cam_board, s->moving);
        st = load_photo(p, s, f, &out->cam, err);
    }
    if (!st && !out->count)
        st = sheen_fail(err, SHEEN_EDATA, "'%s' has no %s frame with a pose", s->path, sheen_role_name(role));
    if (!st)
        st = check_axis(out, s, err);

done:
    sheen_poses_release(&poses);
    if (st)
        sheen_photos_release(out);
    return st;
}

void sheen_photos_release(sheen_photos *p)
{
    for (size_t i = 0; i < p->count; i++) {
        sheen_image_release(&p->photos[i].image);
        sheen_image_release(&p->photos[i].mask);
    }
    free(p->photos);
    p->photos = NULL;
    p->count = 0;
}

// SPDX-License-Identifier: Apache-2.0
// photos.c - decodes the posed frames of a session and composes each one's poses.
#include "fit/photos.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "fit/dark_photos.h"
#include "fit/rounds.h"

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

// The posed frames of a session, in its order, and the first one that is fitted: world is the board's frame there.
typedef struct posed {
    sheen_round_frame *frames;
    size_t n, i_first;
    sheen_rounds rounds;
} posed;

// Where the object turned, the camera and the lights stand still in the board's frame as it lay in the first input frame:
// the frame is the same for every role of frames, and its z is up.
static sheen_status find_rounds(posed *out, const sheen_session *s, const sheen_poses *poses, sheen_err *err)
{
    bool first_is_input = false;
    *out = (posed){.frames = calloc(s->n_frames + 1, sizeof *out->frames)};
    if (!out->frames)
        return sheen_fail_memory(err, (double)s->n_frames * sizeof *out->frames, "frames");
    for (size_t i = 0; i < s->n_frames; i++) {
        const sheen_frame_info *f = &s->frames[i];
        const sheen_frame_pose *pose = sheen_poses_find(poses, f->name);
        if (!pose || !pose->found || !sheen_role_shows_object(f->role))
            continue;
        sheen_round_frame *g = &out->frames[out->n];
        snprintf(g->name, sizeof g->name, "%s", f->name);
        memcpy(g->rt_cam_board, pose->rt_cam_board, sizeof g->rt_cam_board);
        g->asked_rad = f->table_asked_deg * 3.14159265358979323846 / 180;
        if (f->role == SHEEN_ROLE_INPUT && !first_is_input) {
            out->i_first = out->n;
            first_is_input = true;
        }
        out->n++;
    }
    return out->n ? sheen_rounds_find(&out->rounds, out->frames, out->n, out->i_first, err) : SHEEN_OK;
}

// rt_cam_obj = rt_cam_board rt_board_obj. The lights stand still in the board's frame where the camera moved.
static sheen_status set_poses(sheen_photo *p, const sheen_photos *all, const sheen_frame_pose *pose,
                              const posed *turned, sheen_err *err)
{
    double motion = 0;
    for (int k = 0; k < 6; k++)
        motion += fabs(all->rt_board_obj[k]);
    sheen_rt_compose(p->rt_cam_obj, pose->rt_cam_board, all->rt_board_obj);
    if (!(motion > 0)) // a registration's own error is common to all
        memcpy(p->covariance, pose->covariance, sizeof p->covariance);
    memcpy(p->rt_world_obj, all->rt_board_obj, sizeof p->rt_world_obj);
    for (size_t i = 0; i < turned->n; i++) {
        const sheen_round_frame *f = &turned->frames[i];
        if (strcmp(f->name, pose->name) != 0)
            continue;
        // Nobody knows where the lights stood to that camera, and the photograph cannot be explained.
        if (f->round < 0)
            return sheen_fail(
                err, SHEEN_EDATA,
                "frame '%s' does not turn about the axis of the others: the camera moved, too, so that where "
                "its lights are is not known. Fit each height of the camera as a session of its own; if the "
                "object stood still, the session should say so (sheen import --moving camera)",
                f->name);
        sheen_rt_compose(p->rt_world_obj, turned->rounds.rt_world_cam[f->round], p->rt_cam_obj);
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
    posed turned = {0};
    sheen_status st;
    if ((st = load_camera(&out->cam, s, err)) || (st = sheen_registration_load(out->rt_board_obj, s, err)))
        goto done;
    if (!sheen_session_has(s, SHEEN_SESSION_POSES)) {
        st = sheen_fail(err, SHEEN_EDATA, "'%s' has no poses yet: run 'sheen pose' or import them", s->path);
        goto done;
    }
    if ((st = sheen_poses_load(&poses, s, err)))
        goto done;
    if (s->moving == SHEEN_MOVING_OBJECT) {
        if ((st = find_rounds(&turned, s, &poses, err)))
            goto done;
        memcpy(out->rt_world_cam, turned.rounds.rt_world_cam[0], sizeof out->rt_world_cam);
    }
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
        if (!(st = set_poses(p, out, pose, &turned, err)))
            st = load_photo(p, s, f, &out->cam, err);
    }
    if (!st && !out->count)
        st = sheen_fail(err, SHEEN_EDATA, "'%s' has no %s frame with a pose", s->path, sheen_role_name(role));
    if (!st && role == SHEEN_ROLE_INPUT)
        st = sheen_photos_leave_out_dark(out, err);

done:
    free(turned.frames);
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

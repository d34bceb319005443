// SPDX-License-Identifier: Apache-2.0
// table_eye.c - poses of the board in live frames, and the turns between them.
#include "cli/table_eye.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "base/vec.h"
#include "calib/saddles.h"

static const double pi = 3.14159265358979323846;
// Beside the turn of a table that poses of a good board, seen from half a metre, are never by a fifth of it.
static const double most_off_deg = 0.5, most_shift = 0.01; // of the distance

sheen_status sheen_cli_eye_init(sheen_cli_eye *e, const sheen_session *s, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    *e = (sheen_cli_eye){.session = s};
    if (!sheen_session_has(s, SHEEN_SESSION_BOARD) || !sheen_session_has(s, SHEEN_SESSION_CAMERA))
        return SHEEN_OK;
    sheen_status st = sheen_session_path(path, s, SHEEN_SESSION_CAMERA, err);
    if (!st)
        st = sheen_camera_load(&e->camera, path, err);
    if (!st)
        st = sheen_session_path(path, s, SHEEN_SESSION_BOARD, err);
    if (!st)
        st = sheen_board_load(&e->board, path, err);
    if (!st)
        st = sheen_tag_detector_new(&e->detector, e->board.family, err);
    if (st)
        sheen_cli_eye_release(e);
    return st;
}

void sheen_cli_eye_release(sheen_cli_eye *e)
{
    sheen_tag_detector_free(&e->detector);
    sheen_board_release(&e->board);
    *e = (sheen_cli_eye){0};
}

sheen_status sheen_cli_eye_pose(sheen_board_pose *pose, sheen_cli_eye *e, const sheen_frame *frame,
                                sheen_err *err)
{
    sheen_raster r;
    sheen_board_view view = {0};
    sheen_status s = sheen_frame_develop(&r, frame, err);
    if (s)
        return s;
    if (r.width_px != e->camera.width_px || r.height_px != e->camera.height_px) {
        s = sheen_fail(err, SHEEN_EDATA, "frames are %d x %d px, the camera was calibrated at %d x %d",
                       r.width_px, r.height_px, e->camera.width_px, e->camera.height_px);
        sheen_raster_release(&r);
        return s;
    }
    uint8_t *grey = malloc((size_t)r.width_px * (size_t)r.height_px);
    if (!grey)
        s = sheen_fail_memory(err, (double)r.width_px * r.height_px, "a grey picture");
    else {
        sheen_raster_grey(grey, &r, frame->info.transfer);
        s = sheen_board_observe(&view, e->detector, grey, r.width_px, r.height_px, &e->board, err);
    }
    if (!s) {
        s = sheen_board_pose_find(pose, NULL, &e->camera, &e->board, &view, err);
        sheen_board_view_release(&view);
    }
    free(grey);
    sheen_raster_release(&r);
    return s;
}

double sheen_cli_eye_turn_deg(const double rt_cam_board_from[6], const double rt_cam_board_to[6])
{
    double rt_board_cam[6], turn[6];
    sheen_rt_invert(rt_board_cam, rt_cam_board_from);
    sheen_rt_compose(turn, rt_board_cam, rt_cam_board_to); // the board as it stood before, from the one now
    const double angle = sheen_norm(turn) * 180 / pi;
    return turn[2] < 0 ? -angle : angle;
}

// A turn about an axis that does not pass through the origin, from its motion: unit axis and a point of it.
static void axis_of(double axis[3], double point[3], const double turn[6])
{
    const double angle = sheen_norm(turn), *t = turn + 3;
    double across[3], side[3];
    for (int i = 0; i < 3; i++)
        axis[i] = turn[i] / angle;
    const double along = sheen_dot(axis, t);
    for (int i = 0; i < 3; i++)
        across[i] = t[i] - along * axis[i];
    sheen_cross(side, axis, across);
    for (int i = 0; i < 3; i++)
        point[i] = 0.5 * (across[i] + side[i] / tan(0.5 * angle));
}

void sheen_cli_eye_off_axis(double *off_deg, double *shift_m, const double rt_cam_board_from[6],
                            const double rt_cam_board_other[6], const double rt_cam_board_now[6])
{
    double rt_from_cam[6], turn[6], axis[3], point[3], expected[6] = {0}, back[6], off[6];
    sheen_rt_invert(rt_from_cam, rt_cam_board_from);
    sheen_rt_compose(turn, rt_from_cam, rt_cam_board_other);
    axis_of(axis, point, turn);
    sheen_rt_compose(turn, rt_from_cam, rt_cam_board_now);
    const double angle = sheen_dot(turn, axis), to_axis[6] = {0, 0, 0, -point[0], -point[1], -point[2]};
    for (int i = 0; i < 3; i++) {
        expected[i] = angle * axis[i];
        back[i] = 0;
        back[3 + i] = point[i];
    }
    sheen_rt_compose(expected, expected, to_axis);
    sheen_rt_compose(expected, back, expected);
    sheen_rt_invert(back, expected);
    sheen_rt_compose(off, back, turn);
    *off_deg = sheen_norm(off) * 180 / pi;
    *shift_m = sheen_norm(off + 3);
}

static sheen_status stored_pose(double rt_cam_board[6], sheen_cli_eye *e, const sheen_frame_info *f,
                                sheen_err *err)
{
    sheen_board_pose pose;
    uint8_t *data;
    size_t size_bytes;
    sheen_status s = sheen_session_payload(&data, &size_bytes, e->session, f, err);
    if (s)
        return s;
    const sheen_frame stored = {.info = *f, .data = data, .size_bytes = size_bytes};
    s = sheen_cli_eye_pose(&pose, e, &stored, err);
    free(data);
    if (!s)
        memcpy(rt_cam_board, pose.rt_cam_board, sizeof pose.rt_cam_board);
    return s;
}

// The frame of the reference's round (the same name up to its step) that is turned most against it, by 30 degrees at least.
static void find_axis(sheen_cli_eye *e, const sheen_frame_info *reference)
{
    const size_t prefix = strcspn(reference->name, "-");
    const sheen_frame_info *far = NULL;
    double most = sin(15 * pi / 180);
    for (size_t i = 0; i < e->session->n_frames; i++) {
        const sheen_frame_info *f = &e->session->frames[i];
        const double half = 0.5 * (f->table_asked_deg - reference->table_asked_deg) * pi / 180;
        // Half a turn has no side: its axis may point either way
        if (!strncmp(f->name, reference->name, prefix + 1) && fabs(sin(half)) > most &&
            fabs(cos(half)) > 0.2) {
            most = fabs(sin(half));
            far = f;
        }
    }
    e->has_axis = far && !stored_pose(e->rt_far, e, far, NULL);
}

static sheen_status take_reference(sheen_cli_eye *e, const sheen_frame_info *reference, sheen_err *err)
{
    const sheen_status s = stored_pose(e->rt_reference, e, reference, err);
    if (s)
        return sheen_wrap(err, s, "frame '%s' does not show where the turntable stood", reference->name);
    snprintf(e->reference, sizeof e->reference, "%s", reference->name);
    find_axis(e, reference);
    return SHEEN_OK;
}

static sheen_status check_axis(const sheen_cli_eye *e, const double rt_cam_board[6], sheen_err *err)
{
    double off_deg, shift_m;
    if (!e->has_axis || e->any_axis)
        return SHEEN_OK;
    sheen_cli_eye_off_axis(&off_deg, &shift_m, e->rt_reference, e->rt_far, rt_cam_board);
    if (off_deg < most_off_deg && shift_m < most_shift * rt_cam_board[5])
        return SHEEN_OK;
    return sheen_fail(err, SHEEN_EUNSUP,
                      "the camera was moved since frame '%s' was taken, or the board on the table: the tags "
                      "are %.2f degrees "
                      "and %.1f mm beside the table's turn. Put it back, or take the object anew",
                      e->reference, off_deg, 1e3 * shift_m);
}

sheen_status sheen_cli_eye_see(void *self, const sheen_frame *frame, const sheen_frame_info *reference,
                               double *angle_deg, sheen_err *err)
{
    sheen_cli_eye *e = self;
    sheen_board_pose now;
    sheen_status s = SHEEN_OK;
    *angle_deg = 0;
    if (!reference)
        return SHEEN_OK;
    if (strcmp(e->reference, reference->name) != 0 && (s = take_reference(e, reference, err)))
        return s;
    if ((s = sheen_cli_eye_pose(&now, e, frame, err)) || (s = check_axis(e, now.rt_cam_board, err)))
        return s;
    *angle_deg = sheen_cli_eye_turn_deg(e->rt_reference, now.rt_cam_board);
    return SHEEN_OK;
}

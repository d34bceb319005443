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
    const double angle = sheen_norm(turn) * 180 / 3.14159265358979323846;
    return turn[2] < 0 ? -angle : angle;
}

sheen_status sheen_cli_eye_see(void *self, const sheen_frame *frame, const sheen_frame_info *reference,
                               double *angle_deg, sheen_err *err)
{
    sheen_cli_eye *e = self;
    sheen_board_pose now, then;
    *angle_deg = 0;
    if (!reference)
        return SHEEN_OK;
    if (strcmp(e->reference, reference->name) != 0) {
        uint8_t *data;
        size_t size_bytes;
        sheen_status s = sheen_session_payload(&data, &size_bytes, e->session, reference, err);
        if (s)
            return s;
        const sheen_frame stored = {.info = *reference, .data = data, .size_bytes = size_bytes};
        s = sheen_cli_eye_pose(&then, e, &stored, err);
        free(data);
        if (s)
            return sheen_wrap(err, s, "frame '%s' does not show where the turntable stood", reference->name);
        snprintf(e->reference, sizeof e->reference, "%s", reference->name);
        memcpy(e->rt_reference, then.rt_cam_board, sizeof e->rt_reference);
    }
    const sheen_status s = sheen_cli_eye_pose(&now, e, frame, err);
    if (!s)
        *angle_deg = sheen_cli_eye_turn_deg(e->rt_reference, now.rt_cam_board);
    return s;
}

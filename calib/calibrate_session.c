// SPDX-License-Identifier: Apache-2.0
// calibrate_session.c - the calibration stage: which frames, which board, which files.
#include "calib/calibrate_session.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "calib/views.h"
#include "calib/vnl.h"

static const char vnl_name[] = SHEEN_SESSION_DETECTIONS "/calibration.vnl";

// Board's file and role of the frames to calibrate from.
static void choose(const sheen_session *s, const char **board_file, sheen_role *role)
{
    *role = sheen_session_count_role(s, SHEEN_ROLE_CALIBRATION) ? SHEEN_ROLE_CALIBRATION : SHEEN_ROLE_INPUT;
    const bool own_board = *role == SHEEN_ROLE_CALIBRATION &&
                           sheen_session_has(s, SHEEN_SESSION_CALIBRATION_BOARD);
    *board_file = own_board ? SHEEN_SESSION_CALIBRATION_BOARD : SHEEN_SESSION_BOARD;
}

void sheen_calibration_inputs(const char *inputs[3], const sheen_session *s)
{
    sheen_role role;
    choose(s, &inputs[1], &role);
    inputs[0] = role == SHEEN_ROLE_CALIBRATION ? "frames:calibration" : "frames:input";
    inputs[2] = NULL;
}

bool sheen_calibration_is_current(const sheen_session *s)
{
    char path[SHEEN_PATH_MAX];
    const char *inputs[3];
    sheen_json *root;
    if (!sheen_session_has(s, SHEEN_SESSION_CAMERA) ||
        sheen_session_path(path, s, SHEEN_SESSION_CALIBRATION, NULL) || sheen_json_load(&root, path, NULL))
        return false;
    sheen_calibration_inputs(inputs, s);
    const bool current = sheen_stamp_is_current(root, s, inputs);
    sheen_json_free(&root);
    return current;
}

static sheen_status observe_role(sheen_views *out, const sheen_session *s, sheen_role role,
                                 const sheen_board *board, const sheen_calibrate_options *options,
                                 sheen_err *err)
{
    const sheen_frame_info **frames = calloc(s->n_frames + 1, sizeof *frames);
    if (!frames)
        return sheen_fail_memory(err, (double)s->n_frames * sizeof *frames, "the list of frames");
    size_t n = 0;
    for (size_t i = 0; i < s->n_frames; i++)
        if (s->frames[i].role == role)
            frames[n++] = &s->frames[i];
    const sheen_status status =
        n ? sheen_views_of_session(out, s, frames, n, board, options->n_threads, &options->progress, err)
          : sheen_fail(err, SHEEN_EDATA,
                       "session '%s' has no frames to calibrate from: import or capture some", s->path);
    free(frames);
    return status;
}

// Frames of one camera at one focus have one lens; which, goes into the camera's file.
static sheen_status find_owner(char taken_by[160], const sheen_session *s, sheen_role role, sheen_err *err)
{
    const sheen_frame_info *first = NULL;
    taken_by[0] = 0;
    for (size_t i = 0; i < s->n_frames; i++) {
        char other[160];
        if (s->frames[i].role != role)
            continue;
        sheen_frame_taken_by(other, &s->frames[i]);
        if (first && strcmp(other, taken_by) != 0)
            return sheen_fail(
                err, SHEEN_EDATA,
                "frame '%s' is by '%.120s' but '%s' by '%.120s': calibrate from frames of one camera at "
                "one focus",
                s->frames[i].name, other, first->name, taken_by);
        if (!first)
            snprintf(taken_by, 160, "%s", other);
        first = first ? first : &s->frames[i];
    }
    return SHEEN_OK;
}

static sheen_status write_results(const sheen_calibration *c, const sheen_session *s,
                                  const sheen_board *board, const sheen_views *views, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    sheen_status st = sheen_session_path(path, s, SHEEN_SESSION_DETECTIONS, err);
    if (!st)
        st = sheen_dir_make(path, err);
    if (!st)
        st = sheen_session_path(path, s, vnl_name, err);
    if (!st)
        st = sheen_vnl_save(path, board, views->views, views->n_views, err);
    if (!st)
        st = sheen_session_path(path, s, SHEEN_SESSION_CAMERA, err);
    if (!st)
        st = sheen_calibration_save_camera(c, path, err);
    if (!st)
        st = sheen_session_path(path, s, SHEEN_SESSION_CALIBRATION, err);
    if (!st)
        st = sheen_calibration_save(c, s, path, err);
    return st;
}

sheen_status sheen_calibrate_session(sheen_calibration *out, const sheen_session *s,
                                     const sheen_calibrate_options *options, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    const char *board_file;
    char taken_by[160];
    sheen_role role;
    sheen_board board = {0};
    sheen_views views = {0};
    *out = (sheen_calibration){0};
    choose(s, &board_file, &role);
    sheen_status st = sheen_session_path(path, s, board_file, err);
    if (!st && !sheen_session_has(s, board_file))
        st = sheen_fail(err, SHEEN_EDATA,
                        "session '%s' has no '%s': import the file that came with the board", s->path,
                        board_file);
    if (!st)
        st = sheen_board_load(&board, path, err);
    if (!st)
        st = find_owner(taken_by, s, role, err);
    if (!st)
        st = observe_role(&views, s, role, &board, options, err);
    if (!st)
        st = sheen_calibrate(out, &board, views.views, views.n_views, options, err);
    if (!st) {
        snprintf(out->camera.taken_by, sizeof out->camera.taken_by, "%s", taken_by);
        st = write_results(out, s, &board, &views, err);
        if (st)
            sheen_calibration_release(out);
    }
    sheen_views_release(&views);
    sheen_board_release(&board);
    return st;
}

sheen_status sheen_calibrate_files(sheen_calibration *out, const char *const *paths, size_t n_paths,
                                   const char *board_path, const sheen_calibrate_options *options,
                                   sheen_err *err)
{
    sheen_board board = {0};
    sheen_views views = {0};
    *out = (sheen_calibration){0};
    sheen_status s = sheen_board_load(&board, board_path, err);
    if (!s)
        s = sheen_views_of_files(&views, paths, n_paths, &board, options->n_threads, &options->progress, err);
    if (!s)
        s = sheen_calibrate(out, &board, views.views, views.n_views, options, err);
    sheen_views_release(&views);
    sheen_board_release(&board);
    return s;
}

sheen_status sheen_calibrate_table(sheen_calibration *out, const char *vnl_path, const int size_px[2],
                                   const char *board_path, const sheen_calibrate_options *options,
                                   sheen_err *err)
{
    sheen_board board = {0};
    sheen_views views = {0};
    sheen_vnl vnl = {0};
    *out = (sheen_calibration){0};
    sheen_status s = sheen_board_load(&board, board_path, err);
    if (!s)
        s = sheen_vnl_load(&vnl, vnl_path, board.n_cols - 1, board.n_rows - 1, err);
    if (!s)
        s = sheen_views_of_vnl(&views, &vnl, size_px, &board, err);
    if (!s)
        s = sheen_calibrate(out, &board, views.views, views.n_views, options, err);
    sheen_views_release(&views);
    sheen_vnl_release(&vnl);
    sheen_board_release(&board);
    return s;
}

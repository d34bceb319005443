// SPDX-License-Identifier: Apache-2.0
// pose_session.c - the pose stage: board, camera and frames in, poses out.
#include "pose/pose_session.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/board.h"
#include "base/order.h"
#include "base/pose3.h"
#include "base/vec.h"
#include "calib/views.h"
#include "calib/vnl.h"
#include "pose/board_pose.h"
#include "pose/board_search.h"
#include "pose/board_survey.h"

enum { BLURRED_MIN_FRAMES = 4 };

static const double BLURRED_PX = 0.3; // an error of corners that is still usual
static const double BLURRED_MEDIANS = 4;
static const double ALIKE_RAD = 0.035; // two degrees
static const double ALIKE_M = 0.005;

static const char vnl_name[] = SHEEN_SESSION_DETECTIONS "/board.vnl";

// What the stage reads beside the frames' pictures.
typedef struct inputs {
    sheen_camera camera;
    sheen_board_set set;
    const sheen_frame_info **frames;
    size_t n_frames;
} inputs;

static sheen_status load_files(inputs *in, const sheen_session *s, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    if (!sheen_session_has(s, SHEEN_SESSION_CAMERA))
        return sheen_fail(err, SHEEN_EDATA, "session '%s' has no '%s': calibrate first, or import a camera",
                          s->path, SHEEN_SESSION_CAMERA);
    if (!sheen_session_has(s, SHEEN_SESSION_BOARD))
        return sheen_fail(err, SHEEN_EDATA,
                          "session '%s' has no '%s': import the file that came with the board", s->path,
                          SHEEN_SESSION_BOARD);
    sheen_status st = sheen_session_path(path, s, SHEEN_SESSION_CAMERA, err);
    if (!st)
        st = sheen_camera_load(&in->camera, path, err);
    if (!st)
        st = sheen_session_path(path, s, SHEEN_SESSION_BOARD, err);
    return st ? st : sheen_board_set_load(&in->set, path, err);
}

static sheen_status list_frames(inputs *in, const sheen_session *s, sheen_err *err)
{
    in->frames = calloc(s->n_frames + 1, sizeof *in->frames);
    if (!in->frames)
        return sheen_fail_memory(err, (double)s->n_frames * sizeof *in->frames, "the list of frames");
    for (size_t i = 0; i < s->n_frames; i++) {
        const sheen_frame_info *f = &s->frames[i];
        if (f->role == SHEEN_ROLE_CALIBRATION)
            continue;
        if (f->width_px != in->camera.width_px || f->height_px != in->camera.height_px)
            return sheen_fail(
                err, SHEEN_EDATA,
                "frame '%s' is %d x %d px but '%s' is for %d x %d: calibrate this camera at this size",
                f->name, f->width_px, f->height_px, SHEEN_SESSION_CAMERA, in->camera.width_px,
                in->camera.height_px);
        in->frames[in->n_frames++] = f;
    }
    return in->n_frames ? SHEEN_OK
                        : sheen_fail(err, SHEEN_EDATA, "session '%s' has no frames of the object", s->path);
}

// Searches each board of a frame for the corners whose tags are hidden.
static sheen_status search_boards(const void *self, sheen_board_view *views, const uint8_t *grey,
                                  sheen_err *err)
{
    const inputs *in = self;
    sheen_status s = SHEEN_OK;
    for (size_t b = 0; b < in->set.n_boards && !s; b++)
        s = sheen_board_search(&views[b], grey, &in->camera, &in->set.boards[b], err);
    return s;
}

static double sigma_m(const sheen_frame_pose *p)
{
    double var = 0;
    for (size_t i = 3; i < 6; i++)
        var = fmax(var, p->covariance[7 * i]);
    return sqrt(var);
}

// A frame's pose, or why it has none. Only running out of memory and the like is a failure.
static sheen_status pose_frame(sheen_frame_pose *out, bool *from_tags, const inputs *in,
                               const sheen_board_view *view, sheen_err *err)
{
    sheen_board_pose pose;
    sheen_err why = {0};
    const sheen_status s = sheen_board_pose_find(&pose, NULL, &in->camera, &in->set.boards[0], view, &why);
    *out = (sheen_frame_pose){.found = !s, .rms_px = (double)NAN};
    *from_tags = !s && pose.from_tags;
    snprintf(out->name, sizeof out->name, "%s", view->name);
    if (s == SHEEN_EDATA) {
        snprintf(out->reason, sizeof out->reason, "%.*s", (int)sizeof out->reason - 1, why.msg);
        return SHEEN_OK;
    }
    if (s)
        return sheen_fail(err, s, "%s", why.msg);
    memcpy(out->rt_cam_board, pose.rt_cam_board, sizeof out->rt_cam_board);
    memcpy(out->covariance, pose.covariance, sizeof out->covariance);
    out->rms_px = pose.rms_px;
    out->n_points = pose.n_points;
    out->n_outliers = pose.n_outliers;
    if (pose.from_tags)
        snprintf(out->reason, sizeof out->reason,
                 "from the tags alone: %zu corners of the chessboard in view", view->n_saddles);
    return SHEEN_OK;
}

// The poses of a set of boards, from one survey of all.
static sheen_status pose_set(sheen_poses *poses, const inputs *in, const sheen_views *views, sheen_err *err)
{
    sheen_survey survey;
    poses->boards = calloc(in->set.n_boards, sizeof *poses->boards);
    if (!poses->boards)
        return sheen_fail_memory(err, (double)in->set.n_boards * sizeof *poses->boards, "boards");
    const sheen_status s = sheen_survey_solve(&survey, &in->camera, &in->set, views->views, in->n_frames,
                                              err);
    if (s)
        return s;
    poses->n_boards = in->set.n_boards;
    for (size_t b = 0; b < in->set.n_boards; b++) {
        const sheen_survey_board *from = &survey.boards[b];
        sheen_board_place *to = &poses->boards[b];
        *to = (sheen_board_place){.found = from->found, .n_frames = from->n_frames, .n_moved = from->n_moved};
        snprintf(to->name, sizeof to->name, "%s", in->set.boards[b].name);
        snprintf(to->reason, sizeof to->reason, "%s", from->reason);
        memcpy(to->rt_ref_board, from->rt_ref_board, sizeof to->rt_ref_board);
        memcpy(to->covariance, from->covariance, sizeof to->covariance);
    }
    for (size_t f = 0; f < in->n_frames; f++) {
        const sheen_survey_frame *from = &survey.frames[f];
        sheen_frame_pose *to = &poses->poses[f];
        *to = (sheen_frame_pose){.found = from->found,
                                 .rms_px = from->found ? from->rms_px : (double)NAN,
                                 .n_points = from->n_points,
                                 .n_outliers = from->n_outliers};
        snprintf(to->name, sizeof to->name, "%s", in->frames[f]->name);
        snprintf(to->reason, sizeof to->reason, "%s", from->reason);
        memcpy(to->rt_cam_board, from->rt_cam_ref, sizeof to->rt_cam_board);
        memcpy(to->covariance, from->covariance, sizeof to->covariance);
    }
    sheen_survey_release(&survey);
    return SHEEN_OK;
}

static sheen_status summarise(sheen_pose_summary *out, const sheen_poses *poses, sheen_err *err)
{
    double *values = malloc((2 * poses->n_poses + 1) * sizeof *values),
           *sigmas = values ? values + poses->n_poses : NULL;
    if (!values)
        return sheen_fail_memory(err, 2 * (double)poses->n_poses * sizeof *values, "a summary");
    size_t n = 0;
    for (size_t i = 0; i < poses->n_poses; i++)
        if (poses->poses[i].found) {
            values[n] = poses->poses[i].rms_px;
            sigmas[n++] = sigma_m(&poses->poses[i]);
        }
    out->n_found = (int)n;
    if (n) {
        qsort(values, n, sizeof *values, sheen_ascending);
        qsort(sigmas, n, sizeof *sigmas, sheen_ascending);
        out->rms_median_px = values[n / 2];
        out->sigma_median_m = sigmas[n / 2];
        out->sigma_worst_m = sigmas[n - 1];
    }
    free(values);
    return SHEEN_OK;
}

// Motion blur, a rolling shutter, a board that bends: corners of such a frame fit far worse than those of the others.
// It is left out, with the reason.
static void leave_out_blurred(sheen_pose_summary *out, sheen_poses *poses)
{
    const double limit_px = fmax(BLURRED_PX, BLURRED_MEDIANS * out->rms_median_px);
    for (size_t i = 0; i < poses->n_poses && out->n_found >= BLURRED_MIN_FRAMES; i++) {
        sheen_frame_pose *p = &poses->poses[i];
        if (!p->found || !(p->rms_px > limit_px))
            continue;
        p->found = false;
        out->n_blurred++;
        snprintf(
            p->reason, sizeof p->reason,
            "its corners fit to %.2f px, %.0f times worse than in other frames: blurred, or something moved "
            "during the exposure",
            p->rms_px, p->rms_px / out->rms_median_px);
    }
}

// True where no frame's pose differs from the first one's by more than a hand's tremble.
static bool all_alike(const sheen_poses *poses)
{
    const sheen_frame_pose *first = NULL;
    size_t n = 0;
    for (size_t i = 0; i < poses->n_poses; i++) {
        const sheen_frame_pose *p = &poses->poses[i];
        if (!p->found)
            continue;
        first = first ? first : p;
        n++;
        double d[3];
        sheen_sub(d, p->rt_cam_board + 3, first->rt_cam_board + 3);
        if (sheen_rt_angle_rad(p->rt_cam_board, first->rt_cam_board) > ALIKE_RAD || sheen_norm(d) > ALIKE_M)
            return false;
    }
    return n > 1;
}

static sheen_status pose_all(sheen_pose_summary *out, sheen_poses *poses, const inputs *in,
                             const sheen_views *views, sheen_err *err)
{
    poses->poses = calloc(in->n_frames, sizeof *poses->poses);
    poses->n_poses = in->n_frames;
    if (!poses->poses)
        return sheen_fail_memory(err, (double)in->n_frames * sizeof *poses->poses, "poses");
    sheen_status s = in->set.n_boards > 1 ? pose_set(poses, in, views, err) : SHEEN_OK;
    for (size_t i = 0; i < in->n_frames && in->set.n_boards == 1 && !s; i++) {
        bool from_tags;
        s = pose_frame(&poses->poses[i], &from_tags, in, &views->views[i], err);
        out->n_from_tags += !s && from_tags;
    }
    out->n_frames = (int)in->n_frames;
    if (!s)
        s = summarise(out, poses, err);
    if (!s)
        leave_out_blurred(out, poses);
    if (!s && out->n_blurred)
        s = summarise(out, poses, err);
    out->alike = !s && all_alike(poses);
    if (!s && !out->n_found)
        s = sheen_fail(err, SHEEN_EDATA, "none of %zu frames has a pose ('%s': %s)", in->n_frames,
                       poses->poses[0].name, poses->poses[0].reason);
    return s;
}

// One table of corners a board: board.vnl, and board-<name>.vnl for the others of a set.
static sheen_status write_corners(const sheen_session *s, const inputs *in, const sheen_views *views,
                                  size_t b, sheen_err *err)
{
    char path[SHEEN_PATH_MAX], name[96];
    const size_t n_boards = in->set.n_boards;
    const sheen_board *board = &in->set.boards[b];
    if (b)
        snprintf(name, sizeof name, SHEEN_SESSION_DETECTIONS "/board-%s.vnl", board->name);
    else
        snprintf(name, sizeof name, "%s", vnl_name);
    sheen_board_view *of_board = calloc(in->n_frames + 1, sizeof *of_board); // lent from views
    if (!of_board)
        return sheen_fail_memory(err, (double)in->n_frames * sizeof *of_board, "corners");
    for (size_t f = 0; f < in->n_frames; f++)
        of_board[f] = views->views[f * n_boards + b];
    sheen_status st = sheen_session_path(path, s, name, err);
    if (!st)
        st = sheen_vnl_save(path, board, of_board, in->n_frames, err);
    free(of_board);
    return st;
}

static sheen_status write_results(const sheen_session *s, const inputs *in, const sheen_views *views,
                                  const sheen_poses *poses, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    sheen_status st = sheen_session_path(path, s, SHEEN_SESSION_DETECTIONS, err);
    if (!st)
        st = sheen_dir_make(path, err);
    for (size_t b = 0; b < in->set.n_boards && !st; b++)
        st = write_corners(s, in, views, b, err);
    return st ? st : sheen_poses_save(poses, s, err);
}

// True where the session's poses were given by the person; then they are in *poses.
static sheen_status find_imported(bool *imported, sheen_poses *poses, const sheen_session *s, sheen_err *err)
{
    *imported = false;
    if (!sheen_session_has(s, SHEEN_SESSION_POSES))
        return SHEEN_OK;
    const sheen_status st = sheen_poses_load(poses, s, err);
    *imported = !st && poses->imported;
    if (!st && !*imported)
        sheen_poses_release(poses);
    return st;
}

sheen_status sheen_pose_session(sheen_pose_summary *out, sheen_poses *poses_out, const sheen_session *s,
                                const sheen_pose_options *options, sheen_err *err)
{
    inputs in = {0};
    sheen_views views = {0};
    sheen_poses poses = {0};
    *out = (sheen_pose_summary){.rms_median_px = (double)NAN};
    sheen_status st = options->force ? SHEEN_OK : find_imported(&out->left_alone, &poses, s, err);
    if (st || out->left_alone) {
        out->n_frames = out->n_found = (int)poses.n_poses;
        goto done;
    }
    st = load_files(&in, s, err);
    if (!st)
        st = list_frames(&in, s, err);
    if (!st)
        st = sheen_set_views_of_session(&views, s, in.frames, in.n_frames, &in.set,
                                        &(sheen_views_options){.n_threads = options->n_threads,
                                                               .progress = &options->progress,
                                                               .look = search_boards,
                                                               .self = &in},
                                        err);
    if (!st)
        st = pose_all(out, &poses, &in, &views, err);
    if (!st)
        st = write_results(s, &in, &views, &poses, err);

done:
    if (!st && poses_out) {
        *poses_out = poses;
        poses = (sheen_poses){0};
    }
    sheen_poses_release(&poses);
    sheen_views_release(&views);
    sheen_board_set_release(&in.set);
    free(in.frames);
    return st;
}

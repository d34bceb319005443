// SPDX-License-Identifier: Apache-2.0
// moved.c - the verdict from an axis and from the background's patches.
//
// A patch of background is compared with the same place of the next frame by normalised correlation, which neither
// exposure nor a passing shade change. Patches without contrast say nothing.
#include "pose/moved.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "pose/turntable_axis.h"

enum { PATCHES_ACROSS = 40, MIN_PATCHES = 12, MIN_AXIS_VIEWS = 5 };

static const double MIN_CONTRAST = 0.015; // standard deviation in a patch, of 1
static const double SAME = 0.7;           // correlation of a patch that stayed
static const double STILL = 0.7;          // share of patches that stayed where the camera did
static const double MOVING = 0.3;         // and where it did not
static const double MAX_SCATTER = 6;      // of poses about an axis, in sigmas
static const double MIN_TURN_RAD = 0.1;
static const double MOST_TILT_RAD = 0.1; // of the board's plane: twice what a crooked axis comes to
static const double MOST_RISE = 0.05;    // of the plane's distance

// Mean and standard deviation of the patch of side px at (x, y).
static void patch_moments(double *mean, double *sigma, const sheen_image *image, int x, int y, int side)
{
    double sum = 0, squares = 0;
    for (int j = 0; j < side; j++)
        for (int i = 0; i < side; i++) {
            const double v = (double)image->data[(size_t)(y + j) * (size_t)image->width_px + (size_t)(x + i)];
            sum += v;
            squares += v * v;
        }
    const double n = (double)side * side;
    *mean = sum / n;
    *sigma = sqrt(fmax(0, squares / n - *mean * *mean));
}

static double correlation(const sheen_image *a, const sheen_image *b, int x, int y, int side,
                          const double mean[2], const double sigma[2])
{
    double sum = 0;
    for (int j = 0; j < side; j++)
        for (int i = 0; i < side; i++) {
            const size_t at = (size_t)(y + j) * (size_t)a->width_px + (size_t)(x + i);
            sum += ((double)a->data[at] - mean[0]) * ((double)b->data[at] - mean[1]);
        }
    return sum / ((double)side * side * fmax(sigma[0] * sigma[1], 1e-12));
}

// The box in the picture about the board and the space above it; the whole picture where a corner is behind.
static sheen_status board_box(double box[4], const sheen_camera *camera, const double rt[6],
                              const double half_m[2], double height_m, sheen_err *err)
{
    double p_cam[24], q[16];
    sheen_Rt Rt;
    sheen_Rt_from_rt(&Rt, rt);
    for (int c = 0; c < 8; c++) {
        const double p[3] = {c & 1 ? half_m[0] : -half_m[0], c & 2 ? half_m[1] : -half_m[1],
                             c & 4 ? height_m : 0};
        sheen_Rt_point(p_cam + 3 * (size_t)c, &Rt, p);
    }
    const sheen_status s = sheen_camera_project(camera, q, NULL, p_cam, 8, err);
    if (s)
        return s;
    box[0] = box[1] = INFINITY;
    box[2] = box[3] = -INFINITY;
    for (int c = 0; c < 8; c++) {
        if (!isfinite(q[2 * c] + q[2 * c + 1])) {
            box[0] = box[1] = -INFINITY;
            box[2] = box[3] = INFINITY;
            break;
        }
        for (int k = 0; k < 2; k++) {
            box[k] = fmin(box[k], q[2 * c + k]);
            box[2 + k] = fmax(box[2 + k], q[2 * c + k]);
        }
    }
    return SHEEN_OK;
}

static bool apart(const double box[4], int x, int y, int side)
{
    return x + side < box[0] || x > box[2] || y + side < box[1] || y > box[3];
}

typedef struct votes {
    int patches, same;
} votes;

static sheen_status compare_pair(votes *v, const sheen_camera *camera, const double half_m[2],
                                 double height_m, const sheen_moved_frame *a, const sheen_moved_frame *b,
                                 sheen_err *err)
{
    double box_a[4], box_b[4];
    sheen_status s = board_box(box_a, camera, a->rt_cam_board, half_m, height_m, err);
    if (!s)
        s = board_box(box_b, camera, b->rt_cam_board, half_m, height_m, err);
    const int side = camera->width_px / PATCHES_ACROSS > 4 ? camera->width_px / PATCHES_ACROSS : 4;
    for (int y = 0; y + side <= camera->height_px && !s; y += side)
        for (int x = 0; x + side <= camera->width_px; x += side) {
            double mean[2], sigma[2];
            if (!apart(box_a, x, y, side) || !apart(box_b, x, y, side))
                continue;
            patch_moments(&mean[0], &sigma[0], a->light, x, y, side);
            patch_moments(&mean[1], &sigma[1], b->light, x, y, side);
            if (fmax(sigma[0], sigma[1]) < MIN_CONTRAST)
                continue;
            v->patches++;
            v->same += correlation(a->light, b->light, x, y, side, mean, sigma) > SAME;
        }
    return s;
}

// Whether the board's plane, as the camera sees it, is that of the round's first frame.
static bool same_plane(const sheen_moved_frame *f, const sheen_moved_frame *first)
{
    double cosine = 0, distance_m[2] = {0, 0};
    sheen_Rt Rt[2];
    sheen_Rt_from_rt(&Rt[0], first->rt_cam_board);
    sheen_Rt_from_rt(&Rt[1], f->rt_cam_board);
    for (int k = 0; k < 3; k++) {
        cosine += Rt[0].R[k][2] * Rt[1].R[k][2];
        for (int i = 0; i < 2; i++)
            distance_m[i] += Rt[i].R[k][2] * Rt[i].t[k];
    }
    return cosine > cos(MOST_TILT_RAD) &&
           fabs(distance_m[1] - distance_m[0]) < MOST_RISE * fabs(distance_m[0]);
}

static void watch_plane(sheen_moved_verdict *out, const sheen_moved_frame *frames, size_t n)
{
    size_t first = 0;
    for (size_t i = 0; i < n; i++) {
        if (frames[i].round != frames[first].round)
            first = i;
        out->off_table = out->off_table || !same_plane(&frames[i], &frames[first]);
    }
}

static sheen_status find_axis(sheen_moved_verdict *out, const sheen_moved_frame *frames, size_t n,
                              sheen_err *err)
{
    sheen_turntable table;
    double low = INFINITY, high = -INFINITY;
    sheen_turntable_pose *poses = calloc(n + 1, sizeof *poses);
    if (!poses)
        return sheen_fail_memory(err, (double)n * sizeof *poses, "poses");
    for (size_t i = 0; i < n; i++) {
        memcpy(poses[i].rt_cam_board, frames[i].rt_cam_board, sizeof poses[i].rt_cam_board);
        memcpy(poses[i].covariance, frames[i].covariance, sizeof poses[i].covariance);
        low = fmin(low, frames[i].asked_rad);
        high = fmax(high, frames[i].asked_rad);
    }
    out->table_turned = high - low > MIN_TURN_RAD;
    watch_plane(out, frames, n);
    const sheen_status s = n >= MIN_AXIS_VIEWS ? sheen_turntable_solve(&table, poses, n, NULL) : SHEEN_EDATA;
    free(poses);
    if (s == SHEEN_ENOMEM)
        return sheen_fail(err, s, "no memory to look for a turntable's axis");
    if (s)
        return SHEEN_OK; // there is none
    for (size_t i = 0; i < table.n_views; i++)
        if (fabs(table.views[i].angle_rad) > MIN_TURN_RAD && table.scatter < MAX_SCATTER &&
            10 * table.n_used >= 9 * table.n_views)
            out->on_axis = true;
    sheen_turntable_release(&table);
    return SHEEN_OK;
}

static void decide(sheen_moved_verdict *out)
{
    const char *axis = out->on_axis ? "the board turns about one axis" : "the board's poses follow no axis";
    const bool turned = out->on_axis || out->table_turned;
    if (out->still >= STILL) {
        out->moved = SHEEN_MOVED_OBJECT;
        snprintf(out->reason, sizeof out->reason, "the background stands still (%.0f %% of %d patches)",
                 100 * out->still, out->n_patches);
    } else if (out->still <= MOVING) {
        out->moved = out->table_turned ? SHEEN_MOVED_BOTH : SHEEN_MOVED_CAMERA;
        snprintf(out->reason, sizeof out->reason, "the background changes (%.0f %% of %d patches stayed)%s",
                 100 * out->still, out->n_patches, out->table_turned ? " although a table was turned" : "");
    } else if (isfinite(out->still)) {
        out->moved = SHEEN_MOVED_BOTH;
        snprintf(out->reason, sizeof out->reason,
                 "the background stands still in part of the frames only (%.0f %% of %d patches)",
                 100 * out->still, out->n_patches);
    } else if (out->table_turned && out->off_table) {
        out->moved = SHEEN_MOVED_BOTH;
        snprintf(out->reason, sizeof out->reason,
                 "a table was turned, and yet the board tilts or rises before the camera");
    } else {
        out->moved = turned ? SHEEN_MOVED_OBJECT : SHEEN_MOVED_UNKNOWN;
        snprintf(out->reason, sizeof out->reason, "the background shows nothing to go by; %s", axis);
    }
}

static void share(sheen_moved_verdict *out, const votes *v)
{
    out->n_patches = v->patches;
    out->still = v->patches >= MIN_PATCHES ? (double)v->same / v->patches : (double)NAN;
}

sheen_status sheen_moved_find(sheen_moved_verdict *out, const sheen_camera *camera,
                              const double half_board_m[2], double height_m, const sheen_moved_frame *frames,
                              size_t n_frames, sheen_err *err)
{
    votes v = {0};
    *out = (sheen_moved_verdict){.still = (double)NAN};
    sheen_status s = find_axis(out, frames, n_frames, err);
    for (size_t i = 1; i < n_frames && !s; i++)
        if (frames[i].light && frames[i - 1].light && frames[i].round == frames[i - 1].round)
            s = compare_pair(&v, camera, half_board_m, height_m, &frames[i - 1], &frames[i], err);
    if (s)
        return s;
    share(out, &v);
    decide(out);
    return SHEEN_OK;
}

sheen_status sheen_moved_in_session(sheen_moved_verdict *out, const sheen_session *s,
                                    const sheen_camera *camera, const sheen_board *board,
                                    const sheen_poses *poses, size_t most, sheen_err *err)
{
    sheen_moved_frame *frames = calloc(s->n_frames + 1, sizeof *frames);
    sheen_image lights[2] = {{0}};
    votes v = {0};
    const double half_m[2] = {0.5 * board->n_cols * board->square_m, 0.5 * board->n_rows * board->square_m};
    const double height_m = fmax(half_m[0], half_m[1]);
    size_t n = 0;
    *out = (sheen_moved_verdict){.still = (double)NAN};
    if (!frames)
        return sheen_fail_memory(err, (double)s->n_frames * sizeof *frames, "frames");
    sheen_status st = SHEEN_OK;
    for (size_t i = 0; i < s->n_frames && n < most && !st; i++) {
        const sheen_frame_pose *p = sheen_poses_find(poses, s->frames[i].name);
        if (!p || !p->found || !sheen_role_shows_object(s->frames[i].role))
            continue;
        sheen_moved_frame *f = &frames[n];
        memcpy(f->rt_cam_board, p->rt_cam_board, sizeof f->rt_cam_board);
        memcpy(f->covariance, p->covariance, sizeof f->covariance);
        f->asked_rad = s->frames[i].table_asked_deg * 3.14159265358979323846 / 180;
        sheen_image_release(&lights[n % 2]);
        st = sheen_session_grey(&lights[n % 2], s, &s->frames[i], err);
        f->light = &lights[n % 2];
        f->round = isfinite(s->frames[i].table_asked_deg) ? sheen_frame_round(&s->frames[i]) : 0;
        if (!st && n && f->round == frames[n - 1].round)
            st = compare_pair(&v, camera, half_m, height_m, &frames[n - 1], f, err);
        n++;
    }
    if (!st)
        st = find_axis(out, frames, n, err);
    if (!st) {
        share(out, &v);
        decide(out);
    }
    sheen_image_release(&lights[0]);
    sheen_image_release(&lights[1]);
    free(frames);
    return st;
}

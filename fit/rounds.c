// SPDX-License-Identifier: Apache-2.0
// rounds.c - the axis that most neighbouring frames turn about; rounds by it; cameras by it and the commanded angles.
#include "fit/rounds.h"

#include <math.h>
#include <string.h>

#include "base/pose3.h"
#include "base/vec.h"

static const double least_turn_rad = 0.09;                       // less than that shows no axis
static const double most_tilt_rad = 0.05, most_off_share = 0.02; // of an axis; of the distance to the camera

// A line in the board's frame; its direction points up.
typedef struct axis {
    double v_board[3], p_board[3];
} axis;

// The board in frame b as seen from its own frame in frame a: a turn about the axis where the camera stood still.
static void motion(double rt[6], const sheen_round_frame *a, const sheen_round_frame *b)
{
    double rt_board_cam[6];
    sheen_rt_invert(rt_board_cam, a->rt_cam_board);
    sheen_rt_compose(rt, rt_board_cam, b->rt_cam_board);
}

// The turn's angle about the axis, and how far it is from one: as the distance by which it moves a point of the axis.
static double turn_about(double *angle_rad, const axis *x, const double rt[6])
{
    sheen_Rt Rt;
    double moved[3];
    sheen_Rt_from_rt(&Rt, rt);
    sheen_Rt_point(moved, &Rt, x->p_board);
    sheen_sub(moved, moved, x->p_board);
    *angle_rad = sheen_dot(rt, x->v_board);
    return sheen_norm(moved);
}

static int is_about(const axis *x, const double rt[6], double distance_m)
{
    double angle_rad, across[3];
    const double off_m = turn_about(&angle_rad, x, rt), whole_rad = sheen_norm(rt);
    for (int k = 0; k < 3; k++)
        across[k] = rt[k] - angle_rad * x->v_board[k];
    // A turn of half a circle may show its axis reversed: both are about it.
    const double tilt = sheen_norm(across) / (whole_rad > least_turn_rad ? whole_rad : least_turn_rad);
    return tilt < most_tilt_rad && off_m < most_off_share * distance_m;
}

// The axis of one motion: its direction, and the point on it next to the board's origin.
static int axis_of(axis *x, const double rt[6])
{
    const double angle_rad = sheen_norm(rt);
    if (!(angle_rad > least_turn_rad))
        return 0;
    for (int k = 0; k < 3; k++)
        x->v_board[k] = (rt[2] < 0 ? -rt[k] : rt[k]) / angle_rad;
    // p = (t_across + (v x t) / tan(angle / 2)) / 2, with v the turn's own direction.
    const double along = sheen_dot(rt + 3, x->v_board), cot = 1 / tan(angle_rad / 2);
    double across[3], v[3], side[3];
    for (int k = 0; k < 3; k++) {
        across[k] = rt[3 + k] - along * x->v_board[k];
        v[k] = rt[k] / angle_rad;
    }
    sheen_cross(side, v, across);
    for (int k = 0; k < 3; k++)
        x->p_board[k] = 0.5 * (across[k] + cot * side[k]);
    return 1;
}

// The motion between neighbours that most others share, then the mean of those.
static int find_axis(axis *out, const sheen_round_frame *frames, size_t n)
{
    size_t most = 0;
    axis mean = {{0}, {0}}, tried;
    double rt[6];
    for (size_t i = 1; i < n; i++) {
        size_t count = 0;
        motion(rt, &frames[i - 1], &frames[i]);
        if (!axis_of(&tried, rt))
            continue;
        for (size_t k = 1; k < n; k++) {
            motion(rt, &frames[k - 1], &frames[k]);
            count += is_about(&tried, rt, sheen_norm(frames[k].rt_cam_board + 3)) != 0;
        }
        if (count > most) {
            most = count;
            *out = tried;
        }
    }
    double weight = 0;
    for (size_t k = 1; k < n && most; k++) {
        motion(rt, &frames[k - 1], &frames[k]);
        if (!is_about(out, rt, sheen_norm(frames[k].rt_cam_board + 3)) || !axis_of(&tried, rt))
            continue;
        const double w = sin(sheen_norm(rt) / 2) * sin(sheen_norm(rt) / 2);
        weight += w;
        for (int c = 0; c < 3; c++) {
            mean.v_board[c] += w * tried.v_board[c];
            mean.p_board[c] += w * tried.p_board[c];
        }
    }
    if (!(weight > 0) || !(sheen_normalize(mean.v_board) > 0))
        return 0;
    for (int c = 0; c < 3; c++)
        mean.p_board[c] /= weight;
    *out = mean;
    return 1;
}

// Marks each frame with the round in which the camera stood as in this frame.
static void mark(sheen_rounds *out, sheen_round_frame *frames, size_t n, size_t i_first, const axis *x)
{
    size_t first[SHEEN_MAX_ROUNDS] = {i_first}, count[SHEEN_MAX_ROUNDS] = {0};
    int name[SHEEN_MAX_ROUNDS] = {0};
    out->n = 1;
    for (size_t i = 0; i < n; i++) {
        double rt[6];
        frames[i].round = -1;
        for (int r = 0; r < out->n && frames[i].round < 0; r++) {
            motion(rt, &frames[first[r]], &frames[i]);
            if (is_about(x, rt, sheen_norm(frames[i].rt_cam_board + 3)))
                frames[i].round = r;
        }
        if (frames[i].round < 0 && out->n < SHEEN_MAX_ROUNDS) {
            first[out->n] = i;
            frames[i].round = out->n++;
        }
        if (frames[i].round >= 0)
            count[frames[i].round]++;
    }
    int kept = 0;
    for (int r = 0; r < out->n; r++)
        name[r] = !r || count[r] >= SHEEN_ROUND_LEAST_FRAMES ? kept++ : -1;
    for (size_t i = 0; i < n; i++)
        frames[i].round = frames[i].round < 0 ? -1 : name[frames[i].round];
    out->n = kept;
}

// The camera in the axis' own frame as a frame's pose and commanded angle have it; world: the board's frame at angle 0.
static void camera_by_angle(double rt_zero_cam[6], const axis *x, const sheen_round_frame *f)
{
    double rt_zero_board[6], rt_board_cam[6], moved[3];
    sheen_Rt Rt;
    for (int k = 0; k < 3; k++) {
        rt_zero_board[k] = f->asked_rad * x->v_board[k];
        rt_zero_board[3 + k] = 0;
    }
    sheen_Rt_from_rt(&Rt, rt_zero_board); // about the axis, which need not pass through the origin
    sheen_Rt_point(moved, &Rt, x->p_board);
    sheen_sub(rt_zero_board + 3, x->p_board, moved);
    sheen_rt_invert(rt_board_cam, f->rt_cam_board);
    sheen_rt_compose(rt_zero_cam, rt_zero_board, rt_board_cam);
}

// The mean over a round's frames; *off_rad: the worst of them beside it. EDATA: an angle is not known.
static sheen_status mean_camera(double rt_zero_cam[6], double *off_rad, const axis *x,
                                const sheen_round_frame *frames, size_t n, int round, sheen_err *err)
{
    double first[6] = {0}, back[6] = {0}, mean[6] = {0}, here[6], off[6];
    int count = 0;
    for (size_t i = 0; i < n; i++) {
        if (frames[i].round != round)
            continue;
        if (!isfinite(frames[i].asked_rad))
            return sheen_fail(
                err, SHEEN_EDATA,
                "frame '%s' does not turn about the axis of the others: the camera moved, too, "
                "and no commanded angle "
                "says how the table stood. Fit each height of the camera as a session of its own; "
                "if the object stood still, the session should say so (sheen import --moving "
                "camera)",
                frames[i].name);
        camera_by_angle(here, x, &frames[i]);
        if (!count++) {
            memcpy(first, here, sizeof first);
            sheen_rt_invert(back, first);
        }
        sheen_rt_compose(off, back, here);
        for (int k = 0; k < 6; k++)
            mean[k] += off[k];
    }
    for (int k = 0; k < 6; k++)
        mean[k] /= count ? count : 1;
    sheen_rt_compose(rt_zero_cam, first, mean);
    sheen_rt_invert(back, rt_zero_cam);
    for (size_t i = 0; i < n; i++)
        if (frames[i].round == round) {
            camera_by_angle(here, x, &frames[i]);
            sheen_rt_compose(off, back, here);
            *off_rad = fmax(*off_rad, sheen_norm(off));
        }
    return SHEEN_OK;
}

// All cameras by the commanded angles, then moved together so that the first is where its own pose says.
static sheen_status tie(sheen_rounds *out, const sheen_round_frame *frames, size_t n, const axis *x,
                        sheen_err *err)
{
    double rt_zero_cam[SHEEN_MAX_ROUNDS][6], rt_cam_zero[6], rt_world_zero[6], off_rad = 0;
    for (int r = 0; r < out->n; r++) {
        const sheen_status s = mean_camera(rt_zero_cam[r], &off_rad, x, frames, n, r, err);
        if (s)
            return s;
    }
    out->most_off_deg = off_rad * 180 / 3.14159265358979323846;
    if (off_rad > most_tilt_rad)
        return sheen_fail(
            err, SHEEN_EDATA,
            "the camera stood at %d places, and the table does not stand as it was told (%.1f "
            "degrees off): it slipped, or was turned by hand between two rounds. Fit each height "
            "of the camera as a session of its own",
            out->n, out->most_off_deg);
    sheen_rt_invert(rt_cam_zero, rt_zero_cam[0]);
    sheen_rt_compose(rt_world_zero, out->rt_world_cam[0], rt_cam_zero);
    for (int r = 1; r < out->n; r++)
        sheen_rt_compose(out->rt_world_cam[r], rt_world_zero, rt_zero_cam[r]);
    return SHEEN_OK;
}

sheen_status sheen_rounds_find(sheen_rounds *out, sheen_round_frame *frames, size_t n_frames, size_t i_first,
                               sheen_err *err)
{
    axis x;
    *out = (sheen_rounds){.n = 1};
    sheen_rt_invert(out->rt_world_cam[0], frames[i_first].rt_cam_board);
    for (size_t i = 0; i < n_frames; i++)
        frames[i].round = 0;
    if (!find_axis(&x, frames, n_frames)) // nothing turned
        return SHEEN_OK;
    mark(out, frames, n_frames, i_first, &x);
    return out->n > 1 ? tie(out, frames, n_frames, &x, err) : SHEEN_OK;
}

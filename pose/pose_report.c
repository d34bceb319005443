// SPDX-License-Identifier: Apache-2.0
// pose_report.c - poses as a page for a person: what they are worth, and what to do about those that are not.
#include "pose/pose_report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/pose3.h"
#include "base/report.h"
#include "pose/turntable_session.h"

static const double DEG_PER_RAD = 57.29577951308232;
static const double GOOD_SHARE = 0.8;    // of frames that have a pose
static const double GOOD_RMS_PX = 0.3;   // median
static const double GOOD_SIGMA_M = 5e-4; // worst

typedef struct figures {
    size_t n_found, n_remarks;
    double rms_max_px, rms_mean_px, sigma_max_m;
} figures;

static double sigma_m(const sheen_frame_pose *p)
{
    double var = 0;
    for (size_t i = 3; i < 6; i++)
        var = fmax(var, p->covariance[7 * i]);
    return sqrt(var);
}

static double sigma_deg(const sheen_frame_pose *p)
{
    double var = 0;
    for (size_t i = 0; i < 3; i++)
        var = fmax(var, p->covariance[7 * i]);
    return DEG_PER_RAD * sqrt(var);
}

static figures collect(const sheen_poses *poses)
{
    figures f = {0};
    for (size_t i = 0; i < poses->n_poses; i++) {
        const sheen_frame_pose *p = &poses->poses[i];
        f.n_remarks += p->reason[0] != 0;
        if (!p->found)
            continue;
        f.n_found++;
        f.rms_max_px = fmax(f.rms_max_px, p->rms_px);
        f.rms_mean_px += p->rms_px;
        f.sigma_max_m = fmax(f.sigma_max_m, sigma_m(p));
    }
    f.rms_mean_px /= fmax(1, (double)f.n_found);
    return f;
}

static void begin(sheen_report *r, const sheen_poses *poses, const figures *f)
{
    char verdict[300];
    bool moved = false;
    for (size_t b = 0; b < poses->n_boards; b++)
        moved = moved || poses->boards[b].n_moved;
    const bool enough = (double)f->n_found >= GOOD_SHARE * (double)poses->n_poses;
    const char *advice = poses->imported ? "poses were imported; nothing was measured"
                         : !enough
                             ? "look at the frames without a pose below: more of the board has to be in view"
                         : !(f->rms_mean_px <= GOOD_RMS_PX)
                             ? "corners fit badly: calibrate this camera at this focus and size again"
                         : !(f->sigma_max_m <= GOOD_SIGMA_M)
                             ? "some poses are weak: bring the board nearer, or more of it into view"
                         : moved ? "a board was moved while pictures were taken: fasten it"
                                 : "nothing is left to do";
    const bool good = enough && f->rms_mean_px <= GOOD_RMS_PX && f->sigma_max_m <= GOOD_SIGMA_M && !moved;
    snprintf(verdict, sizeof verdict,
             "%zu of %zu frames have a pose, corners fit to %.3f px an axis, the worst place is "
             "known to %.3f mm: %s",
             f->n_found, poses->n_poses, f->rms_mean_px, 1e3 * f->sigma_max_m, advice);
    sheen_report_begin(r, "Poses", good, verdict);
}

static void table(sheen_report *r, const sheen_poses *poses)
{
    sheen_report_section(r, "Frames");
    sheen_report_text(
        r, "rms is an axis, over the points that count; the sigmas are of the pose's largest axis, from "
           "the residuals' own scatter.");
    sheen_report_table(r, "frame|points|outliers|rms px|sigma mm|sigma degrees|distance mm|remark");
    for (size_t i = 0; i < poses->n_poses; i++) {
        const sheen_frame_pose *p = &poses->poses[i];
        if (!p->found)
            sheen_report_row(r, "%s|||||||no pose: %s", p->name, p->reason);
        else
            sheen_report_row(r, "%s|%d|%d|%.3f|%.4f|%.4f|%.1f|%s", p->name, p->n_points, p->n_outliers,
                             p->rms_px, 1e3 * sigma_m(p), sigma_deg(p),
                             1e3 * sqrt(p->rt_cam_board[3] * p->rt_cam_board[3] +
                                        p->rt_cam_board[4] * p->rt_cam_board[4] +
                                        p->rt_cam_board[5] * p->rt_cam_board[5]),
                             p->reason);
    }
}

// xy of the cameras in the board's frame, and errors by frame; arrays of n_found pairs.
static void plots(sheen_report *r, const sheen_poses *poses, const figures *f, double *places, double *errors)
{
    size_t n = 0;
    double extent = 0.1;
    for (size_t i = 0; i < poses->n_poses; i++) {
        const sheen_frame_pose *p = &poses->poses[i];
        if (!p->found)
            continue;
        double rt_board_cam[6];
        sheen_rt_invert(rt_board_cam, p->rt_cam_board);
        places[2 * n] = 1e3 * rt_board_cam[3];
        places[2 * n + 1] = 1e3 * rt_board_cam[4];
        extent = fmax(extent, 1.1 * fmax(fabs(rt_board_cam[3]), fabs(rt_board_cam[4])));
        errors[2 * n] = (double)i;
        errors[2 * n++ + 1] = p->rms_px;
    }
    sheen_report_section(r, "Where the camera stood");
    sheen_plot above = {.title = "cameras from above, board at the origin",
                        .x_label = "mm",
                        .y_label = "mm",
                        .x_min = -1e3 * extent,
                        .x_max = 1e3 * extent,
                        .y_min = -1e3 * extent,
                        .y_max = 1e3 * extent,
                        .same_scale = true};
    sheen_plot_begin(r, &above);
    sheen_plot_points(r, &above, places, n, NULL, 3);
    sheen_plot_points(r, &above, (const double[2]){0, 0}, 1, "#c33", 4);
    sheen_plot_end(r, &above);
    sheen_plot by_frame = {.title = "reprojection error by frame",
                           .x_label = "frame",
                           .y_label = "px",
                           .x_min = -0.5,
                           .x_max = fmax(1, (double)poses->n_poses - 0.5),
                           .y_max = fmax(1e-3, 1.1 * f->rms_max_px)};
    sheen_plot_begin(r, &by_frame);
    sheen_plot_points(r, &by_frame, errors, n, NULL, 2.5);
    sheen_plot_end(r, &by_frame);
}

static void boards(sheen_report *r, const sheen_poses *poses)
{
    if (!poses->n_boards)
        return;
    sheen_report_section(r, "Boards");
    sheen_report_text(
        r, "Where each board is in the frame of the first, from one bundle adjustment over all frames.");
    sheen_report_table(r, "board|frames|moved in|x mm|y mm|z mm|sigma mm|remark");
    for (size_t b = 0; b < poses->n_boards; b++) {
        const sheen_board_place *p = &poses->boards[b];
        double var = 0;
        for (size_t i = 3; i < 6; i++)
            var = fmax(var, p->covariance[7 * i]);
        sheen_report_row(r, "%s|%d|%d|%.3f|%.3f|%.3f|%.4f|%s", p->name, p->n_frames, p->n_moved,
                         1e3 * p->rt_ref_board[3], 1e3 * p->rt_ref_board[4], 1e3 * p->rt_ref_board[5],
                         1e3 * sqrt(var), p->reason);
    }
}

static void turntable(sheen_report *r, const sheen_session *s, const sheen_poses *poses)
{
    sheen_session_turntable t;
    sheen_err why = {0};
    if (s->moving != SHEEN_MOVING_OBJECT)
        return;
    sheen_report_section(r, "Turntable");
    if (sheen_session_turntable_find(&t, s, poses, &why)) {
        sheen_report_text(r, "%s", why.msg);
        return;
    }
    sheen_report_text(
        r,
        "The axis is known to %.4f degrees and %.3f mm from %zu of %zu frames; poses scatter %.1f times "
        "what is predicted.",
        DEG_PER_RAD * t.table.sigma_axis_rad, 1e3 * t.table.sigma_origin_m, t.table.n_used, t.table.n_views,
        t.table.scatter);
    if (t.has_gain)
        sheen_report_text(
            r, "Per commanded degree it turns %.5f +- %.5f degrees; rms %.4f, worst %.4f degrees (%s).",
            t.gain.gain, t.gain.sigma_gain, DEG_PER_RAD * t.gain.rms_rad, DEG_PER_RAD * t.gain.worst_rad,
            t.frames[t.gain.i_worst]->name);
    sheen_report_table(r, "frame|measured degrees|sigma|commanded|misfit in sigmas");
    for (size_t i = 0; i < t.table.n_views; i++)
        sheen_report_row(r, "%s|%.4f|%.4f|%.4f|%.1f%s", t.frames[i]->name,
                         DEG_PER_RAD * t.table.views[i].angle_rad, DEG_PER_RAD * t.table.views[i].sigma_rad,
                         DEG_PER_RAD * t.asked_rad[i], t.table.views[i].misfit,
                         t.table.views[i].used ? "" : " (left out)");
    sheen_session_turntable_release(&t);
}

sheen_status sheen_pose_report(const char *path, const sheen_session *s, const sheen_poses *poses,
                               sheen_err *err)
{
    sheen_report r = {0};
    const figures f = collect(poses);
    double *places = malloc((4 * poses->n_poses + 4) * sizeof *places);
    if (!places)
        return sheen_fail_memory(err, (double)poses->n_poses * 32, "a report");
    begin(&r, poses, &f);
    plots(&r, poses, &f, places, places + 2 * poses->n_poses);
    boards(&r, poses);
    turntable(&r, s, poses);
    table(&r, poses);
    free(places);
    return sheen_report_save(&r, path, err);
}

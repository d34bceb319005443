// SPDX-License-Identifier: Apache-2.0
// board_pose.c - one frame's pose: from the saddles, with those that do not fit left out; from the tags where there
// are too few saddles; and the tests that keep a wrong pose from being believed.
//
// An object's outline spoils two saddles a frame on average, and leaving them in makes the error three times as
// large. Residuals are judged against 4 times their median, at least 0.12 px, over four rounds, points coming back
// as the pose improves.
#include "pose/board_pose.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/order.h"
#include "base/pose3.h"
#include "base/vec.h"
#include "pose/pose_fit.h"

enum { ROUNDS = 4, MIN_TAGS = 2 };

static const double REJECT_MEDIANS = 4;
static const double REJECT_FLOOR_PX = 0.12;
static const double TAG_REJECT_FLOOR_PX = 1.0; // tags' corners move by blur
static const double MIN_SPREAD_SQUARES = 0.45; // standard deviation along the narrow side: two rows are 0.5
static const double MAX_RMS_PX = 2;            // of saddles: more is another camera
static const double MIN_INLIERS = 0.5;         // share of points
static const double MAX_TAG_ERROR_PX = 1;      // and in parts of a tag's side, for large pictures
static const double MAX_TAG_ERROR_SIDES = 0.03;
static const double MAX_SIGMA_RAD = 0.02;   // one degree and a bit
static const double MAX_SIGMA_SHARE = 0.01; // of the distance
static const double MIN_SIGMA_PX = 0.01;    // a handful of points may fit by chance
static const double TAG_MIN_SIGMA_PX = 0.3; // tags' corners move together

// The median of those values that are finite; sorts them. NaN where there are none.
static double median(double *x, size_t n)
{
    size_t m = 0;
    for (size_t i = 0; i < n; i++)
        if (isfinite(x[i]))
            x[m++] = x[i];
    qsort(x, m, sizeof *x, sheen_ascending);
    return m ? x[m / 2] : (double)NAN;
}

// Standard deviation of the points in use along the direction in the board in which it is smallest.
static double spread_m(const sheen_pose_points *points)
{
    double n = 0, mean[2] = {0}, c[3] = {0};
    for (size_t i = 0; i < points->n; i++)
        if (points->use[i]) {
            n++;
            mean[0] += points->p_board[3 * i];
            mean[1] += points->p_board[3 * i + 1];
        }
    for (size_t i = 0; i < points->n; i++)
        if (points->use[i]) {
            const double x = points->p_board[3 * i] - mean[0] / n,
                         y = points->p_board[3 * i + 1] - mean[1] / n;
            c[0] += x * x / n;
            c[1] += x * y / n;
            c[2] += y * y / n;
        }
    return sqrt(fmax(0, (c[0] + c[2]) / 2 - hypot((c[0] - c[2]) / 2, c[1])));
}

// Fits, judges residuals, and fits again, until the same points are in use twice.
static sheen_status fit_robustly(sheen_board_pose *out, const sheen_camera *camera, sheen_pose_points *points,
                                 double floor_px, sheen_err *err)
{
    double *error_px = malloc(2 * points->n * sizeof *error_px),
           *sorted = error_px ? error_px + points->n : NULL;
    if (!error_px)
        return sheen_fail_memory(err, 2 * (double)points->n * sizeof *error_px, "a pose");
    sheen_status s = sheen_pose_seed(out->rt_cam_board, camera, points, err);
    for (int round = 0; round <= ROUNDS && !s; round++) {
        s = sheen_pose_refine(out->rt_cam_board, &out->rms_px, camera, points, err);
        if (!s)
            s = sheen_pose_errors(error_px, out->rt_cam_board, camera, points, err);
        if (s || round == ROUNDS)
            break;
        memcpy(sorted, error_px, points->n * sizeof *sorted);
        const double limit_px = fmax(floor_px, REJECT_MEDIANS * median(sorted, points->n));
        bool changed = false;
        for (size_t i = 0; i < points->n; i++) {
            const bool use = error_px[i] <= limit_px;
            changed = changed || use != points->use[i];
            points->use[i] = use;
        }
        if (!changed)
            break;
    }
    free(error_px);
    out->n_points = out->n_outliers = 0;
    for (size_t i = 0; i < points->n; i++) {
        out->n_points += points->use[i];
        out->n_outliers += !points->use[i];
    }
    return s;
}

static sheen_status points_of_saddles(sheen_pose_points *points, const sheen_board_view *view, sheen_err *err)
{
    double(*covariance)[3] = malloc((view->n_saddles + 1) * sizeof *covariance);
    sheen_status s = covariance
                         ? sheen_pose_points_init(points, view->n_saddles, err)
                         : sheen_fail_memory(err, (double)view->n_saddles * sizeof *covariance, "a pose");
    for (size_t i = 0; i < view->n_saddles && !s; i++) {
        memcpy(points->p_board + 3 * i, view->saddles[i].p_board, 3 * sizeof(double));
        memcpy(points->q_px + 2 * i, view->saddles[i].q_px, 2 * sizeof(double));
        memcpy(covariance[i], view->saddles[i].covariance, sizeof covariance[i]);
        points->use[i] = true;
    }
    if (!s)
        sheen_pose_points_weigh(points, (const double(*)[3])covariance);
    free(covariance);
    return s;
}

static sheen_status points_of_tags(sheen_pose_points *points, const sheen_board_view *view, sheen_err *err)
{
    const sheen_status s = sheen_pose_points_init(points, 4 * view->n_tags, err);
    for (size_t i = 0; i < view->n_tags && !s; i++)
        for (size_t k = 0; k < 4; k++) {
            memcpy(points->p_board + 3 * (4 * i + k), view->tags[i].p_board[k], 3 * sizeof(double));
            memcpy(points->q_px + 2 * (4 * i + k), view->tags[i].q_px[k], 2 * sizeof(double));
            points->use[4 * i + k] = true;
        }
    return s;
}

// Mean of a tag's corners, to which blur and ink gain do nothing.
static void centre(double out[2], const double q[4][2])
{
    for (int k = 0; k < 2; k++)
        out[k] = (q[0][k] + q[1][k] + q[2][k] + q[3][k]) / 4;
}

// Median distance of the tags' centres from where the pose puts them, and the median length of a tag's side.
static sheen_status tag_agreement(double *error_px, double *side_px, const double rt_cam_board[6],
                                  const sheen_camera *camera, const sheen_board_view *view, sheen_err *err)
{
    const size_t n = view->n_tags;
    sheen_pose_points points;
    sheen_status s = points_of_tags(&points, view, err);
    if (s)
        return s;
    double *values = malloc((6 * n + 1) * sizeof *values);
    if (!values) {
        sheen_pose_points_release(&points);
        return sheen_fail_memory(err, 6 * (double)n * sizeof *values, "a pose");
    }
    s = sheen_pose_errors(values, rt_cam_board, camera, &points, err);
    for (size_t i = 0; i < n && !s; i++) {
        double fitted[4][2], a[2], b[2];
        memcpy(fitted, points.fit_px + 8 * i, sizeof fitted);
        centre(a, (const double(*)[2])fitted);
        centre(b, (const double(*)[2])view->tags[i].q_px);
        values[4 * n + i] = hypot(a[0] - b[0], a[1] - b[1]);
        values[5 * n + i] = hypot(view->tags[i].q_px[0][0] - view->tags[i].q_px[2][0],
                                  view->tags[i].q_px[0][1] - view->tags[i].q_px[2][1]) /
                            sqrt(2.0);
    }
    if (!s) {
        *error_px = median(values + 4 * n, n);
        *side_px = median(values + 5 * n, n);
    }
    free(values);
    sheen_pose_points_release(&points);
    return s;
}

// A plane seen from afar looks nearly the same when its normal is mirrored about the line of sight. True where the
// points fit that other pose too, by what their number lets one tell apart.
static sheen_status is_ambiguous(bool *ambiguous, const sheen_board_pose *p, const sheen_camera *camera,
                                 sheen_pose_points *points, sheen_err *err)
{
    // R' = half turn about the line of sight, R, half turn about the board's normal
    sheen_Rt Rt, turn, mirrored;
    double axis[6] = {0}, other[6], rms_px;
    memcpy(axis, p->rt_cam_board + 3, 3 * sizeof *axis);
    sheen_normalize(axis);
    for (int i = 0; i < 3; i++)
        axis[i] *= 3.14159265358979323846;
    sheen_Rt_from_rt(&turn, axis);
    sheen_Rt_from_rt(&Rt, p->rt_cam_board);
    sheen_Rt_compose(&mirrored, &turn, &Rt);
    for (int i = 0; i < 3; i++) {
        mirrored.R[i][0] *= -1;
        mirrored.R[i][1] *= -1;
        mirrored.t[i] = Rt.t[i];
    }
    sheen_rt_from_Rt(other, &mirrored);
    *ambiguous = false;
    const sheen_status s = sheen_pose_refine(other, &rms_px, camera, points, err);
    if (s)
        return s == SHEEN_EDATA ? SHEEN_OK : s; // no pose there at all
    const double freedom = fmax(1, 2.0 * p->n_points - 6);
    const double limit_px = (1 + 4 / sqrt(freedom)) *
                            fmax(p->rms_px, p->from_tags ? TAG_MIN_SIGMA_PX : MIN_SIGMA_PX);
    *ambiguous = rms_px < limit_px && sheen_rt_angle_rad(other, p->rt_cam_board) > MAX_SIGMA_RAD;
    return SHEEN_OK;
}

// Refuses a pose which its own figures speak against.
static sheen_status check(const sheen_board_pose *p, const sheen_pose_points *points,
                          const sheen_board *board, double tag_side_px, sheen_err *err)
{
    const int n = p->n_points + p->n_outliers;
    double distance_m = sheen_norm(p->rt_cam_board + 3), var_r = 0, var_t = 0;
    for (size_t i = 0; i < 3; i++) {
        var_r = fmax(var_r, p->covariance[7 * i]);
        var_t = fmax(var_t, p->covariance[7 * (3 + i)]);
    }
    if (p->n_points < SHEEN_POSE_MIN_SADDLES && !p->from_tags)
        return sheen_fail(err, SHEEN_EDATA, "only %d of %d corners agree, at least %d are needed",
                          p->n_points, n, (int)SHEEN_POSE_MIN_SADDLES);
    if (p->n_points < MIN_INLIERS * n || !(p->rms_px <= MAX_RMS_PX))
        return sheen_fail(
            err, SHEEN_EDATA,
            "the board's corners do not fit the camera (%d of %d agree, to %.2f px): is it this camera's "
            "calibration, and this board",
            p->n_points, n, p->rms_px);
    if (!(spread_m(points) >= (p->from_tags ? 0 : MIN_SPREAD_SQUARES) * board->square_m))
        return sheen_fail(err, SHEEN_EDATA, "the %d corners in view lie in a strip", p->n_points);
    if (!(p->tag_error_px <= fmax(MAX_TAG_ERROR_PX, MAX_TAG_ERROR_SIDES * tag_side_px)))
        return sheen_fail(err, SHEEN_EDATA, "corners and tags contradict each other by %.1f px",
                          p->tag_error_px);
    if (!(sqrt(var_r) <= MAX_SIGMA_RAD && sqrt(var_t) <= MAX_SIGMA_SHARE * distance_m))
        return sheen_fail(err, SHEEN_EDATA,
                          "the %d points in view leave the pose uncertain by %.1f degrees, %.1f mm",
                          p->n_points, sqrt(var_r) * 57.29577951308232, 1e3 * sqrt(var_t));
    return SHEEN_OK;
}

static sheen_status find_from(sheen_board_pose *out, const sheen_camera *camera, const sheen_board *board,
                              const sheen_board_view *view, sheen_pose_points *points, sheen_err *err)
{
    double side_px = 0;
    bool ambiguous;
    sheen_status s = fit_robustly(out, camera, points, out->from_tags ? TAG_REJECT_FLOOR_PX : REJECT_FLOOR_PX,
                                  err);
    if (s)
        return s;
    // sigma from the residuals, 2 n of them less 6 for the pose. As sigma itself is estimated, errors follow
    // Student's t with nu = 2 n - 6 degrees of freedom, whose covariance is nu / (nu - 2) times larger
    const double n = 2.0 * out->n_points, nu = fmax(3, n - 6);
    const double least_px = out->from_tags ? TAG_MIN_SIGMA_PX : MIN_SIGMA_PX;
    const double sigma_px = fmax(least_px, out->rms_px * sqrt(n / nu * nu / (nu - 2)));
    s = sheen_pose_covariance(out->covariance, out->rt_cam_board, sigma_px, camera, points, err);
    if (!s)
        s = tag_agreement(&out->tag_error_px, &side_px, out->rt_cam_board, camera, view, err);
    if (!s)
        s = check(out, points, board, side_px, err);
    if (!s)
        s = is_ambiguous(&ambiguous, out, camera, points, err);
    if (!s && ambiguous)
        s = sheen_fail(err, SHEEN_EDATA, "the %d points in view fit two poses equally well", out->n_points);
    return s;
}

sheen_status sheen_board_pose_find(sheen_board_pose *out, bool *is_inlier, const sheen_camera *camera,
                                   const sheen_board *board, const sheen_board_view *view, sheen_err *err)
{
    *out = (sheen_board_pose){.from_tags = view->n_saddles < SHEEN_POSE_MIN_SADDLES};
    if (is_inlier)
        memset(is_inlier, 0, view->n_saddles * sizeof *is_inlier);
    if (!view->n_tags)
        return sheen_fail(err, SHEEN_EDATA, "no tag of the board in view");
    if (out->from_tags && view->n_tags < MIN_TAGS)
        return sheen_fail(err, SHEEN_EDATA, "only %zu tag and %zu corners of the board in view", view->n_tags,
                          view->n_saddles);
    for (size_t i = 0; i < view->n_saddles; i++)
        if (!isfinite(view->saddles[i].q_px[0]) || !isfinite(view->saddles[i].q_px[1]))
            return sheen_fail(err, SHEEN_EDATA, "a corner in frame '%s' is not a finite number", view->name);
    sheen_pose_points points;
    sheen_status s = out->from_tags ? points_of_tags(&points, view, err)
                                    : points_of_saddles(&points, view, err);
    if (!s)
        s = find_from(out, camera, board, view, &points, err);
    if (!s && is_inlier && !out->from_tags)
        memcpy(is_inlier, points.use, view->n_saddles * sizeof *is_inlier);
    sheen_pose_points_release(&points);
    return s;
}

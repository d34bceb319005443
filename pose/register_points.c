// SPDX-License-Identifier: Apache-2.0
// register_points.c - Levenberg-Marquardt on marked points over all frames, from 48 turns about where the lines of
// sight come nearest to each other.
#include "pose/register_points.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "base/scan.h"
#include "base/vec.h"
#include "calib/cholesky.h"

enum { N = 7, N_UPS = 6, N_TURNS = 8, MAX_STEPS = 60 };

static const double PI = 3.14159265358979323846;
static const double MIN_SIGMA_PX = 0.5; // a person's hand
static const double MAX_SIGMA_RAD = 0.1;

static sheen_status parse_line(sheen_register_point *p, sheen_scan *line, size_t number, sheen_err *err)
{
    sheen_word name, more;
    double x[5];
    bool ok = sheen_scan_word(line, &name) && name.length < sizeof p->frame;
    for (int i = 0; i < 5 && ok; i++)
        ok = sheen_scan_number(line, &x[i]) && fabs(x[i]) < 1e9;
    if (!ok || sheen_scan_word(line, &more))
        return sheen_fail(err, SHEEN_EFORMAT, "line %zu is not 'frame x y X Y Z' with five numbers", number);
    snprintf(p->frame, sizeof p->frame, "%.*s", (int)name.length, name.text);
    memcpy(p->q_px, x, sizeof p->q_px);
    memcpy(p->p_obj, x + 2, sizeof p->p_obj);
    return SHEEN_OK;
}

sheen_status sheen_register_points_parse(sheen_register_point **points_out, size_t *n_out, const void *data,
                                         size_t size_bytes, sheen_err *err)
{
    sheen_scan text = {.at = data, .end = (const char *)data + size_bytes}, line;
    sheen_register_point *list = NULL;
    size_t n = 0, capacity = 0;
    sheen_status s = SHEEN_OK;
    *points_out = NULL;
    *n_out = 0;
    while (!s && sheen_scan_line(&text, &line)) {
        const char *remark = line.at < line.end ? memchr(line.at, '#', (size_t)(line.end - line.at)) : NULL;
        line.end = remark ? remark : line.end;
        sheen_scan ahead = line;
        sheen_word word;
        if (!sheen_scan_word(&ahead, &word))
            continue;
        if (n == SHEEN_REGISTER_MAX_POINTS)
            s = sheen_fail(err, SHEEN_EFORMAT, "more than %d marks", (int)SHEEN_REGISTER_MAX_POINTS);
        else if (n == capacity) {
            capacity = 2 * capacity + 16;
            sheen_register_point *grown = realloc(list, capacity * sizeof *grown);
            if (!grown)
                s = sheen_fail_memory(err, (double)capacity * sizeof *grown, "marks");
            else
                list = grown;
        }
        if (!s)
            s = parse_line(&list[n++], &line, text.line, err);
    }
    if (!s && !n)
        s = sheen_fail(err, SHEEN_EDATA, "the file has no marks: lines of 'frame x y X Y Z' are wanted");
    if (s) {
        free(list);
        return s;
    }
    *points_out = list;
    *n_out = n;
    return SHEEN_OK;
}

// A mark with what is known of its frame.
typedef struct mark {
    sheen_Rt Rt_cam_board;
    double q_px[2], p_obj[3];
    size_t index;
} mark;

typedef struct problem {
    mark *marks;
    size_t n;
    const sheen_camera *camera;
    bool free_scale;
    double centre_obj[3], centre_board[3], size_obj;
} problem;

typedef struct equations {
    double H[N * N], b[N], cost, worst_px, pivot[3];
    size_t i_worst;
} equations;

static bool evaluate(equations *eq, const problem *p, const sheen_placement *at)
{
    double scaled[3];
    memset(eq, 0, sizeof *eq);
    for (int k = 0; k < 3; k++)
        scaled[k] = at->scale * p->centre_obj[k];
    sheen_Rt_point(eq->pivot, &at->Rt_board_obj, scaled);
    for (size_t i = 0; i < p->n; i++) {
        const mark *m = &p->marks[i];
        double p_board[3], p_cam[3], q[2], dq[6], arm[3];
        for (int k = 0; k < 3; k++)
            scaled[k] = at->scale * m->p_obj[k];
        sheen_Rt_point(p_board, &at->Rt_board_obj, scaled);
        sheen_Rt_point(p_cam, &m->Rt_cam_board, p_board);
        if (sheen_camera_project(p->camera, q, dq, p_cam, 1, NULL) || !isfinite(q[0] + q[1]))
            return false;
        sheen_sub(arm, p_board, eq->pivot);
        const double distance = hypot(m->q_px[0] - q[0], m->q_px[1] - q[1]);
        if (distance >= eq->worst_px) {
            eq->worst_px = distance;
            eq->i_worst = m->index;
        }
        for (int k = 0; k < 2; k++) {
            double J[N], g[3];
            const double e = m->q_px[k] - q[k];
            for (int c = 0; c < 3; c++) // to the board's axes
                g[c] = dq[3 * k] * m->Rt_cam_board.R[0][c] + dq[3 * k + 1] * m->Rt_cam_board.R[1][c] +
                       dq[3 * k + 2] * m->Rt_cam_board.R[2][c];
            sheen_cross(J, arm, g);
            memcpy(J + 3, g, sizeof g);
            J[6] = p->free_scale ? sheen_dot(arm, g) : 0;
            eq->cost += e * e;
            for (int u = 0; u < N; u++) {
                eq->b[u] += J[u] * e;
                for (int v = 0; v <= u; v++)
                    eq->H[N * u + v] += J[u] * J[v];
            }
        }
    }
    return isfinite(eq->cost);
}

static void move(sheen_placement *out, const sheen_placement *at, const double step[N], const double pivot[3])
{
    sheen_Rt turn, still = at->Rt_board_obj;
    double arm[3];
    sheen_Rt_from_rt(&turn, (const double[6]){step[0], step[1], step[2], 0, 0, 0});
    sheen_sub(arm, still.t, pivot);
    memset(still.t, 0, sizeof still.t);
    sheen_Rt_compose(&out->Rt_board_obj, &turn, &still);
    sheen_Rt_direction(arm, &turn, arm);
    const double grow = exp(fmin(1, fmax(-1, step[6])));
    out->scale = at->scale * grow;
    for (int k = 0; k < 3; k++)
        out->Rt_board_obj.t[k] = pivot[k] + grow * arm[k] + step[3 + k];
}

static bool damped(double step[N], const equations *eq, double lambda, bool free_scale)
{
    double A[N * N];
    memcpy(A, eq->H, sizeof A);
    memcpy(step, eq->b, N * sizeof *step);
    for (int u = 0; u < N; u++)
        A[N * u + u] *= 1 + lambda;
    if (!free_scale)
        A[N * N - 1] = 1;
    if (!sheen_cholesky(A, N))
        return false;
    sheen_cholesky_solve(step, A, N);
    return true;
}

// From one start to its minimum; false where it leads nowhere.
static bool descend(sheen_placement *at, equations *eq, const problem *p)
{
    double lambda = 1e-2, step[N];
    if (!evaluate(eq, p, at))
        return false;
    for (int i = 0; i < MAX_STEPS && lambda < 1e8; i++) {
        sheen_placement trial;
        equations next;
        if (!damped(step, eq, lambda, p->free_scale)) {
            lambda *= 10;
            continue;
        }
        move(&trial, at, step, eq->pivot);
        if (!evaluate(&next, p, &trial) || !(next.cost < eq->cost)) {
            lambda *= 10;
            continue;
        }
        const double gain = eq->cost - next.cost;
        *at = trial;
        *eq = next;
        lambda *= 0.1;
        if (gain < 1e-10 * next.cost + 1e-14)
            break;
    }
    return true;
}

static sheen_status prepare(problem *p, const sheen_register_point *points, size_t n,
                            const sheen_camera *camera, const sheen_poses *poses, sheen_err *err)
{
    double A[9] = {0}, b[3] = {0};
    p->camera = camera;
    for (size_t i = 0; i < n; i++) {
        const sheen_frame_pose *pose = sheen_poses_find(poses, points[i].frame);
        if (!pose || !pose->found)
            continue;
        mark *m = &p->marks[p->n++];
        sheen_Rt inverse;
        double v[3];
        m->index = i;
        memcpy(m->q_px, points[i].q_px, sizeof m->q_px);
        memcpy(m->p_obj, points[i].p_obj, sizeof m->p_obj);
        sheen_Rt_from_rt(&m->Rt_cam_board, pose->rt_cam_board);
        sheen_Rt_invert(&inverse, &m->Rt_cam_board);
        const sheen_status s = sheen_camera_unproject(camera, v, m->q_px, 1, err);
        if (s)
            return s;
        if (!isfinite(v[0] + v[1] + v[2]))
            return sheen_fail(err, SHEEN_EDATA, "mark %zu lies where the camera sees nothing", i + 1);
        sheen_Rt_direction(v, &inverse, v);
        for (int u = 0; u < 3; u++) {
            p->centre_obj[u] += m->p_obj[u];
            for (int w = 0; w < 3; w++) {
                const double across = (u == w) - v[u] * v[w];
                A[3 * u + w] += across;
                b[u] += across * inverse.t[w];
            }
        }
    }
    if (p->n < SHEEN_REGISTER_MIN_POINTS)
        return sheen_fail(err, SHEEN_EDATA,
                          "%zu marks lie in frames that have a pose, at least %d are needed", p->n,
                          (int)SHEEN_REGISTER_MIN_POINTS);
    for (int u = 0; u < 3; u++) {
        p->centre_obj[u] /= (double)p->n;
        A[3 * u + u] += 1e-6; // parallel lines of sight: near the board's centre
    }
    if (!sheen_cholesky(A, 3))
        return sheen_fail(err, SHEEN_EDATA, "the marks' lines of sight do not meet");
    sheen_cholesky_solve(b, A, 3);
    memcpy(p->centre_board, b, sizeof b);
    return SHEEN_OK;
}

// A scale at which the marks spread in the pictures as they do: root mean squares about the means, frame by frame
// being too much ado for a start.
static double first_scale(problem *p)
{
    double spread_px = 0, spread_obj = 0, per_m = 0;
    for (size_t i = 0; i < p->n; i++) {
        double d[3], p_cam[3], q[2], dq[6];
        sheen_sub(d, p->marks[i].p_obj, p->centre_obj);
        spread_obj += sheen_dot(d, d);
        sheen_Rt_point(p_cam, &p->marks[i].Rt_cam_board, p->centre_board);
        if (sheen_camera_project(p->camera, q, dq, p_cam, 1, NULL) || !isfinite(q[0] + dq[0] + dq[4]))
            continue;
        spread_px += pow(p->marks[i].q_px[0] - q[0], 2) + pow(p->marks[i].q_px[1] - q[1], 2);
        per_m += fabs(dq[0]) / (double)p->n;
    }
    return sqrt(1.5 * spread_px / fmax(spread_obj, 1e-30)) / fmax(per_m, 1e-9);
}

static void start(sheen_placement *at, const problem *p, int i, double scale)
{
    static const double ups[N_UPS][3] = {{0, 0, 0}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {2, 0, 0}};
    const double *up = ups[i / N_TURNS];
    double arm[3], scaled[3], rt[6];
    sheen_rt_compose(rt, (const double[6]){0, 0, 2 * PI * (i % N_TURNS) / N_TURNS, 0, 0, 0},
                     (const double[6]){up[0] * PI / 2, up[1] * PI / 2, up[2] * PI / 2, 0, 0, 0});
    sheen_Rt_from_rt(&at->Rt_board_obj, rt);
    at->scale = scale;
    for (int k = 0; k < 3; k++)
        scaled[k] = scale * p->centre_obj[k];
    sheen_Rt_direction(arm, &at->Rt_board_obj, scaled);
    sheen_sub(at->Rt_board_obj.t, p->centre_board, arm);
}

static sheen_status judge(sheen_register_points_fit *out, const equations *eq, const problem *p,
                          sheen_err *err)
{
    double A[N * N], C[N * N];
    out->n = p->n;
    out->rms_px = sqrt(eq->cost / (2 * (double)p->n));
    out->worst_px = eq->worst_px;
    out->i_worst = eq->i_worst;
    memcpy(A, eq->H, sizeof A);
    if (!p->free_scale)
        A[N * N - 1] = 1;
    if (!sheen_cholesky(A, N))
        return sheen_fail(err, SHEEN_EDATA,
                          "the marks do not determine where the object stands: spread them out");
    sheen_cholesky_invert(C, A, N);
    const double sigma_px = fmax(out->rms_px, MIN_SIGMA_PX);
    for (int k = 0; k < 3; k++) {
        out->sigma_rad = fmax(out->sigma_rad, sigma_px * sqrt(C[(N + 1) * k]));
        out->sigma_m = fmax(out->sigma_m, sigma_px * sqrt(C[(N + 1) * (3 + k)]));
    }
    if (!(out->sigma_rad < MAX_SIGMA_RAD))
        return sheen_fail(err, SHEEN_EDATA,
                          "the marks determine the object's turn to %.0f degrees only: spread them "
                          "out",
                          out->sigma_rad * 180 / PI);
    return SHEEN_OK;
}

sheen_status sheen_register_points_solve(sheen_register_points_fit *out, const sheen_register_point *points,
                                         size_t n_points, const sheen_camera *camera,
                                         const sheen_poses *poses, double unit_m, sheen_err *err)
{
    problem p = {.marks = calloc(n_points + 1, sizeof *p.marks), .free_scale = !(unit_m > 0)};
    equations best = {.cost = INFINITY};
    *out = (sheen_register_points_fit){0};
    if (!p.marks)
        return sheen_fail_memory(err, (double)n_points * sizeof *p.marks, "marks");
    sheen_status s = prepare(&p, points, n_points, camera, poses, err);
    const double scale = s ? 1 : unit_m > 0 ? unit_m : first_scale(&p);
    for (int i = 0; i < N_UPS * N_TURNS && !s; i++) {
        sheen_placement at;
        equations eq;
        start(&at, &p, i, scale);
        if (descend(&at, &eq, &p) && eq.cost < best.cost) {
            best = eq;
            out->placement = at;
        }
    }
    if (!s && !isfinite(best.cost))
        s = sheen_fail(err, SHEEN_EDATA,
                       "the marks lead nowhere: do they belong to this mesh and these frames");
    if (!s)
        s = judge(out, &best, &p, err);
    free(p.marks);
    return s;
}

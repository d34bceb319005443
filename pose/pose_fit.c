// SPDX-License-Identifier: Apache-2.0
// pose_fit.c - one pose by Levenberg-Marquardt with the lens model's own gradients.
//
// The pose is moved on the left, p_cam' = exp(w) R p + t + d, so that the six unknowns (w, d) have no singular
// place: dp_cam/d(w, d) = [-[R p]x  I].
#include "pose/pose_fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "base/vec.h"
#include "calib/cholesky.h"
#include "calib/homography.h"

enum { MAX_STEPS = 50, DOUBLES_PER_POINT = 3 + 2 + 3 + 2 + 6 + 3 };

sheen_status sheen_pose_points_init(sheen_pose_points *points, size_t n, sheen_err *err)
{
    *points = (sheen_pose_points){.n = n};
    double *block = calloc(n ? n : 1, DOUBLES_PER_POINT * sizeof *block);
    points->use = calloc(n ? n : 1, sizeof *points->use);
    points->p_board = block;
    if (!block || !points->use) {
        sheen_pose_points_release(points);
        return sheen_fail_memory(err, (double)n * DOUBLES_PER_POINT * sizeof *block, "a pose");
    }
    points->q_px = block + 3 * n;
    points->p_cam = block + 5 * n;
    points->fit_px = block + 8 * n;
    points->J = block + 10 * n;
    points->whiten = block + 16 * n;
    for (size_t i = 0; i < n; i++)
        points->whiten[3 * i] = points->whiten[3 * i + 2] = 1;
    return SHEEN_OK;
}

void sheen_pose_points_weigh(sheen_pose_points *points, const double (*covariance)[3])
{
    double information = 0; // mean of the points' in one direction
    for (size_t i = 0; i < points->n; i++) {
        const double *c = covariance[i], det = c[0] * c[2] - c[1] * c[1];
        if (!(c[0] > 0 && c[2] > 0 && det > 1e-9 * c[0] * c[2]))
            return;
        information += (c[0] + c[2]) / (2 * det * (double)points->n);
    }
    for (size_t i = 0; i < points->n; i++) { // U with U'U = covariance^-1 / information
        const double *c = covariance[i], det = c[0] * c[2] - c[1] * c[1];
        double *u = points->whiten + 3 * i;
        u[0] = sqrt(c[2] / det / information);
        u[1] = -c[1] / det / information / u[0];
        u[2] = sqrt(1 / c[2] / information);
    }
}

// A point's residual, whitened.
static void residual(double e[2], const sheen_pose_points *points, size_t i)
{
    const double *u = points->whiten + 3 * i;
    const double dx = points->q_px[2 * i] - points->fit_px[2 * i];
    const double dy = points->q_px[2 * i + 1] - points->fit_px[2 * i + 1];
    e[0] = u[0] * dx + u[1] * dy;
    e[1] = u[2] * dy;
}

void sheen_pose_points_release(sheen_pose_points *points)
{
    free(points->p_board); // the one block
    free(points->use);
    *points = (sheen_pose_points){0};
}

sheen_status sheen_pose_seed(double rt_cam_board[6], const sheen_camera *camera, sheen_pose_points *points,
                             sheen_err *err)
{
    double *v_cam = points->p_cam, *xy = points->J, *q = points->J + 2 * points->n; // scratch
    const sheen_status s = sheen_camera_unproject(camera, v_cam, points->q_px, points->n, err);
    if (s)
        return s;
    size_t n = 0, first = 0;
    for (size_t i = 0; i < points->n; i++) {
        if (!points->use[i] || !(v_cam[3 * i + 2] > 1e-3))
            continue;
        first = n ? first : i;
        memcpy(xy + 2 * n, points->p_board + 3 * i, 2 * sizeof *xy);
        q[2 * n] = v_cam[3 * i] / v_cam[3 * i + 2];
        q[2 * n + 1] = v_cam[3 * i + 1] / v_cam[3 * i + 2];
        n++;
    }
    double H[9];
    sheen_Rt Rt;
    if (!sheen_homography_fit(H, xy, q, n) || !sheen_homography_pose(&Rt, H, points->p_board + 3 * first))
        return sheen_fail(err, SHEEN_EDATA, "the points in view do not determine a pose");
    sheen_rt_from_Rt(rt_cam_board, &Rt);
    return SHEEN_OK;
}

// Projects all points and returns the sum of squared residuals of those in use; infinite where one of them lies
// behind the camera.
static sheen_status project(double *cost, const sheen_Rt *Rt, const sheen_camera *camera,
                            sheen_pose_points *points, sheen_err *err)
{
    for (size_t i = 0; i < points->n; i++)
        sheen_Rt_point(points->p_cam + 3 * i, Rt, points->p_board + 3 * i);
    const sheen_status s = sheen_camera_project(camera, points->fit_px, points->J, points->p_cam, points->n,
                                                err);
    *cost = 0;
    for (size_t i = 0; i < points->n && !s; i++)
        if (points->use[i]) {
            double e[2];
            residual(e, points, i);
            *cost += e[0] * e[0] + e[1] * e[1];
        }
    if (!isfinite(*cost))
        *cost = INFINITY;
    return s;
}

// A = J'J (lower triangle) and b = J'r over the points in use, as last projected.
static void normal_equations(double A[36], double b[6], const sheen_Rt *Rt, const sheen_pose_points *points)
{
    memset(A, 0, 36 * sizeof *A);
    memset(b, 0, 6 * sizeof *b);
    for (size_t i = 0; i < points->n; i++) {
        if (!points->use[i])
            continue;
        double r[3], residuals[2];
        const double *whiten = points->whiten + 3 * i, *by_p = points->J + 6 * i;
        sheen_sub(r, points->p_cam + 3 * i, Rt->t);
        residual(residuals, points, i);
        for (size_t k = 0; k < 2; k++) {
            double J[6], *g = J + 3; // of the whitened residual
            for (int c = 0; c < 3; c++)
                g[c] = k ? whiten[2] * by_p[3 + c] : whiten[0] * by_p[c] + whiten[1] * by_p[3 + c];
            sheen_cross(J, r, g); // g . (w x r) = w . (r x g)
            const double e = residuals[k];
            for (int u = 0; u < 6; u++) {
                for (int v = 0; v <= u; v++)
                    A[6 * u + v] += J[u] * J[v];
                b[u] += J[u] * e;
            }
        }
    }
}

static void move(sheen_Rt *out, const sheen_Rt *Rt, const double step[6])
{
    sheen_Rt turn;
    sheen_Rt_from_rt(&turn, (const double[6]){step[0], step[1], step[2], 0, 0, 0});
    sheen_Rt still = *Rt;
    memset(still.t, 0, sizeof still.t);
    sheen_Rt_compose(out, &turn, &still);
    for (int i = 0; i < 3; i++)
        out->t[i] = Rt->t[i] + step[3 + i];
}

// (A + lambda diag A) step = b. False where even that is singular.
static bool damped_step(double step[6], const double A[36], const double b[6], double lambda)
{
    double M[36];
    memcpy(M, A, sizeof M);
    memcpy(step, b, 6 * sizeof *step);
    for (size_t i = 0; i < 6; i++)
        M[7 * i] *= 1 + lambda;
    if (!sheen_cholesky(M, 6))
        return false;
    sheen_cholesky_solve(step, M, 6);
    return true;
}

static size_t count_used(const sheen_pose_points *points)
{
    size_t n = 0;
    for (size_t i = 0; i < points->n; i++)
        n += points->use[i];
    return n;
}

sheen_status sheen_pose_refine(double rt_cam_board[6], double *rms_px, const sheen_camera *camera,
                               sheen_pose_points *points, sheen_err *err)
{
    sheen_Rt Rt, trial;
    double cost, trial_cost, A[36], b[6], step[6], lambda = 1e-4;
    const size_t n_used = count_used(points);
    sheen_Rt_from_rt(&Rt, rt_cam_board);
    sheen_status s = project(&cost, &Rt, camera, points, err);
    if (!s && (!isfinite(cost) || n_used < 3))
        s = sheen_fail(err, SHEEN_EDATA, "the points in view do not determine a pose");
    if (s)
        return s;
    normal_equations(A, b, &Rt, points);
    for (int i = 0; i < MAX_STEPS && lambda < 1e10; i++) {
        if (!damped_step(step, A, b, lambda)) {
            lambda = fmax(lambda, 1e-8) * 10;
            continue;
        }
        move(&trial, &Rt, step);
        s = project(&trial_cost, &trial, camera, points, err);
        if (s)
            return s;
        if (!(trial_cost < cost)) {
            // at the optimum rounding alone decides: a step this small cannot gain anything
            if (sheen_norm(step) + sheen_norm(step + 3) / fmax(1e-3, sheen_norm(Rt.t)) < 1e-9)
                break;
            lambda *= 10;
            continue;
        }
        const double gain = cost - trial_cost;
        Rt = trial;
        cost = trial_cost;
        lambda *= 0.1;
        if (gain < 1e-12 * cost)
            break;
        normal_equations(A, b, &Rt, points);
    }
    sheen_rt_from_Rt(rt_cam_board, &Rt);
    *rms_px = sqrt(cost / (2 * (double)n_used));
    return SHEEN_OK;
}

sheen_status sheen_pose_errors(double *error_px, const double rt_cam_board[6], const sheen_camera *camera,
                               sheen_pose_points *points, sheen_err *err)
{
    sheen_Rt Rt;
    double cost;
    sheen_Rt_from_rt(&Rt, rt_cam_board);
    const sheen_status s = project(&cost, &Rt, camera, points, err);
    for (size_t i = 0; i < points->n && !s; i++) {
        double e[2];
        residual(e, points, i);
        error_px[i] = hypot(e[0], e[1]);
    }
    return s;
}

sheen_status sheen_pose_covariance(double covariance[36], const double rt_cam_board[6], double sigma_px,
                                   const sheen_camera *camera, sheen_pose_points *points, sheen_err *err)
{
    sheen_Rt Rt;
    double cost, A[36], b[6], L[3][3], full[36];
    sheen_Rt_from_rt(&Rt, rt_cam_board);
    const sheen_status s = project(&cost, &Rt, camera, points, err);
    if (s)
        return s;
    normal_equations(A, b, &Rt, points);
    // J'J in (r, t): T' A T with T = diag(L, I)
    sheen_r_left_jacobian(L, rt_cam_board);
    double T[6][6] = {{0}};
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            T[i][j] = L[i][j];
        T[3 + i][3 + i] = 1;
    }
    for (int u = 0; u < 6; u++)
        for (int v = 0; v < 6; v++) {
            double sum = 0;
            for (int i = 0; i < 6; i++)
                for (int j = 0; j < 6; j++)
                    sum += T[i][u] * A[i >= j ? 6 * i + j : 6 * j + i] * T[j][v];
            full[6 * u + v] = sum / (sigma_px * sigma_px);
        }
    if (!isfinite(cost) || !sheen_cholesky(full, 6))
        return sheen_fail(err, SHEEN_EDATA, "the points in view do not determine a pose");
    sheen_cholesky_invert(covariance, full, 6);
    return SHEEN_OK;
}

// SPDX-License-Identifier: Apache-2.0
// calibrate_mrcal.c - mrcal's optimiser, and the uncertainty of its result through CHOLMOD: the second of the two
// files that include mrcal, and the one that includes CHOLMOD.
//
// mrcal and CHOLMOD print to the error stream with no switch; sheen_quiet_* catches that for the length of each
// call. mrcal's own rms divides by missing corners too, so it is not used; nor is its outlier rejection
// (calibrate_outliers.c).
//
// Uncertainty: with the packed parameters b of the optimum, Var b = sigma^2 (J'J)^-1. A point p fixed in the
// camera is fixed in each board's frame; when b moves, each frame's board carries the point to a new place in
// the camera, and the mean over the frames is projected with the new lens ("mean of frames", mrcal's own
// method): dq/db = [dq/dlens, dq/dp 1/N d(R_i p_i + t_i)/d(r_i, t_i)], Var q = dq/db Var b dq/db'.
#include "calib/calibrate_problem.h"

#include <math.h>
#include <mrcal/mrcal.h>
#include <stdlib.h>
#include <string.h>
#include <suitesparse/cholmod.h>

#include "base/pose3.h"
#include "base/quiet.h"

_Static_assert(sizeof(mrcal_point3_t) == 3 * sizeof(double), "arrays of points are arrays of numbers");
_Static_assert(sizeof(mrcal_pose_t) == 6 * sizeof(double), "arrays of poses are arrays of numbers");

// All that mrcal wants to know beside the numbers of sheen_problem.
typedef struct layout {
    mrcal_lensmodel_t lens;
    mrcal_problem_selections_t selections;
    mrcal_problem_constants_t constants;
    mrcal_observation_board_t *boards;
    mrcal_calobject_warp_t warp;
    int n_states, n_measurements, image_size_px[2];
} layout;

// A splined model's knots can do all that its core does, so that the two are not solved for together.
static mrcal_problem_selections_t selections_of(sheen_problem_stage stage, const mrcal_lensmodel_t *lens)
{
    mrcal_problem_selections_t s = {.do_optimize_frames = true};
    s.do_optimize_intrinsics_core = stage != SHEEN_PROBLEM_POSES &&
                                    lens->type != MRCAL_LENSMODEL_SPLINED_STEREOGRAPHIC;
    if (stage == SHEEN_PROBLEM_EVERYTHING) {
        s.do_optimize_intrinsics_distortions = true;
        s.do_optimize_calobject_warp = true;
        s.do_apply_regularization = true;
    }
    return s;
}

static sheen_status layout_init(layout *l, const sheen_problem *p, sheen_problem_stage stage, sheen_err *err)
{
    *l = (layout){.constants = {.point_min_range = 1e-3, .point_max_range = 1e3},
                  .warp = {.values = {p->warp_m[0], p->warp_m[1]}},
                  .image_size_px = {p->camera.width_px, p->camera.height_px}};
    if (!mrcal_lensmodel_from_name(&l->lens, p->camera.lensmodel))
        return sheen_fail(err, SHEEN_EARG, "unknown lens model '%.80s'", p->camera.lensmodel);
    l->selections = selections_of(stage, &l->lens);
    l->boards = calloc((size_t)p->n_frames, sizeof *l->boards);
    if (!l->boards)
        return sheen_fail_memory(err, (double)p->n_frames * sizeof *l->boards, "a calibration");
    for (int i = 0; i < p->n_frames; i++)
        l->boards[i] = (mrcal_observation_board_t){.icam = {.intrinsics = 0, .extrinsics = -1}, .iframe = i};
    l->n_states = mrcal_num_states(1, 0, p->n_frames, 0, 0, p->n_frames, l->selections, &l->lens);
    l->n_measurements = mrcal_num_measurements(p->n_frames, 0, p->n_cols, p->n_rows, 1, 0, p->n_frames, 0, 0,
                                               l->selections, &l->lens);
    return SHEEN_OK;
}

// mrcal takes and gives arrays of its own types, which hold nothing but their numbers.
static mrcal_pose_t *poses_of(const sheen_problem *p)
{
    return (mrcal_pose_t *)(void *)p->rt_cam_grid;
}

static mrcal_point3_t *points_of(const sheen_problem *p)
{
    return (mrcal_point3_t *)(void *)p->observations;
}

sheen_status sheen_problem_solve(sheen_problem *p, sheen_problem_stage stage, sheen_err *err)
{
    layout l;
    sheen_status s = layout_init(&l, p, stage, err);
    if (s)
        return s;
    double *x = malloc((size_t)l.n_measurements * sizeof *x);
    if (!x) {
        s = sheen_fail_memory(err, (double)l.n_measurements * sizeof *x, "a calibration");
        goto done;
    }
    const int token = sheen_quiet_begin();
    const mrcal_stats_t stats = mrcal_optimize(
        NULL, 0, x, (int)((size_t)l.n_measurements * sizeof *x), p->camera.intrinsics, NULL, poses_of(p),
        NULL, &l.warp, 1, 0, p->n_frames, 0, 0, l.boards, NULL, p->n_frames, 0, points_of(p), &l.lens,
        l.image_size_px, l.selections, &l.constants, p->spacing_m, p->n_cols, p->n_rows, false, false);
    sheen_quiet_end(token);
    bool finite = isfinite(stats.rms_reproj_error__pixels) && stats.rms_reproj_error__pixels >= 0;
    for (int i = 0; i < p->camera.n_intrinsics; i++)
        finite = finite && isfinite(p->camera.intrinsics[i]);
    for (int i = 0; i < 6 * p->n_frames; i++)
        finite = finite && isfinite(p->rt_cam_grid[i]);
    if (!finite) {
        s = sheen_fail(err, SHEEN_EDATA,
                       "the calibration did not converge: take frames that show the whole board, "
                       "sharp, at different tilts");
        goto done;
    }
    memcpy(p->warp_m, l.warp.values, sizeof p->warp_m);
    memcpy(p->residuals_px, x, 2 * sheen_problem_corners(p) * sizeof *x);

done:
    free(x);
    free(l.boards);
    return s;
}

// The Jacobian, transposed, in packed (unitless) parameters, at the solution.
static sheen_status jacobian(cholmod_sparse **Jt_out, layout *l, const sheen_problem *p,
                             cholmod_common *common, sheen_err *err)
{
    // every corner has 2 rows; each touches the lens, its frame, and the warp; regularisation rows are short
    const size_t per_row = (size_t)p->camera.n_intrinsics + 6 + 2;
    const size_t n_nonzero = per_row * (size_t)l->n_measurements;
    double *b = malloc((size_t)l->n_states * sizeof *b);
    double *x = malloc((size_t)l->n_measurements * sizeof *x);
    cholmod_sparse *Jt = cholmod_allocate_sparse((size_t)l->n_states, (size_t)l->n_measurements, n_nonzero, 1,
                                                 1, 0, CHOLMOD_REAL, common);
    sheen_status s = SHEEN_OK;
    if (!b || !x || !Jt)
        s = sheen_fail_memory(err, (double)n_nonzero * 12, "the uncertainty of a calibration");
    else if (!mrcal_optimizer_callback(
                 b, (int)((size_t)l->n_states * sizeof *b), x, (int)((size_t)l->n_measurements * sizeof *x),
                 Jt, p->camera.intrinsics, NULL, poses_of(p), NULL, &l->warp, 1, 0, p->n_frames, 0, 0,
                 l->boards, NULL, p->n_frames, 0, points_of(p), &l->lens, l->image_size_px, l->selections,
                 &l->constants, p->spacing_m, p->n_cols, p->n_rows, false))
        s = sheen_fail(err, SHEEN_EDATA, "the derivatives of the calibration could not be had");
    free(b);
    free(x);
    if (s)
        cholmod_free_sparse(&Jt, common);
    *Jt_out = Jt;
    return s;
}

// How many of the lens parameters come before the first that is solved for.
static size_t held_core(const layout *l)
{
    return l->selections.do_optimize_intrinsics_core ? 0 : 4;
}

// Both rows of dq/db (unpacked parameters, zero elsewhere) for the point at distance_m through q_px.
static bool projection_gradient(double *dq_db, const layout *l, const sheen_problem *p, const double q_px[2],
                                double distance_m)
{
    const size_t n_states = (size_t)l->n_states, n_lens = (size_t)p->camera.n_intrinsics;
    mrcal_point3_t v;
    const mrcal_point2_t q_in = {.x = q_px[0], .y = q_px[1]};
    mrcal_point2_t q;
    mrcal_point3_t dq_dp[2];
    double *dq_dlens = calloc(2 * n_lens, sizeof *dq_dlens);
    memset(dq_db, 0, 2 * n_states * sizeof *dq_db);
    bool ok = dq_dlens && mrcal_unproject(&v, &q_in, 1, &l->lens, p->camera.intrinsics);
    const double length = ok ? sqrt(v.x * v.x + v.y * v.y + v.z * v.z) : 0;
    ok = ok && length > 0 && isfinite(length);
    if (ok) {
        const double k = distance_m / length;
        v = (mrcal_point3_t){.x = k * v.x, .y = k * v.y, .z = k * v.z};
        ok = mrcal_project(&q, dq_dp, dq_dlens, &v, 1, &l->lens, p->camera.intrinsics);
    }
    const int at_lens = mrcal_state_index_intrinsics(0, 1, 0, p->n_frames, 0, 0, p->n_frames, l->selections,
                                                     &l->lens);
    const size_t held = held_core(l);
    for (size_t k = 0; ok && k < 2; k++)
        memcpy(dq_db + k * n_states + (size_t)at_lens, dq_dlens + k * n_lens + held,
               (n_lens - held) * sizeof *dq_db);
    for (int i = 0; ok && i < p->n_frames; i++) {
        const double *rt = p->rt_cam_grid + 6 * (size_t)i;
        sheen_Rt Rt;
        double p_grid[3], p_cam[3], dp[3][6];
        sheen_Rt_from_rt(&Rt, rt);
        sheen_Rt_invert(&Rt, &Rt);
        sheen_Rt_point(p_grid, &Rt, (const double[3]){v.x, v.y, v.z});
        mrcal_transform_point_rt(p_cam, dp[0], NULL, rt, p_grid);
        const int at = mrcal_state_index_frames(i, 1, 0, p->n_frames, 0, 0, p->n_frames, l->selections,
                                                &l->lens);
        for (size_t k = 0; k < 2; k++)
            for (size_t j = 0; j < 6; j++)
                dq_db[k * n_states + (size_t)at + j] =
                    (dq_dp[k].x * dp[0][j] + dq_dp[k].y * dp[1][j] + dq_dp[k].z * dp[2][j]) / p->n_frames;
    }
    free(dq_dlens);
    return ok;
}

// sigma of one point: sqrt of the larger eigenvalue of dq/db (J'J)^-1 dq/db'.
static double sigma_at(const layout *l, const sheen_problem *p, const double q_px[2], double distance_m,
                       cholmod_factor *factor, cholmod_common *common)
{
    const size_t n = (size_t)l->n_states;
    cholmod_dense *rhs = cholmod_allocate_dense(n, 2, n, CHOLMOD_REAL, common), *solved = NULL;
    double result = NAN;
    if (rhs && projection_gradient(rhs->x, l, p, q_px, distance_m)) {
        double *g = rhs->x;
        // the factor is that of packed parameters b_packed = b / scale, so dq/db_packed = dq/db scale: what
        // unpacks a state is what packs its gradient
        for (size_t k = 0; k < 2; k++)
            mrcal_unpack_solver_state_vector(g + k * n, 1, 0, p->n_frames, 0, 0, l->selections, &l->lens);
        solved = cholmod_solve(CHOLMOD_A, factor, rhs, common);
        double var[3] = {0};
        for (size_t i = 0; solved && i < n; i++) {
            const double *y = solved->x;
            var[0] += g[i] * y[i];
            var[1] += g[i] * y[n + i];
            var[2] += g[n + i] * y[n + i];
        }
        if (solved)
            result = sqrt((var[0] + var[2]) / 2 + hypot((var[0] - var[2]) / 2, var[1]));
    }
    cholmod_free_dense(&rhs, common);
    cholmod_free_dense(&solved, common);
    return result;
}

// The normal equations of a solved problem, factorised.
typedef struct normal {
    layout l;
    cholmod_common common;
    cholmod_factor *factor;
    int token; // chatter is caught from open to close
} normal;

static void normal_close(normal *n)
{
    cholmod_free_factor(&n->factor, &n->common);
    cholmod_finish(&n->common);
    sheen_quiet_end(n->token);
    free(n->l.boards);
}

static sheen_status normal_open(normal *n, const sheen_problem *p, sheen_err *err)
{
    *n = (normal){0};
    sheen_status s = layout_init(&n->l, p, SHEEN_PROBLEM_EVERYTHING, err);
    if (s)
        return s;
    cholmod_sparse *Jt = NULL;
    n->token = sheen_quiet_begin();
    cholmod_start(&n->common);
    n->common.print = 0;
    s = jacobian(&Jt, &n->l, p, &n->common, err);
    if (!s) {
        n->factor = cholmod_analyze(Jt, &n->common);
        if (!n->factor || !cholmod_factorize(Jt, n->factor, &n->common) || n->common.status != CHOLMOD_OK ||
            n->factor->minor < n->factor->n)
            s = sheen_fail(err, SHEEN_EDATA, "the frames do not determine the lens");
    }
    cholmod_free_sparse(&Jt, &n->common);
    if (s)
        normal_close(n);
    return s;
}

static void unpack(const layout *l, const sheen_problem *p, double *state)
{
    mrcal_unpack_solver_state_vector(state, 1, 0, p->n_frames, 0, 0, l->selections, &l->lens);
}

static sheen_status lens_covariance(double *covariance, normal *equations, const sheen_problem *p,
                                    double sigma_px, sheen_err *err)
{
    sheen_status s = SHEEN_OK;
    const layout *l = &equations->l;
    const size_t n = (size_t)l->n_states, n_lens = (size_t)p->camera.n_intrinsics, held = held_core(l);
    const size_t at = (size_t)mrcal_state_index_intrinsics(0, 1, 0, p->n_frames, 0, 0, p->n_frames,
                                                           l->selections, &l->lens);
    memset(covariance, 0, n_lens * n_lens * sizeof *covariance);
    for (size_t i = held; i < n_lens && !s; i++) {
        cholmod_dense *unit = cholmod_zeros(n, 1, CHOLMOD_REAL, &equations->common), *column = NULL;
        if (unit) {
            double *b = unit->x;
            b[at + i - held] = 1;
            unpack(l, p, b); // both sides of the packed inverse are scaled
            column = cholmod_solve(CHOLMOD_A, equations->factor, unit, &equations->common);
        }
        if (column) {
            double *b = column->x;
            unpack(l, p, b);
            for (size_t k = held; k < n_lens; k++)
                covariance[i * n_lens + k] = sigma_px * sigma_px * b[at + k - held];
        } else
            s = sheen_fail_memory(err, (double)n * sizeof(double), "the uncertainty of a calibration");
        cholmod_free_dense(&unit, &equations->common);
        cholmod_free_dense(&column, &equations->common);
    }
    return s;
}

sheen_status sheen_problem_uncertainty(const sheen_uncertainty *out, const sheen_problem *p, double sigma_px,
                                       sheen_err *err)
{
    normal equations;
    sheen_status s = normal_open(&equations, p, err);
    if (s)
        return s;
    for (size_t i = 0; i < out->n; i++)
        out->sigma_px[i] = sigma_px * sigma_at(&equations.l, p, out->q_px + 2 * i, out->distance_m,
                                               equations.factor, &equations.common);
    if (out->lens_covariance)
        s = lens_covariance(out->lens_covariance, &equations, p, sigma_px, err);
    normal_close(&equations);
    return s;
}

sheen_status sheen_lens_gradient(double *dq_dlens, const sheen_camera *camera, const double p_cam[3],
                                 sheen_err *err)
{
    mrcal_lensmodel_t lens;
    mrcal_point2_t q;
    const mrcal_point3_t p = {.x = p_cam[0], .y = p_cam[1], .z = p_cam[2]};
    if (!mrcal_lensmodel_from_name(&lens, camera->lensmodel) ||
        !mrcal_project(&q, NULL, dq_dlens, &p, 1, &lens, camera->intrinsics))
        return sheen_fail(err, SHEEN_EARG, "the lens model '%.80s' could not project", camera->lensmodel);
    return SHEEN_OK;
}

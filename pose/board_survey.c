// SPDX-License-Identifier: Apache-2.0
// board_survey.c - the survey: single poses, boards tied together through frames that see two, then Gauss-Newton on
// all points, frames eliminated (Schur's complement), and groups of points that stand elsewhere left out.
#include "pose/board_survey.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/order.h"
#include "base/pose3.h"
#include "base/vec.h"
#include "calib/cholesky.h"
#include "pose/board_pose.h"
#include "pose/board_survey_private.h"
#include "pose/pose_tangent.h"

enum { MAX_STEPS = 12, ROUNDS = 10 };

static const double REJECT_MEDIANS = 4;
static const double REJECT_FLOOR_PX = 0.12;
static const double MOVED_PX = 0.3;    // median misfit of a whole board in a frame: it stands elsewhere
static const double MOVED_MEDIANS = 4; // and this many times what it is by a pose of its own
static const double MOVED_TOGETHER =
    0.75;                            // of the worst: where a board moved, its right places are misfits, too
static const double AGREE_M = 0.003; // two ties of a board agree within this
static const double AGREE_RAD = 0.02;

static void release(sheen_survey_problem *p)
{
    for (size_t i = 0; p->groups && i < p->n_frames * p->n_boards; i++) {
        free(p->groups[i].use);
        free(p->groups[i].error_px);
    }
    free(p->groups);
    free(p->Rt_cam_ref);
    free(p->framed);
    free(p->Rt_ref_board);
    free(p->tied);
    free(p->S);
    free(p->V);
}

static sheen_status allocate(sheen_survey_problem *p, sheen_err *err)
{
    const size_t f = p->n_frames, b = p->n_boards, n = 6 * b;
    p->groups = calloc(f * b + 1, sizeof *p->groups);
    p->Rt_cam_ref = calloc(f + 1, sizeof *p->Rt_cam_ref);
    p->framed = calloc(f + 1, sizeof *p->framed);
    p->Rt_ref_board = calloc(b + 1, sizeof *p->Rt_ref_board);
    p->tied = calloc(b + 1, sizeof *p->tied);
    p->S = calloc(n * n + n, sizeof *p->S);
    p->V = calloc(f * (36 + 6 * n + 6) + 1, sizeof *p->V);
    if (!p->groups || !p->Rt_cam_ref || !p->framed || !p->Rt_ref_board || !p->tied || !p->S || !p->V)
        return sheen_fail_memory(err, 8.0 * (double)f * (48 + 6 * (double)n), "a survey of boards");
    p->rhs = p->S + n * n;
    p->W = p->V + 36 * f;
    p->g = p->W + 6 * n * f;
    return SHEEN_OK;
}

// Every board of every frame by itself.
static sheen_status pose_groups(sheen_survey_problem *p, const sheen_board_set *boards,
                                const sheen_board_view *views, sheen_survey *out, sheen_err *err)
{
    for (size_t f = 0; f < p->n_frames; f++)
        for (size_t b = 0; b < p->n_boards; b++) {
            sheen_survey_group *g = sheen_survey_at(p, f, b);
            sheen_board_pose pose;
            sheen_err why = {0};
            g->view = &views[f * p->n_boards + b];
            g->use = calloc(g->view->n_saddles + 1, sizeof *g->use);
            g->error_px = calloc(2 * g->view->n_saddles + 1, sizeof *g->error_px);
            if (!g->use || !g->error_px)
                return sheen_fail_memory(err, (double)g->view->n_saddles * 16, "a survey of boards");
            const sheen_status s = sheen_board_pose_find(&pose, g->use, p->camera, &boards->boards[b],
                                                         g->view, &why);
            if (s && s != SHEEN_EDATA)
                return sheen_fail(err, s, "%s", why.msg);
            g->posed = !s && !pose.from_tags;
            g->own_px = 1.1774 * pose.rms_px; // of errors that are normal in x and y
            if (g->posed)
                sheen_Rt_from_rt(&g->Rt_cam_board, pose.rt_cam_board);
            else if (!out->frames[f].reason[0] && g->view->n_tags)
                snprintf(out->frames[f].reason, sizeof out->frames[f].reason, "%.*s",
                         (int)sizeof out->frames[f].reason - 1, s ? why.msg : "too few corners");
        }
    return SHEEN_OK;
}

// Where board b is by frame f's two single poses.
static void tie(sheen_Rt *Rt_ref_b, const sheen_survey_problem *p, size_t f, size_t a, size_t b)
{
    sheen_Rt inverse, a_b;
    sheen_Rt_invert(&inverse, &sheen_survey_at(p, f, a)->Rt_cam_board);
    sheen_Rt_compose(&a_b, &inverse, &sheen_survey_at(p, f, b)->Rt_cam_board);
    sheen_Rt_compose(Rt_ref_b, &p->Rt_ref_board[a], &a_b);
}

static bool agree(const sheen_Rt *x, const sheen_Rt *y)
{
    double wd[6];
    sheen_pose_difference(wd, x, y);
    return sheen_norm(wd) < AGREE_RAD && sheen_norm(wd + 3) < AGREE_M;
}

// Ties board b to those that are tied, by the frame with which most others agree. Returns how many do.
static int tie_board(sheen_survey_problem *p, size_t b)
{
    int best = 0;
    sheen_Rt best_Rt = {.t = {0}};
    for (size_t f = 0; f < p->n_frames; f++)
        for (size_t a = 0; a < p->n_boards; a++) {
            if (!p->tied[a] || !sheen_survey_at(p, f, a)->posed || !sheen_survey_at(p, f, b)->posed)
                continue;
            sheen_Rt here, other;
            int votes = 0;
            tie(&here, p, f, a, b);
            for (size_t f2 = 0; f2 < p->n_frames; f2++)
                for (size_t a2 = 0; a2 < p->n_boards; a2++)
                    if (p->tied[a2] && sheen_survey_at(p, f2, a2)->posed &&
                        sheen_survey_at(p, f2, b)->posed) {
                        tie(&other, p, f2, a2, b);
                        votes += agree(&here, &other);
                    }
            if (votes > best) {
                best = votes;
                best_Rt = here;
            }
        }
    if (best)
        p->Rt_ref_board[b] = best_Rt;
    return best;
}

// The frame's pose by each of its boards: that with which most boards agree, and of equals the first board's, which is
// what stands still by definition; then that with most corners.
static void place_frame(sheen_survey_problem *p, size_t f)
{
    enum { BOARD = 1 << 20, FIRST = 1 << 19 }; // more than corners are
    int most = 0;
    for (size_t b = 0; b < p->n_boards; b++) {
        if (!p->tied[b] || !sheen_survey_at(p, f, b)->posed)
            continue;
        sheen_Rt inverse, here;
        int votes = 0;
        sheen_Rt_invert(&inverse, &p->Rt_ref_board[b]);
        sheen_Rt_compose(&here, &sheen_survey_at(p, f, b)->Rt_cam_board, &inverse);
        for (size_t b2 = 0; b2 < p->n_boards; b2++) {
            const sheen_survey_group *g = sheen_survey_at(p, f, b2);
            sheen_Rt by_other;
            if (!p->tied[b2] || !g->posed)
                continue;
            sheen_Rt_compose(&by_other, &here, &p->Rt_ref_board[b2]);
            if (agree(&by_other, &g->Rt_cam_board))
                votes += BOARD + (b2 ? 0 : FIRST) + (int)g->view->n_saddles;
        }
        if (votes > most) {
            most = votes;
            p->Rt_cam_ref[f] = here;
            p->framed[f] = true;
        }
    }
}

// Boards from the first outwards, those with most ties first; then the frames.
static void start(sheen_survey_problem *p)
{
    sheen_Rt_from_rt(&p->Rt_ref_board[0], (const double[6]){0});
    p->tied[0] = true;
    for (;;) {
        int most = 0;
        size_t next = 0;
        for (size_t b = 1; b < p->n_boards; b++) {
            const int votes = p->tied[b] ? 0 : tie_board(p, b);
            if (votes > most) {
                most = votes;
                next = b;
            }
        }
        if (!most)
            break;
        p->tied[next] = true;
    }
    for (size_t f = 0; f < p->n_frames; f++) {
        place_frame(p, f);
        for (size_t b = 0; b < p->n_boards; b++)
            sheen_survey_at(p, f, b)->counts = p->framed[f] && p->tied[b] && sheen_survey_at(p, f, b)->posed;
    }
}

// Adds J' J and J' e of one coordinate: 6 columns of the frame, 6 of the board.
static void add_row(sheen_survey_problem *p, size_t f, size_t b, const double Jf[6], const double Jb[6],
                    double e)
{
    const size_t n = 6 * p->n_boards;
    for (size_t u = 0; u < 6; u++) {
        p->g[6 * f + u] += Jf[u] * e;
        for (size_t v = 0; v < 6; v++)
            p->V[36 * f + 6 * u + v] += Jf[u] * Jf[v];
        if (!b)
            continue;
        p->rhs[6 * b + u] += Jb[u] * e;
        for (size_t v = 0; v < 6; v++) {
            p->S[(6 * b + u) * n + 6 * b + v] += Jb[u] * Jb[v];
            p->W[f * 6 * n + u * n + 6 * b + v] += Jf[u] * Jb[v];
        }
    }
}

// Errors of a group, and, where it counts, its share of the equations.
static sheen_status add_group(sheen_survey_problem *p, size_t f, size_t b, bool equations, sheen_err *err)
{
    sheen_survey_group *g = sheen_survey_at(p, f, b);
    const sheen_Rt *Rf = &p->Rt_cam_ref[f], *Rb = &p->Rt_ref_board[b];
    for (size_t i = 0; i < g->view->n_saddles; i++) {
        double p_ref[3], p_cam[3], q[2], dq[6], turned_b[3], turned_f[3];
        sheen_Rt_point(p_ref, Rb, g->view->saddles[i].p_board);
        sheen_Rt_point(p_cam, Rf, p_ref);
        const sheen_status s = sheen_camera_project(p->camera, q, dq, p_cam, 1, err);
        if (s)
            return s;
        const double e[2] = {g->view->saddles[i].q_px[0] - q[0], g->view->saddles[i].q_px[1] - q[1]};
        g->error_px[i] = isfinite(e[0] + e[1]) ? hypot(e[0], e[1]) : (double)INFINITY;
        if (!equations || !g->counts || !g->use[i] || !isfinite(g->error_px[i]))
            continue;
        sheen_sub(turned_b, p_ref, Rb->t);
        sheen_sub(turned_f, p_cam, Rf->t);
        p->chi2 += e[0] * e[0] + e[1] * e[1];
        p->n_points++;
        for (size_t k = 0; k < 2; k++) {
            double Jf[6], Jb[6], in_ref[3];
            const double *gk = dq + 3 * k;
            for (int c = 0; c < 3; c++)
                in_ref[c] = gk[0] * Rf->R[0][c] + gk[1] * Rf->R[1][c] + gk[2] * Rf->R[2][c];
            sheen_cross(Jf, turned_f, gk);
            memcpy(Jf + 3, gk, 3 * sizeof *Jf);
            sheen_cross(Jb, turned_b, in_ref);
            memcpy(Jb + 3, in_ref, sizeof in_ref);
            add_row(p, f, b, Jf, Jb, e[k]);
        }
    }
    return SHEEN_OK;
}

static sheen_status linearise(sheen_survey_problem *p, sheen_err *err)
{
    const size_t n = 6 * p->n_boards;
    memset(p->S, 0, (n * n + n) * sizeof *p->S);
    memset(p->V, 0, p->n_frames * (36 + 6 * n + 6) * sizeof *p->V);
    p->chi2 = 0;
    p->n_points = 0;
    for (size_t f = 0; f < p->n_frames; f++)
        for (size_t b = 0; b < p->n_boards && p->framed[f]; b++) {
            const sheen_status s = p->tied[b] ? add_group(p, f, b, true, err) : SHEEN_OK;
            if (s)
                return s;
        }
    return SHEEN_OK;
}

// Eliminates the frames; S becomes its Cholesky factor. Boards without points, and the first, stay where they are.
static bool reduce(sheen_survey_problem *p)
{
    const size_t n = 6 * p->n_boards;
    for (size_t f = 0; f < p->n_frames; f++) {
        double *V = p->V + 36 * f, *W = p->W + f * 6 * n, *g = p->g + 6 * f;
        if (!p->framed[f])
            continue;
        if (!sheen_cholesky(V, 6)) {
            p->framed[f] = false;
            continue;
        }
        double solved[6];
        memcpy(solved, g, sizeof solved);
        sheen_cholesky_solve(solved, V, 6);
        for (size_t j = 0; j < n; j++) {
            double column[6];
            for (size_t u = 0; u < 6; u++)
                column[u] = W[u * n + j];
            for (size_t u = 0; u < 6; u++)
                p->rhs[j] -= W[u * n + j] * solved[u];
            sheen_cholesky_solve(column, V, 6);
            for (size_t i = 0; i < n; i++)
                for (size_t u = 0; u < 6; u++)
                    p->S[i * n + j] -= W[u * n + i] * column[u];
        }
    }
    for (size_t j = 0; j < n; j++)
        if (j < 6 || !(p->S[j * n + j] > 1e-6))
            for (size_t i = 0; i < n; i++)
                p->S[j * n + i] = p->S[i * n + j] = i == j;
    return sheen_cholesky(p->S, (int)n);
}

// One step of all; the size of its largest part, metres or radians.
static double step_all(sheen_survey_problem *p)
{
    const size_t n = 6 * p->n_boards;
    double largest = 0;
    sheen_cholesky_solve(p->rhs, p->S, (int)n);
    for (size_t f = 0; f < p->n_frames; f++) {
        if (!p->framed[f])
            continue;
        double wd[6];
        for (size_t u = 0; u < 6; u++) {
            wd[u] = p->g[6 * f + u];
            for (size_t j = 6; j < n; j++)
                wd[u] -= p->W[f * 6 * n + u * n + j] * p->rhs[j];
        }
        sheen_cholesky_solve(wd, p->V + 36 * f, 6);
        for (int u = 0; u < 6; u++)
            largest = fmax(largest, fabs(wd[u]));
        sheen_pose_move(&p->Rt_cam_ref[f], &p->Rt_cam_ref[f], wd);
    }
    for (size_t b = 1; b < p->n_boards; b++) {
        if (!p->tied[b])
            continue;
        for (int u = 0; u < 6; u++)
            largest = fmax(largest, fabs(p->rhs[6 * b + (size_t)u]));
        sheen_pose_move(&p->Rt_ref_board[b], &p->Rt_ref_board[b], p->rhs + 6 * b);
    }
    return largest;
}

static sheen_status optimise(sheen_survey_problem *p, sheen_err *err)
{
    for (int i = 0; i < MAX_STEPS; i++) {
        const sheen_status s = linearise(p, err);
        if (s)
            return s;
        if (!reduce(p))
            return sheen_fail(err, SHEEN_EDATA,
                              "the frames do not determine where the boards are to each other");
        const double step = step_all(p);
        if (!isfinite(step))
            return sheen_fail(err, SHEEN_EDATA, "the boards' places do not settle");
        if (step < 1e-10)
            break;
    }
    return SHEEN_OK;
}

static void median_errors(sheen_survey_problem *p)
{
    for (size_t i = 0; i < p->n_frames * p->n_boards; i++) {
        sheen_survey_group *g = &p->groups[i];
        const size_t n = g->view->n_saddles;
        memcpy(g->error_px + n, g->error_px, n * sizeof *g->error_px);
        qsort(g->error_px + n, n, sizeof *g->error_px, sheen_ascending);
        g->median_px = n ? g->error_px[n + n / 2] : 0;
    }
}

// Leaves out groups that stand elsewhere: of each board only those that are nearly the worst, as the others may be
// misfits only because of them. True where there are any.
static bool leave_out_moved(sheen_survey_problem *p)
{
    bool changed = false;
    for (size_t b = 0; b < p->n_boards; b++) {
        double worst_px = 0;
        for (size_t f = 0; f < p->n_frames; f++)
            if (sheen_survey_at(p, f, b)->counts && p->framed[f])
                worst_px = fmax(worst_px, sheen_survey_at(p, f, b)->median_px);
        for (size_t f = 0; f < p->n_frames; f++) {
            sheen_survey_group *g = sheen_survey_at(p, f, b);
            size_t n_counting = 0;
            for (size_t b2 = 0; b2 < p->n_boards; b2++)
                n_counting += sheen_survey_at(p, f, b2)->counts;
            if (g->counts && p->framed[f] && n_counting > 1 && g->median_px >= MOVED_TOGETHER * worst_px &&
                g->median_px > fmax(MOVED_PX, MOVED_MEDIANS * g->own_px)) {
                g->counts = false;
                g->moved = changed = true;
            }
        }
    }
    return changed;
}

// Judges all points anew, board by board; true where anything changed.
static bool choose(sheen_survey_problem *p)
{
    median_errors(p);
    if (leave_out_moved(p))
        return true;
    bool changed = false;
    for (size_t i = 0; i < p->n_frames * p->n_boards; i++) {
        sheen_survey_group *g = &p->groups[i];
        const double limit_px = fmax(REJECT_FLOOR_PX, REJECT_MEDIANS * g->median_px);
        for (size_t k = 0; k < g->view->n_saddles && g->counts; k++) {
            const bool use = g->error_px[k] <= limit_px;
            changed = changed || use != g->use[k];
            g->use[k] = use;
        }
    }
    return changed;
}

// Boards that stand elsewhere in a frame, before all is fitted together: their single poses disagree.
static void part_moved(sheen_survey_problem *p)
{
    for (size_t f = 0; f < p->n_frames; f++)
        for (size_t b = 0; b < p->n_boards; b++) {
            sheen_survey_group *g = sheen_survey_at(p, f, b);
            sheen_Rt expected;
            if (!g->counts)
                continue;
            sheen_Rt_compose(&expected, &p->Rt_cam_ref[f], &p->Rt_ref_board[b]);
            if (!agree(&expected, &g->Rt_cam_board)) {
                g->counts = false;
                g->moved = true;
            }
        }
}

static sheen_status finish(sheen_survey *out, sheen_survey_problem *p, sheen_err *err)
{
    const size_t n = 6 * p->n_boards;
    double *S_inverse = malloc((n * n + 1) * sizeof *S_inverse);
    if (!S_inverse)
        return sheen_fail_memory(err, (double)(n * n) * sizeof *S_inverse, "a survey of boards");
    sheen_status s = linearise(p, err); // once more, where all came to rest: errors and equations
    if (!s && !reduce(p))
        s = sheen_fail(err, SHEEN_EDATA, "the frames do not determine where the boards are to each other");
    if (!s) {
        size_t unknowns = 0;
        for (size_t f = 0; f < p->n_frames; f++)
            unknowns += p->framed[f] ? 6 : 0;
        for (size_t b = 1; b < p->n_boards; b++)
            unknowns += p->tied[b] ? 6 : 0;
        const double freedom = fmax(1, 2 * (double)p->n_points - (double)unknowns),
                     sigma2 = p->chi2 / freedom;
        out->rms_px = sqrt(p->chi2 / (2 * fmax(1, (double)p->n_points)));
        sheen_cholesky_invert(S_inverse, p->S, (int)n);
        for (size_t b = 0; b < p->n_boards; b++)
            sheen_survey_report_board(&out->boards[b], p, b, sigma2, S_inverse);
        for (size_t f = 0; f < p->n_frames; f++)
            sheen_survey_report_frame(&out->frames[f], p, f, sigma2, S_inverse);
    }
    free(S_inverse);
    return s;
}

static sheen_status solve(sheen_survey *out, sheen_survey_problem *p, sheen_err *err)
{
    size_t n_framed = 0;
    start(p);
    part_moved(p);
    for (size_t f = 0; f < p->n_frames; f++)
        n_framed += p->framed[f];
    sheen_status s = n_framed ? SHEEN_OK
                              : sheen_fail(err, SHEEN_EDATA,
                                           "none of %zu frames shows enough of a board that is tied "
                                           "to the first",
                                           p->n_frames);
    for (int round = 0; round < ROUNDS && !s; round++) {
        s = optimise(p, err);
        if (!s && !choose(p))
            break;
    }
    return s ? s : finish(out, p, err);
}

sheen_status sheen_survey_solve(sheen_survey *out, const sheen_camera *camera, const sheen_board_set *boards,
                                const sheen_board_view *views, size_t n_frames, sheen_err *err)
{
    sheen_survey_problem p = {.camera = camera, .n_frames = n_frames, .n_boards = boards->n_boards};
    *out = (sheen_survey){.n_boards = boards->n_boards, .n_frames = n_frames};
    out->boards = calloc(out->n_boards + 1, sizeof *out->boards);
    out->frames = calloc(n_frames + 1, sizeof *out->frames);
    sheen_status s = out->boards && out->frames
                         ? allocate(&p, err)
                         : sheen_fail_memory(err, (double)n_frames * sizeof *out->frames,
                                             "a survey of boards");
    if (!s)
        s = pose_groups(&p, boards, views, out, err);
    if (!s)
        s = solve(out, &p, err);
    release(&p);
    if (s)
        sheen_survey_release(out);
    return s;
}

void sheen_survey_release(sheen_survey *survey)
{
    free(survey->boards);
    free(survey->frames);
    *survey = (sheen_survey){0};
}

// SPDX-License-Identifier: Apache-2.0
// board_survey_report.c - what a survey says of each board and frame: place, covariance, reason.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/vec.h"
#include "calib/cholesky.h"
#include "pose/board_survey_private.h"
#include "pose/pose_tangent.h"

void sheen_survey_report_board(sheen_survey_board *out, const sheen_survey_problem *p, size_t b,
                               double sigma2, const double *S_inverse)
{
    const size_t n = 6 * p->n_boards;
    out->found = p->tied[b];
    sheen_rt_from_Rt(out->rt_ref_board, &p->Rt_ref_board[b]);
    for (size_t f = 0; f < p->n_frames; f++) {
        const sheen_survey_group *g = sheen_survey_at(p, f, b);
        out->n_frames += g->counts && p->framed[f];
        if (!g->moved || !p->framed[f])
            continue;
        sheen_Rt inverse, here;
        double wd[6];
        out->n_moved++;
        sheen_Rt_invert(&inverse, &p->Rt_cam_ref[f]);
        sheen_Rt_compose(&here, &inverse, &g->Rt_cam_board);
        sheen_pose_difference(wd, &here, &p->Rt_ref_board[b]);
        out->moved_rad = sheen_norm(wd);
        out->moved_m = sheen_norm(wd + 3);
    }
    if (!out->found)
        snprintf(out->reason, sizeof out->reason,
                 "no frame shows it together with a board whose place is known");
    else if (out->n_moved)
        snprintf(out->reason, sizeof out->reason,
                 "was moved: in %d of %d frames it stands elsewhere, %.1f mm and %.1f "
                 "degrees away in the last",
                 out->n_moved, out->n_moved + out->n_frames, 1e3 * out->moved_m,
                 out->moved_rad * 57.29577951308232);
    if (b && out->found) {
        double C[36];
        for (size_t u = 0; u < 6; u++)
            for (size_t v = 0; v < 6; v++)
                C[6 * u + v] = sigma2 * S_inverse[(6 * b + u) * n + 6 * b + v];
        sheen_pose_covariance_of_rt(out->covariance, out->rt_ref_board, C);
    }
}

// V^-1 + V^-1 W S^-1 W' V^-1
static void frame_covariance(double C[36], const sheen_survey_problem *p, size_t f, double sigma2,
                             const double *S_inverse)
{
    const size_t n = 6 * p->n_boards;
    double VW[6][6];
    sheen_cholesky_invert(C, p->V + 36 * f, 6);
    double inverse[36];
    memcpy(inverse, C, sizeof inverse);
    for (size_t b = 1; b < p->n_boards; b++)
        for (size_t b2 = 1; b2 < p->n_boards; b2++) {
            double right[6][6] = {{0}}, middle[6][6] = {{0}};
            memset(VW, 0, sizeof VW);
            for (size_t u = 0; u < 6; u++)
                for (size_t v = 0; v < 6; v++)
                    for (size_t k = 0; k < 6; k++) {
                        VW[u][v] += inverse[6 * u + k] * p->W[f * 6 * n + k * n + 6 * b + v];
                        right[u][v] += inverse[6 * u + k] * p->W[f * 6 * n + k * n + 6 * b2 + v];
                    }
            for (size_t u = 0; u < 6; u++)
                for (size_t v = 0; v < 6; v++)
                    for (size_t k = 0; k < 6; k++)
                        middle[u][v] += VW[u][k] * S_inverse[(6 * b + k) * n + 6 * b2 + v];
            for (size_t u = 0; u < 6; u++)
                for (size_t v = 0; v < 6; v++)
                    for (size_t k = 0; k < 6; k++)
                        C[6 * u + v] += middle[u][k] * right[v][k];
        }
    for (int i = 0; i < 36; i++)
        C[i] *= sigma2;
}

void sheen_survey_report_frame(sheen_survey_frame *out, const sheen_survey_problem *p, size_t f,
                               double sigma2, const double *S_inverse)
{
    double sum = 0, C[36];
    out->found = p->framed[f];
    if (!out->found) {
        if (!out->reason[0])
            snprintf(out->reason, sizeof out->reason, "no board in view");
        return;
    }
    out->reason[0] = 0;
    sheen_rt_from_Rt(out->rt_cam_ref, &p->Rt_cam_ref[f]);
    int n_moved = 0;
    for (size_t b = 0; b < p->n_boards; b++) {
        const sheen_survey_group *g = sheen_survey_at(p, f, b);
        n_moved += g->moved;
        out->n_boards += g->counts;
        for (size_t i = 0; i < g->view->n_saddles && g->counts; i++) {
            out->n_points += g->use[i];
            out->n_outliers += !g->use[i];
            sum += g->use[i] ? g->error_px[i] * g->error_px[i] : 0;
        }
    }
    out->rms_px = sqrt(sum / (2 * fmax(1, out->n_points)));
    frame_covariance(C, p, f, fmax(sigma2, out->rms_px * out->rms_px), S_inverse);
    sheen_pose_covariance_of_rt(out->covariance, out->rt_cam_ref, C);
    if (n_moved)
        snprintf(out->reason, sizeof out->reason, "%d board%s moved and left out", n_moved,
                 n_moved > 1 ? "s were" : " was");
}

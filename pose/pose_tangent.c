// SPDX-License-Identifier: Apache-2.0
// pose_tangent.c - differences of poses in the tangent space, on the left.
#include "pose/pose_tangent.h"

#include <string.h>

#include "base/vec.h"
#include "calib/cholesky.h"

void sheen_pose_difference(double wd[6], const sheen_Rt *Rt_to, const sheen_Rt *Rt_from)
{
    sheen_Rt turn = {.t = {0}};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            turn.R[i][j] = sheen_dot(Rt_to->R[i], Rt_from->R[j]);
    sheen_rt_from_Rt(wd, &turn);
    sheen_sub(wd + 3, Rt_to->t, Rt_from->t);
}

void sheen_pose_move(sheen_Rt *out, const sheen_Rt *Rt, const double wd[6])
{
    sheen_Rt turn, still = *Rt;
    sheen_Rt_from_rt(&turn, (const double[6]){wd[0], wd[1], wd[2], 0, 0, 0});
    memset(still.t, 0, sizeof still.t);
    const double t[3] = {Rt->t[0] + wd[3], Rt->t[1] + wd[4], Rt->t[2] + wd[5]};
    sheen_Rt_compose(out, &turn, &still);
    memcpy(out->t, t, sizeof t);
}

// out = T C T' with T = diag(L, I)
static void turn_covariance(double out[36], const double L[3][3], const double C[36])
{
    double T[6][6] = {{0}};
    for (int i = 0; i < 3; i++) {
        memcpy(T[i], L[i], sizeof L[i]);
        T[3 + i][3 + i] = 1;
    }
    double TC[6][6];
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++) {
            TC[i][j] = 0;
            for (int k = 0; k < 6; k++)
                TC[i][j] += T[i][k] * C[6 * k + j];
        }
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++) {
            out[6 * i + j] = 0;
            for (int k = 0; k < 6; k++)
                out[6 * i + j] += TC[i][k] * T[j][k];
        }
}

bool sheen_pose_information(double information[36], const double rt[6], const double covariance[36])
{
    double L[3][3], C[36];
    sheen_r_left_jacobian(L, rt);
    turn_covariance(C, (const double(*)[3])L, covariance);
    if (!(C[0] > 0) || !sheen_cholesky(C, 6))
        return false;
    sheen_cholesky_invert(information, C, 6);
    return true;
}

void sheen_pose_covariance_of_rt(double covariance[36], const double rt[6], const double of_wd[36])
{
    double L[3][3], inverse[3][3];
    sheen_r_left_jacobian(L, rt);
    // L's inverse by its adjugate; |r| <= pi keeps it regular
    double det = 0;
    for (int i = 0; i < 3; i++) {
        double column[3];
        sheen_cross(column, L[(i + 1) % 3], L[(i + 2) % 3]);
        det = i ? det : sheen_dot(L[0], column);
        for (int j = 0; j < 3; j++)
            inverse[j][i] = column[j] / det;
    }
    turn_covariance(covariance, (const double(*)[3])inverse, of_wd);
}

double sheen_pose_product(const double a[6], const double P[36], const double b[6])
{
    double sum = 0;
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++)
            sum += a[i] * P[6 * i + j] * b[j];
    return sum;
}

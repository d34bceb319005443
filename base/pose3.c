// SPDX-License-Identifier: Apache-2.0
// pose3.c - rigid transformations: Rodrigues' formula and its inverse.
#include "base/pose3.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"

void sheen_Rt_from_rt(sheen_Rt *Rt_A_B, const double rt_A_B[6])
{
    const double *r = rt_A_B;
    const double th2 = sheen_dot(r, r), th = sqrt(th2);
    // R = I + a [r]x + b [r]x^2 with a = sin(th)/th, b = (1 - cos(th))/th^2; series below 1e-4
    const double a = th < 1e-4 ? 1 - th2 / 6 : sin(th) / th;
    const double s = sin(th / 2);
    const double b = th < 1e-4 ? 0.5 - th2 / 24 : 2 * s * s / th2;
    const double K[3][3] = {{0, -r[2], r[1]}, {r[2], 0, -r[0]}, {-r[1], r[0], 0}};
    sheen_Rt out;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const double K2 = r[i] * r[j] - (i == j ? th2 : 0);
            out.R[i][j] = (i == j) + a * K[i][j] + b * K2;
        }
    memcpy(out.t, rt_A_B + 3, sizeof out.t);
    *Rt_A_B = out;
}

// Through the unit quaternion (Shepperd's choice of the largest component), which is
// accurate at every angle, unlike the arc cosine of the trace.
void sheen_rt_from_Rt(double rt_A_B[6], const sheen_Rt *Rt_A_B)
{
    const double(*R)[3] = Rt_A_B->R;
    const double trace = R[0][0] + R[1][1] + R[2][2];
    double w, u[3];
    if (trace > R[0][0] && trace > R[1][1] && trace > R[2][2]) {
        const double s = sqrt(1 + trace);
        w = s / 2;
        u[0] = (R[2][1] - R[1][2]) / (2 * s);
        u[1] = (R[0][2] - R[2][0]) / (2 * s);
        u[2] = (R[1][0] - R[0][1]) / (2 * s);
    } else {
        const int i = R[0][0] >= R[1][1] && R[0][0] >= R[2][2] ? 0 : R[1][1] >= R[2][2] ? 1 : 2;
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const double s = sqrt(fmax(0, 1 + R[i][i] - R[j][j] - R[k][k]));
        u[i] = s / 2;
        u[j] = (R[j][i] + R[i][j]) / (2 * s);
        u[k] = (R[k][i] + R[i][k]) / (2 * s);
        w = (R[k][j] - R[j][k]) / (2 * s);
        if (w < 0) {
            w = -w;
            for (int m = 0; m < 3; m++)
                u[m] = -u[m];
        }
    }
    const double n = sheen_norm(u);
    const double scale = n < 1e-9 ? 2 / w : 2 * atan2(n, w) / n;
    for (int i = 0; i < 3; i++)
        rt_A_B[i] = u[i] * scale;
    memmove(rt_A_B + 3, Rt_A_B->t, sizeof Rt_A_B->t);
}

void sheen_Rt_compose(sheen_Rt *Rt_A_C, const sheen_Rt *Rt_A_B, const sheen_Rt *Rt_B_C)
{
    sheen_Rt out;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            out.R[i][j] = 0;
            for (int k = 0; k < 3; k++)
                out.R[i][j] += Rt_A_B->R[i][k] * Rt_B_C->R[k][j];
        }
    }
    sheen_Rt_point(out.t, Rt_A_B, Rt_B_C->t);
    *Rt_A_C = out;
}

void sheen_Rt_invert(sheen_Rt *Rt_B_A, const sheen_Rt *Rt_A_B)
{
    sheen_Rt out;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out.R[i][j] = Rt_A_B->R[j][i];
    for (int i = 0; i < 3; i++)
        out.t[i] = -sheen_dot(out.R[i], Rt_A_B->t);
    *Rt_B_A = out;
}

void sheen_rt_compose(double rt_A_C[6], const double rt_A_B[6], const double rt_B_C[6])
{
    sheen_Rt ab, bc;
    sheen_Rt_from_rt(&ab, rt_A_B);
    sheen_Rt_from_rt(&bc, rt_B_C);
    sheen_Rt_compose(&ab, &ab, &bc);
    sheen_rt_from_Rt(rt_A_C, &ab);
}

void sheen_rt_invert(double rt_B_A[6], const double rt_A_B[6])
{
    sheen_Rt m;
    sheen_Rt_from_rt(&m, rt_A_B);
    sheen_Rt_invert(&m, &m);
    for (int i = 0; i < 3; i++)
        rt_B_A[i] = -rt_A_B[i];
    memcpy(rt_B_A + 3, m.t, sizeof m.t);
}

void sheen_Rt_point(double p_A[3], const sheen_Rt *Rt_A_B, const double p_B[3])
{
    const double p[3] = {p_B[0], p_B[1], p_B[2]};
    for (int i = 0; i < 3; i++)
        p_A[i] = sheen_dot(Rt_A_B->R[i], p) + Rt_A_B->t[i];
}

void sheen_Rt_direction(double v_A[3], const sheen_Rt *Rt_A_B, const double v_B[3])
{
    const double v[3] = {v_B[0], v_B[1], v_B[2]};
    for (int i = 0; i < 3; i++)
        v_A[i] = sheen_dot(Rt_A_B->R[i], v);
}

double sheen_rt_angle_rad(const double rt_A_B[6], const double rt_A_C[6])
{
    double rt_B_A[6], rt_B_C[6];
    sheen_rt_invert(rt_B_A, rt_A_B);
    sheen_rt_compose(rt_B_C, rt_B_A, rt_A_C);
    return sheen_norm(rt_B_C);
}

void sheen_r_left_jacobian(double L[3][3], const double r[3])
{
    const double th2 = sheen_dot(r, r), th = sqrt(th2);
    const double a = th < 1e-4 ? 0.5 - th2 / 24 : (1 - cos(th)) / th2;
    const double b = th < 1e-4 ? 1.0 / 6 - th2 / 120 : (th - sin(th)) / (th2 * th);
    const double K[3][3] = {{0, -r[2], r[1]}, {r[2], 0, -r[0]}, {-r[1], r[0], 0}};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            L[i][j] = (i == j) + a * K[i][j] + b * (r[i] * r[j] - (i == j ? th2 : 0));
}

static void inverse_transpose(double out[3][3], const double M[3][3], double *det)
{
    for (int i = 0; i < 3; i++)
        sheen_cross(out[i], M[(i + 1) % 3], M[(i + 2) % 3]);
    *det = sheen_dot(M[0], out[0]);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out[i][j] /= *det;
}

int sheen_R_orthonormalize(double R[3][3], double tolerance)
{
    double M[3][3], inv[3][3], det;
    memcpy(M, R, sizeof M);
    for (int round = 0; round < 20; round++) {
        inverse_transpose(inv, (const double(*)[3])M, &det);
        if (!isfinite(det) || det <= 0)
            return 0;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++)
                M[i][j] = 0.5 * (M[i][j] + inv[i][j]);
    }
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            if (!(fabs(M[i][j] - R[i][j]) <= tolerance))
                return 0;
    memcpy(R, M, sizeof M);
    return 1;
}

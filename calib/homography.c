// SPDX-License-Identifier: Apache-2.0
// homography.c - direct linear transformation in normalised coordinates (Hartley), and the pose of a plane from
// it (Zhang 2000, section 3.1): H ~ [r1 r2 t].
#include "calib/homography.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"
#include "calib/cholesky.h"

// A similarity that brings points to mean 0 and mean distance sqrt 2: x' = scale (x - mean).
typedef struct normaliser {
    double mean[2], scale;
} normaliser;

static bool normalise(normaliser *m, const double *x, size_t n)
{
    *m = (normaliser){.scale = 0};
    for (size_t i = 0; i < n; i++)
        for (int k = 0; k < 2; k++)
            m->mean[k] += x[2 * i + (size_t)k] / (double)n;
    double distance = 0;
    for (size_t i = 0; i < n; i++)
        distance += hypot(x[2 * i] - m->mean[0], x[2 * i + 1] - m->mean[1]) / (double)n;
    m->scale = sqrt(2.0) / distance;
    return distance > 0 && isfinite(distance);
}

// Adds one linear equation a.h = b to the normal equations.
static void add_equation(double A[64], double y[8], const double a[8], double b)
{
    for (int i = 0; i < 8; i++) {
        for (int j = 0; j <= i; j++)
            A[8 * i + j] += a[i] * a[j];
        y[i] += a[i] * b;
    }
}

bool sheen_homography_fit(double H[9], const double *xy, const double *q, size_t n)
{
    normaliser from, to;
    if (n < 4 || !normalise(&from, xy, n) || !normalise(&to, q, n))
        return false;
    double A[64] = {0}, h[9] = {0};
    for (size_t i = 0; i < n; i++) {
        const double x = from.scale * (xy[2 * i] - from.mean[0]),
                     y = from.scale * (xy[2 * i + 1] - from.mean[1]);
        const double u = to.scale * (q[2 * i] - to.mean[0]), v = to.scale * (q[2 * i + 1] - to.mean[1]);
        add_equation(A, h, (const double[8]){x, y, 1, 0, 0, 0, -u * x, -u * y}, u);
        add_equation(A, h, (const double[8]){0, 0, 0, x, y, 1, -v * x, -v * y}, v);
    }
    if (!sheen_cholesky(A, 8))
        return false;
    sheen_cholesky_solve(h, A, 8);
    h[8] = 1;

    // H = inverse(T_to) h T_from
    double hT[9];
    for (size_t r = 0; r < 3; r++) {
        hT[3 * r] = h[3 * r] * from.scale;
        hT[3 * r + 1] = h[3 * r + 1] * from.scale;
        hT[3 * r + 2] = h[3 * r + 2] - hT[3 * r] * from.mean[0] - hT[3 * r + 1] * from.mean[1];
    }
    for (int c = 0; c < 3; c++) {
        H[c] = hT[c] / to.scale + to.mean[0] * hT[6 + c];
        H[3 + c] = hT[3 + c] / to.scale + to.mean[1] * hT[6 + c];
        H[6 + c] = hT[6 + c];
    }
    for (int i = 0; i < 9; i++)
        if (!isfinite(H[i]))
            return false;
    return true;
}

bool sheen_homography_apply(double q[2], const double H[9], const double xy[2])
{
    const double w = H[6] * xy[0] + H[7] * xy[1] + H[8];
    if (!(w > 0))
        return false;
    q[0] = (H[0] * xy[0] + H[1] * xy[1] + H[2]) / w;
    q[1] = (H[3] * xy[0] + H[4] * xy[1] + H[5]) / w;
    return isfinite(q[0]) && isfinite(q[1]);
}

bool sheen_homography_pose(sheen_Rt *Rt_B_A, const double H[9], const double xy[2])
{
    double r1[3], r2[3], r3[3];
    for (size_t i = 0; i < 3; i++) {
        r1[i] = H[3 * i];
        r2[i] = H[3 * i + 1];
    }
    const double size = sqrt(sheen_norm(r1) * sheen_norm(r2));
    const double depth = H[6] * xy[0] + H[7] * xy[1] + H[8];
    if (!(size > 0) || !isfinite(size) || !(fabs(depth) > 0))
        return false;
    const double scale = (depth > 0 ? 1 : -1) / size;
    for (int i = 0; i < 3; i++) {
        r1[i] *= scale;
        r2[i] *= scale;
        Rt_B_A->t[i] = scale * H[3 * i + 2];
    }
    sheen_cross(r3, r1, r2);
    for (int i = 0; i < 3; i++) {
        Rt_B_A->R[i][0] = r1[i];
        Rt_B_A->R[i][1] = r2[i];
        Rt_B_A->R[i][2] = r3[i];
    }
    // noise and a rough focal length leave r1 and r2 far from orthonormal: any tolerance will do
    return sheen_R_orthonormalize(Rt_B_A->R, 10.0);
}

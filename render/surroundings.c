// SPDX-License-Identifier: Apache-2.0
// surroundings.c - looks up board and room in a mirror direction.
#include "render/surroundings.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"

void sheen_surroundings_release(sheen_surroundings *s)
{
    sheen_image_release(&s->board);
    *s = (sheen_surroundings){0};
}

float sheen_fresnel(double f0, float cosine)
{
    const float x = 1 - (cosine > 0 ? cosine < 1 ? cosine : 1 : 0), x2 = x * x;
    return (float)f0 + (1 - (float)f0) * x2 * x2 * x;
}

void sheen_ambient_basis(double basis[SHEEN_AMBIENT_TERMS], const float v_world[3])
{
    const double x = (double)v_world[0], y = (double)v_world[1], z = (double)v_world[2];
    basis[0] = 0.28209479177387814;
    basis[1] = 0.48860251190291992 * y;
    basis[2] = 0.48860251190291992 * z;
    basis[3] = 0.48860251190291992 * x;
    basis[4] = 1.0925484305920792 * x * y;
    basis[5] = 1.0925484305920792 * y * z;
    basis[6] = 0.31539156525252005 * (3 * z * z - 1);
    basis[7] = 1.0925484305920792 * x * z;
    basis[8] = 0.54627421529603959 * (x * x - y * y);
}

static void from_above(float rgb[3], const sheen_surroundings *s, const float r_world[3])
{
    double basis[SHEEN_AMBIENT_TERMS];
    sheen_ambient_basis(basis, r_world);
    for (int c = 0; c < 3; c++) {
        double sum = 0;
        for (int k = 0; k < SHEEN_AMBIENT_TERMS; k++)
            sum += basis[k] * s->ambient_rgb[k][c];
        rgb[c] = sum > 0 ? (float)sum : 0; // no light is negative
    }
}

void sheen_surroundings_radiance(float rgb[3], const sheen_surroundings *s, const float p_world[3],
                                 const float r_world[3])
{
    if (r_world[2] >= 0) {
        from_above(rgb, s, r_world);
        return;
    }
    const double t = -(double)p_world[2] / (double)r_world[2];
    if (s->board.data && t > 0) {
        const double x = (double)p_world[0] + t * (double)r_world[0],
                     y = (double)p_world[1] + t * (double)r_world[1];
        if (sheen_image_bilinear(rgb, &s->board, (x - s->board_x0_m) / s->board_pitch_m,
                                 (y - s->board_y0_m) / s->board_pitch_m))
            return;
    }
    for (int c = 0; c < 3; c++)
        rgb[c] = (float)s->table_rgb[c];
}

// sqrt(-2 log(1 - (k + 1/2) / 16)) at the angle 2.39996 k: a sunflower's spiral with the radii of a Gaussian of width 1.
static const float spread[SHEEN_SPREAD_POINTS][2] = {
    {0.251987f, 0.000000f},   {-0.327179f, 0.299723f}, {0.050962f, -0.580690f}, {0.427521f, 0.557625f},
    {-0.800278f, -0.141558f}, {0.774431f, -0.492629f}, {-0.265075f, 0.986067f}, {-0.518402f, -0.998151f},
    {1.156308f, 0.422282f},   {-1.240681f, 0.512135f}, {0.619407f, -1.323637f}, {0.476700f, 1.519796f},
    {-1.508461f, -0.874184f}, {1.881868f, -0.413723f}, {-1.251385f, 1.779967f}, {-0.338339f, -2.610938f}};

void sheen_surroundings_plane(float rgb[3], const sheen_surroundings *s, const float p_world[3],
                              const float r_world[3], float spread_rad)
{
    const float along_x = fabsf(r_world[0]) < 0.7f ? 1.0f : 0.0f, axis[3] = {along_x, 1 - along_x, 0};
    float a[3], b[3], sum[3] = {0, 0, 0};
    int n = 0;
    sheen_crossf(a, r_world, axis);
    sheen_normalizef(a);
    sheen_crossf(b, r_world, a);
    for (int k = 0; k < SHEEN_SPREAD_POINTS && spread_rad > 0; k++) {
        const float u = spread_rad * spread[k][0], v = spread_rad * spread[k][1];
        float r[3], part[3];
        for (int i = 0; i < 3; i++)
            r[i] = r_world[i] + u * a[i] + v * b[i];
        if (!(r[2] < 0))
            continue;
        sheen_surroundings_radiance(part, s, p_world, r);
        for (int c = 0; c < 3; c++)
            sum[c] += part[c];
        n++;
    }
    if (!n)
        sheen_surroundings_radiance(rgb, s, p_world, r_world);
    for (int c = 0; c < 3 && n; c++)
        rgb[c] = sum[c] / (float)n;
}

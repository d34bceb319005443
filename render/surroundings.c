// SPDX-License-Identifier: Apache-2.0
// surroundings.c - looks up board and room in a mirror direction.
#include "render/surroundings.h"

#include <math.h>
#include <stdbool.h>
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
static const float spread_x[SHEEN_SPREAD_POINTS] = {
    0.251987f, -0.327179f, 0.050962f, 0.427521f, -0.800278f, 0.774431f, -0.265075f, -0.518402f,
    1.156308f, -1.240681f, 0.619407f, 0.476700f, -1.508461f, 1.881868f, -1.251385f, -0.338339f};
static const float spread_y[SHEEN_SPREAD_POINTS] = {
    0.000000f, 0.299723f, -0.580690f, 0.557625f, -0.141558f, -0.492629f, 0.986067f, -0.998151f,
    0.422282f, 0.512135f, -1.323637f, 1.519796f, -0.874184f, -0.413723f, 1.779967f, -2.610938f};

// Where the spread's directions meet the plane, in the board's pixels, all at once; they start at p and lie about r.
typedef struct spread_places {
    float x_px[SHEEN_SPREAD_POINTS], y_px[SHEEN_SPREAD_POINTS];
    float below[SHEEN_SPREAD_POINTS]; // 1: the direction leads down
} spread_places;

static void find_places(spread_places *at, const sheen_surroundings *s, const float p[3], const float r[3],
                        float spread_rad)
{
    const float along_x = fabsf(r[0]) < 0.7f ? 1.0f : 0.0f, axis[3] = {along_x, 1 - along_x, 0};
    float a[3], b[3];
    sheen_crossf(a, r, axis);
    sheen_normalizef(a);
    sheen_crossf(b, r, a);
    const double per_pitch = s->board.data ? 1 / s->board_pitch_m : 0;
    const float height_px = (float)((double)p[2] * per_pitch);
    const float x0_px = (float)(((double)p[0] - s->board_x0_m) * per_pitch),
                y0_px = (float)(((double)p[1] - s->board_y0_m) * per_pitch);
#pragma omp simd
    for (int k = 0; k < SHEEN_SPREAD_POINTS; k++) {
        const float u = spread_rad * spread_x[k], v = spread_rad * spread_y[k];
        const float z = r[2] + u * a[2] + v * b[2];
        const float t_px = z < 0 ? -height_px / z : 0;
        at->below[k] = z < 0 ? 1.0f : 0.0f;
        at->x_px[k] = x0_px + t_px * (r[0] + u * a[0] + v * b[0]);
        at->y_px[k] = y0_px + t_px * (r[1] + u * a[1] + v * b[1]);
    }
}

// Adds the picture's linear interpolation at a place in it.
static void add_texels(float sum[3], const sheen_image *board, float x_px, float y_px)
{
    const int x = (int)x_px, y = (int)y_px;
    const float fx = x_px - (float)x, fy = y_px - (float)y;
    const size_t right = x + 1 < board->width_px ? 3 : 0,
                 down = y + 1 < board->height_px ? 3 * (size_t)board->width_px : 0;
    const float *low = sheen_image_at(board, x, y), *high = low + down;
    const float w11 = fx * fy, w10 = fx - w11, w01 = fy - w11, w00 = 1 - fx - w01;
    for (size_t c = 0; c < 3; c++)
        sum[c] += w00 * low[c] + w10 * low[right + c] + w01 * high[c] + w11 * high[right + c];
}

void sheen_surroundings_plane(float rgb[3], const sheen_surroundings *s, const float p_world[3],
                              const float r_world[3], float spread_rad)
{
    const sheen_image *board = &s->board;
    const bool pictured = board->data && p_world[2] > 0;
    const float right = (float)(board->width_px - 1), bottom = (float)(board->height_px - 1);
    float sum[3] = {0, 0, 0}, n = 0, n_table = 0;
    if (spread_rad > 0) {
        spread_places at;
        find_places(&at, s, p_world, r_world, spread_rad);
        for (int k = 0; k < SHEEN_SPREAD_POINTS; k++) {
            const float x = at.x_px[k], y = at.y_px[k];
            n += at.below[k];
            if (pictured && at.below[k] > 0 && x >= 0 && y >= 0 && x <= right && y <= bottom)
                add_texels(sum, board, x, y);
            else
                n_table += at.below[k];
        }
    }
    if (!(n > 0))
        sheen_surroundings_radiance(rgb, s, p_world, r_world);
    for (int c = 0; c < 3 && n > 0; c++)
        rgb[c] = (sum[c] + n_table * (float)s->table_rgb[c]) / n;
}

// SPDX-License-Identifier: Apache-2.0
// support_board.c - renders a board through a lens, by looking every sample's place on the board up.
#include "support_board.h"

#include <apriltag/tag36h11.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "base/vec.h"
#include "support.h"

enum { TAG_CELLS = 8, SUB = 8, STEP_PX = 4, MAX_TAGS = 600, MAX_BLUR = 12 };

static const double WHITE = 0.85, BLACK = 0.05, TABLE = 0.2, COVER = 0.4;

void test_board_make(sheen_board *board, int n_cols, int n_rows, double square_m, double tag_ratio,
                     int first_id, double blank_radius_m)
{
    sheen_err err;
    const sheen_board_layout layout = {.n_cols = n_cols,
                                       .n_rows = n_rows,
                                       .square_m = square_m,
                                       .tag_side_m = tag_ratio * square_m,
                                       .first_id = first_id};
    assert_ok(sheen_board_make(board, &layout, &err), err);
    board->blank_radius_m = blank_radius_m;
    for (size_t i = 0; i < board->n_corners; i++) {
        const double *p = board->corners[i].p_board;
        board->corners[i].printed = hypot(p[0], p[1]) > blank_radius_m;
    }
    for (size_t i = 0; i < board->n_tags; i++) {
        const double(*c)[3] = (const double(*)[3])board->tags[i].corners_board;
        board->tags[i].printed = hypot((c[0][0] + c[2][0]) / 2, (c[0][1] + c[2][1]) / 2) > blank_radius_m;
    }
}

void test_board_save(const sheen_board *board, const char *path)
{
    sheen_err err;
    assert_ok(sheen_boards_save(board, 1, path, &err), err);
}

// [id][row][col] of the tag's black square, 1: white.
typedef struct ink {
    const test_photo *photo;
    uint8_t (*bits)[TAG_CELLS][TAG_CELLS];
} ink;

static void ink_init(ink *in, const test_photo *photo)
{
    *in = (ink){.photo = photo, .bits = calloc(MAX_TAGS, sizeof *in->bits)};
    assert_non_null(in->bits);
    apriltag_family_t *family = tag36h11_create();
    for (size_t i = 0; i < photo->board->n_tags; i++) {
        const int id = photo->board->tags[i].id;
        assert_true(id >= 0 && id < (int)family->ncodes && id < MAX_TAGS);
        image_u8_t *picture = apriltag_to_image(family, id); // with a white rim of one cell
        for (int y = 0; y < TAG_CELLS; y++)
            for (int x = 0; x < TAG_CELLS; x++)
                in->bits[id][y][x] = picture->buf[(y + 1) * picture->stride + x + 1] > 127 ? 1 : 0;
        free(picture->buf);
        free(picture);
    }
    tag36h11_destroy(family);
}

// Light from a place on the board's plane.
static double light_at(const ink *in, double x, double y)
{
    const test_photo *photo = in->photo;
    const sheen_board *b = photo->board;
    if (photo->cover_radius_m > 0 &&
        hypot(x - photo->cover_board[0], y - photo->cover_board[1]) < photo->cover_radius_m)
        return COVER;
    const double u = x / b->square_m + 0.5 * b->n_cols, v = 0.5 * b->n_rows - y / b->square_m;
    if (u < -0.5 || v < -0.5 || u > b->n_cols + 0.5 || v > b->n_rows + 0.5)
        return TABLE;
    if (u < 0 || v < 0 || u >= b->n_cols || v >= b->n_rows)
        return WHITE;
    const int row = (int)v, col = (int)u;
    if ((row + col) % 2 == 0)
        return BLACK;
    const double cell = b->tag_side_m / b->square_m / TAG_CELLS, margin = (1 - TAG_CELLS * cell) / 2;
    const int i = (int)floor((u - col - margin) / cell), j = (int)floor((v - row - margin) / cell);
    if (i < 0 || j < 0 || i >= TAG_CELLS || j >= TAG_CELLS)
        return WHITE;
    const sheen_board_tag *tag =
        &b->tags[(row * b->n_cols + col) / 2]; // every other square, in reading order
    const bool blank = !tag->printed || tag->row != row || tag->col != col;
    return blank || in->bits[tag->id][j][i] ? WHITE : BLACK;
}

// Directions (x/z, y/z) of a grid of places STEP_PX apart, the first one at -1 steps.
static double *direction_grid(const sheen_camera *camera, int n_cols, int n_rows)
{
    const size_t n = (size_t)n_cols * (size_t)n_rows;
    double *q = malloc(2 * n * sizeof *q), *v = malloc(3 * n * sizeof *v);
    sheen_err err;
    assert_non_null(q);
    assert_non_null(v);
    for (size_t i = 0; i < n; i++) {
        q[2 * i] = ((double)(i % (size_t)n_cols) - 1) * STEP_PX;
        q[2 * i + 1] = ((double)(i / (size_t)n_cols) - 1) * STEP_PX;
    }
    assert_ok(sheen_camera_unproject(camera, v, q, n, &err), err);
    for (size_t i = 0; i < n; i++) {
        q[2 * i] = v[3 * i] / v[3 * i + 2];
        q[2 * i + 1] = v[3 * i + 1] / v[3 * i + 2];
    }
    free(v);
    return q;
}

static double sample(const ink *in, const sheen_Rt *Rt, const double *grid, int grid_cols, double x, double y)
{
    const double gx = x / STEP_PX + 1, gy = y / STEP_PX + 1;
    const int i = (int)gx, j = (int)gy;
    const double a = gx - i, b = gy - j;
    const double *g = grid + 2 * ((size_t)j * (size_t)grid_cols + (size_t)i), *below = g + 2 * grid_cols;
    double v[3] = {0, 0, 1};
    for (int k = 0; k < 2; k++)
        v[k] = (1 - b) * ((1 - a) * g[k] + a * g[2 + k]) + b * ((1 - a) * below[k] + a * below[2 + k]);
    const double n[3] = {Rt->R[0][2], Rt->R[1][2], Rt->R[2][2]};
    const double depth = sheen_dot(n, Rt->t) / sheen_dot(n, v);
    if (!(depth > 0))
        return TABLE;
    double d[3], p[2];
    for (int k = 0; k < 3; k++)
        d[k] = depth * v[k] - Rt->t[k];
    for (int k = 0; k < 2; k++)
        p[k] = d[0] * Rt->R[0][k] + d[1] * Rt->R[1][k] + d[2] * Rt->R[2][k];
    return light_at(in, p[0], p[1]);
}

// A pixel's mean light. Where its corners differ, over SUB x SUB places, rows and columns sheared so that an edge along
// the pixels' grid is met at SUB * SUB different places, too.
static double pixel(const ink *in, const sheen_Rt *Rt, const double *grid, int grid_cols, int x, int y)
{
    double corners[4], sum = 0;
    for (int k = 0; k < 4; k++)
        corners[k] = sample(in, Rt, grid, grid_cols, x + 0.49 * (k % 2 ? 1 : -1),
                            y + 0.49 * (k / 2 ? 1 : -1));
    if (corners[0] == corners[1] && corners[0] == corners[2] && corners[0] == corners[3])
        return corners[0];
    for (int j = 0; j < SUB; j++)
        for (int i = 0; i < SUB; i++)
            sum += sample(in, Rt, grid, grid_cols, x + (i + (j + 0.5) / SUB) / SUB - 0.5,
                          y + (j + (i + 0.5) / SUB) / SUB - 0.5);
    return sum / (SUB * SUB);
}

// Along rows of `from`, transposed into `to`: twice is a blur in both directions.
static void blur_rows(float *to, const float *from, int width, int height, double sigma)
{
    float kernel[2 * MAX_BLUR + 1], sum = 0;
    const int r = sigma > 0 ? (int)fmin(MAX_BLUR, ceil(4 * sigma)) : 0;
    for (int i = -r; i <= r; i++)
        sum += kernel[i + r] = sigma > 0 ? (float)exp(-i * i / (2 * sigma * sigma)) : 1;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            float value = 0;
            for (int i = -r; i <= r; i++) {
                const int at = x + i < 0 ? 0 : x + i >= width ? width - 1 : x + i;
                value += kernel[i + r] * from[(size_t)y * (size_t)width + (size_t)at];
            }
            to[(size_t)x * (size_t)height + (size_t)y] = value / sum;
        }
}

uint8_t *test_photo_render(const test_photo *photo)
{
    const int width = photo->camera->width_px, height = photo->camera->height_px;
    const size_t n = (size_t)width * (size_t)height;
    const int grid_cols = width / STEP_PX + 4, grid_rows = height / STEP_PX + 4;
    uint64_t seed = photo->seed;
    ink in;
    sheen_Rt Rt;
    sheen_Rt_from_rt(&Rt, photo->rt_cam_board);
    ink_init(&in, photo);
    double *grid = direction_grid(photo->camera, grid_cols, grid_rows);
    float *light = malloc(n * sizeof *light), *turned = malloc(n * sizeof *turned);
    uint8_t *out = malloc(n);
    assert_true(light && turned && out);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            light[(size_t)y * (size_t)width + (size_t)x] = (float)pixel(&in, &Rt, grid, grid_cols, x, y);
        }
    blur_rows(turned, light, width, height, photo->blur_px);
    blur_rows(light, turned, height, width, photo->blur_px);
    for (size_t i = 0; i < n; i++) {
        const double code = photo->gamma > 0 ? pow((double)light[i], 1 / photo->gamma) : (double)light[i];
        const double noise = photo->noise_dn > 0 ? photo->noise_dn * test_random_normal(&seed) : 0;
        out[i] = (uint8_t)fmax(0, fmin(255, floor(255 * code + noise + 0.5)));
    }
    free(in.bits);
    free(grid);
    free(light);
    free(turned);
    return out;
}

void test_board_look(double rt_cam_board[6], const double target_board[2], double distance_m, double tilt_deg,
                     double azimuth_deg, double roll_deg)
{
    const double rad = 0.017453292519943295;
    const double tilt = tilt_deg * rad, azimuth = azimuth_deg * rad, roll = roll_deg * rad;
    const double z[3] = {-sin(tilt) * cos(azimuth), -sin(tilt) * sin(azimuth),
                         -cos(tilt)}; // cam z in the board
    double x[3], y[3];
    // a direction "down" in the picture that is never along z
    const double down[3] = {cos(azimuth) * cos(tilt), sin(azimuth) * cos(tilt), -sin(tilt)};
    sheen_cross(x, down, z);
    sheen_normalize(x);
    sheen_cross(y, z, x);
    sheen_Rt Rt;
    for (int k = 0; k < 3; k++) {
        Rt.R[0][k] = cos(roll) * x[k] + sin(roll) * y[k];
        Rt.R[1][k] = -sin(roll) * x[k] + cos(roll) * y[k];
        Rt.R[2][k] = z[k];
    }
    const double target[3] = {target_board[0], target_board[1], 0};
    memset(Rt.t, 0, sizeof Rt.t);
    sheen_Rt_direction(Rt.t, &Rt, target);
    for (int k = 0; k < 3; k++)
        Rt.t[k] = (k == 2 ? distance_m : 0) - Rt.t[k];
    sheen_rt_from_Rt(rt_cam_board, &Rt);
}

void test_board_project(double q_px[2], const sheen_camera *camera, const double rt_cam_board[6],
                        const double p_board[3])
{
    sheen_Rt Rt;
    double p_cam[3];
    sheen_err err;
    sheen_Rt_from_rt(&Rt, rt_cam_board);
    sheen_Rt_point(p_cam, &Rt, p_board);
    assert_ok(sheen_camera_project(camera, q_px, NULL, p_cam, 1, &err), err);
}

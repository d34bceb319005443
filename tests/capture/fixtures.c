// SPDX-License-Identifier: Apache-2.0
// fixtures.c - input files for the tests of capture and of the program.
#include "tests/capture/fixtures.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "base/file.h"
#include "base/image_file.h"
#include "base/json_write.h"
#include "base/pose3.h"
#include "tests/support.h"

static const double pi = 3.14159265358979323846;

static void save_raster(const char *path, sheen_raster *r)
{
    sheen_err err;
    if (!strcmp(sheen_path_extension(path), "jpg"))
        assert_ok(sheen_jpeg_write(path, r, 90, &err), err);
    else
        assert_ok(sheen_png_write(path, r, &err), err);
    sheen_raster_release(r);
}

void fixture_picture(const char *path, int width_px, int height_px, unsigned seed, int flat)
{
    sheen_err err;
    if (!strcmp(sheen_path_extension(path), "exr")) {
        sheen_image img;
        assert_ok(sheen_image_init(&img, width_px, height_px, 3, &err), err);
        for (int i = 0; i < width_px * height_px * 3; i++)
            img.data[i] = flat ? 0.25f : (float)((unsigned)i * (seed + 3) % 61) / 60.0f;
        assert_ok(sheen_exr_write(path, &img, NULL, true, &err), err);
        sheen_image_release(&img);
        return;
    }
    sheen_raster r;
    assert_ok(sheen_raster_init(&r, width_px, height_px, 3, 8, &err), err);
    for (int i = 0; i < width_px * height_px * 3; i++)
        ((uint8_t *)r.data)[i] = (uint8_t)(flat ? 120 : (unsigned)i * (seed + 3) % 251);
    save_raster(path, &r);
}

void fixture_mask(const char *path, int width_px, int height_px)
{
    sheen_err err;
    sheen_raster r;
    assert_ok(sheen_raster_init(&r, width_px, height_px, 1, 8, &err), err);
    for (int y = 0; y < height_px; y++)
        for (int x = 0; x < width_px; x++)
            ((uint8_t *)r.data)[y * width_px + x] =
                hypot(x - width_px / 2.0, y - height_px / 2.0) < height_px / 4.0 ? 255 : 0;
    save_raster(path, &r);
}

static void put_point(sheen_json_writer *w, const char *key, double x, double y)
{
    const double p[3] = {x, y, 0};
    sheen_json_put_numbers(w, key, p, 3);
}

static void put_tag(sheen_json_writer *w, int id, int row, int col)
{
    const double x = (col - 1.5) * 0.03, y = (1.5 - row) * 0.03, half = 0.0096;
    sheen_json_open(w, NULL, '{');
    sheen_json_put_int(w, "id", id);
    sheen_json_put_int(w, "row", row);
    sheen_json_put_int(w, "col", col);
    put_point(w, "centre", x, y);
    sheen_json_open(w, "corners", '[');
    put_point(w, NULL, x - half, y + half);
    put_point(w, NULL, x + half, y + half);
    put_point(w, NULL, x + half, y - half);
    put_point(w, NULL, x - half, y - half);
    sheen_json_close(w);
    sheen_json_put_bool(w, "printed", true);
    sheen_json_close(w);
}

void fixture_board(const char *path)
{
    static const double size[2] = {0.12, 0.12};
    sheen_json_writer w = {0};
    sheen_err err;
    int id = 0;
    sheen_json_open(&w, NULL, '{');
    sheen_json_put_string(&w, "family", "tag36h11");
    sheen_json_put_int(&w, "cols", 4);
    sheen_json_put_int(&w, "rows", 4);
    sheen_json_put_number(&w, "square", 0.03);
    sheen_json_put_number(&w, "tag_cell", 0.0024);
    sheen_json_put_number(&w, "tag_black_side", 0.0192);
    sheen_json_put_numbers(&w, "size", size, 2);
    sheen_json_open(&w, "tags", '[');
    for (int row = 0; row < 4; row++)
        for (int col = 0; col < 4; col++)
            if ((row + col) % 2)
                put_tag(&w, id++, row, col);
    sheen_json_close(&w);
    sheen_json_open(&w, "corners", '[');
    id = 0;
    for (int row = 1; row < 4; row++)
        for (int col = 1; col < 4; col++) {
            sheen_json_open(&w, NULL, '{');
            sheen_json_put_int(&w, "id", id++);
            sheen_json_put_int(&w, "row", row);
            sheen_json_put_int(&w, "col", col);
            put_point(&w, "p", (col - 2) * 0.03, (2 - row) * 0.03);
            sheen_json_put_bool(&w, "printed", true);
            sheen_json_close(&w);
        }
    sheen_json_close(&w);
    sheen_json_close(&w);
    assert_ok(sheen_json_save(&w, path, &err), err);
}

void fixture_mesh(const char *path, double offset_m)
{
    enum { RINGS = 24, SECTORS = 40 };
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    for (int i = 0; i <= RINGS; i++)
        for (int k = 0; k < SECTORS; k++) {
            const double theta = pi * i / RINGS, phi = 2 * pi * k / SECTORS;
            fprintf(f, "v %.9g %.9g %.9g\n", offset_m + 0.03 * sin(theta) * cos(phi),
                    0.03 * sin(theta) * sin(phi), 0.03 + 0.03 * cos(theta));
        }
    for (int i = 0; i < RINGS; i++)
        for (int k = 0; k < SECTORS; k++) {
            const int a = i * SECTORS + k + 1, b = i * SECTORS + (k + 1) % SECTORS + 1;
            if (i > 0)
                fprintf(f, "f %d %d %d\n", a, a + SECTORS, b);
            if (i < RINGS - 1)
                fprintf(f, "f %d %d %d\n", b, a + SECTORS, b + SECTORS);
        }
    assert_int_equal(fclose(f), 0);
}

void fixture_camera(const char *path, int width_px, int height_px)
{
    char text[400];
    snprintf(text, sizeof text,
             "{\n    'lensmodel':  'LENSMODEL_PINHOLE',\n    'intrinsics': [ %.1f, %.1f, %.1f, %.1f ],\n"
             "    'extrinsics': [ 0, 0, 0, 0, 0, 0 ],\n    'imagersize': [ %d, %d ]\n}\n",
             2.0 * width_px, 2.0 * width_px, (width_px - 1) / 2.0, (height_px - 1) / 2.0, width_px,
             height_px);
    test_file_write_text(path, text);
}

// Camera to world in OpenGL's axes (x right, y up, z back), looking at the ball's centre.
static void look(double m[16], double azimuth_rad)
{
    const double back[3] = {cos(azimuth_rad) * 0.8, sin(azimuth_rad) * 0.8, 0.6};
    const double right[3] = {-sin(azimuth_rad), cos(azimuth_rad), 0};
    const double up[3] = {back[1] * right[2] - back[2] * right[1], back[2] * right[0] - back[0] * right[2],
                          back[0] * right[1] - back[1] * right[0]};
    memset(m, 0, 16 * sizeof *m);
    for (int i = 0; i < 3; i++) {
        m[4 * i] = right[i];
        m[4 * i + 1] = up[i];
        m[4 * i + 2] = back[i];
        m[4 * i + 3] = 0.5 * back[i] + (i == 2 ? 0.03 : 0);
    }
    m[15] = 1;
}

// Few views stand close together, so that they see the same highlights; more go all the way round.
static double azimuth_rad(int i, int n)
{
    return 2 * pi * i / (n < 8 ? 24 : n);
}

void fixture_poses(const char *path, int width_px, int height_px, const char *const *names, int n_names)
{
    sheen_json_writer w = {0};
    sheen_err err;
    sheen_json_open(&w, NULL, '{');
    sheen_json_put_number(&w, "fl_x", 2.0 * width_px);
    sheen_json_put_number(&w, "fl_y", 2.0 * width_px);
    sheen_json_put_number(&w, "cx", width_px / 2.0);
    sheen_json_put_number(&w, "cy", height_px / 2.0);
    sheen_json_put_int(&w, "w", width_px);
    sheen_json_put_int(&w, "h", height_px);
    sheen_json_open(&w, "frames", '[');
    for (int i = 0; i < n_names; i++) {
        char file[128];
        double m[16];
        snprintf(file, sizeof file, "images/%.100s.png", names[i]);
        look(m, azimuth_rad(i, n_names));
        sheen_json_open(&w, NULL, '{');
        sheen_json_put_string(&w, "file_path", file);
        sheen_json_open(&w, "transform_matrix", '[');
        for (int row = 0; row < 4; row++)
            sheen_json_put_numbers(&w, NULL, m + 4 * row, 4);
        sheen_json_close(&w);
        sheen_json_close(&w);
    }
    sheen_json_close(&w);
    sheen_json_close(&w);
    assert_ok(sheen_json_save(&w, path, &err), err);
}

// Light from the ball at a point with unit normal n towards v: stripes, and three lamps of the model that is fitted.
static double shade(const double n[3], const double v[3], int channel)
{
    static const double lamps[3][3] = {{0, 0, 1}, {0.6, 0, 0.8}, {-0.36, 0.48, 0.8}};
    static const double paint[2][3] = {{0.3, 0.1, 0.05}, {0.1, 0.15, 0.25}};
    double light = paint[(int)floor(8 * n[0] + 100) % 2][channel];
    const double n_dot_v = n[0] * v[0] + n[1] * v[1] + n[2] * v[2];
    for (int k = 0; k < 3; k++) {
        double h[3], length = 0, n_dot_h = 0;
        for (int i = 0; i < 3; i++) {
            h[i] = lamps[k][i] + v[i];
            length += h[i] * h[i];
            n_dot_h += n[i] * h[i];
        }
        const double alpha_rad = acos(fmin(1, n_dot_h / sqrt(length)));
        light += 0.2 * exp(-alpha_rad * alpha_rad / (2 * 0.08 * 0.08)) / fmax(n_dot_v, 0.2);
    }
    return light;
}

// Where the ray from p along the unit direction d meets the ball; false where it does not.
static bool hit_ball(double n[3], const double p[3], const double d[3])
{
    const double from[3] = {p[0], p[1], p[2] - 0.03};
    double b = 0, c = -0.03 * 0.03;
    for (int i = 0; i < 3; i++) {
        b += from[i] * d[i];
        c += from[i] * from[i];
    }
    const double root = b * b - c;
    if (root < 0)
        return false;
    for (int i = 0; i < 3; i++)
        n[i] = (from[i] + (-b - sqrt(root)) * d[i]) / 0.03;
    return true;
}

static void draw_pixel(float rgb[3], const double m[16], double x, double y, double f_px)
{
    const double length = sqrt(x * x + y * y + f_px * f_px);
    double d[3], p[3], v[3], n[3];
    for (int i = 0; i < 3; i++) {
        d[i] = (m[4 * i] * x - m[4 * i + 1] * y - m[4 * i + 2] * f_px) / length;
        p[i] = m[4 * i + 3];
        v[i] = -d[i];
    }
    const bool on_ball = hit_ball(n, p, d);
    for (int c = 0; c < 3; c++)
        rgb[c] = on_ball ? (float)shade(n, v, c) : 0.02f;
}

void fixture_shiny(const char *dir, int width_px, int height_px, const char *const *names, int n_names)
{
    sheen_image img;
    sheen_err err;
    assert_ok(sheen_image_init(&img, width_px, height_px, 3, &err), err);
    for (int i = 0; i < n_names; i++) {
        char path[SHEEN_PATH_MAX], file[128];
        double m[16];
        look(m, azimuth_rad(i, n_names));
        for (int y = 0; y < height_px; y++)
            for (int x = 0; x < width_px; x++)
                draw_pixel(sheen_image_at(&img, x, y), m, x - (width_px - 1) / 2.0, y - (height_px - 1) / 2.0,
                           2.0 * width_px);
        snprintf(file, sizeof file, "%.100s.png", names[i]);
        assert_ok(sheen_path_join(path, dir, file, &err), err);
        assert_ok(sheen_png_write_srgb(path, &img, &err), err);
    }
    sheen_image_release(&img);
}

// The figure's balls: centre and radius, metres, on the board.
static const double balls[4][4] = {{0, 0, 0.03, 0.03},
                                   {0.024, 0.008, 0.045, 0.015},
                                   {-0.005, -0.028, 0.02, 0.015},
                                   {0.004, 0.006, 0.066, 0.016}};

void fixture_figure(const char *path, double per_m)
{
    enum { RINGS = 16, SECTORS = 24 };
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    for (int b = 0; b < 4; b++)
        for (int i = 0; i <= RINGS; i++)
            for (int k = 0; k < SECTORS; k++) {
                const double theta = pi * i / RINGS, phi = 2 * pi * k / SECTORS, r = balls[b][3];
                fprintf(f, "v %.9g %.9g %.9g\n", per_m * (balls[b][0] + r * sin(theta) * cos(phi)),
                        per_m * (balls[b][2] + r * cos(theta)),
                        -per_m * (balls[b][1] + r * sin(theta) * sin(phi)));
            }
    for (int b = 0; b < 4; b++)
        for (int i = 0; i < RINGS; i++)
            for (int k = 0; k < SECTORS; k++) {
                const int base = b * (RINGS + 1) * SECTORS + i * SECTORS + 1;
                const int a = base + k, c = base + (k + 1) % SECTORS;
                if (i > 0)
                    fprintf(f, "f %d %d %d\n", a, a + SECTORS, c);
                if (i < RINGS - 1)
                    fprintf(f, "f %d %d %d\n", c, a + SECTORS, c + SECTORS);
            }
    assert_int_equal(fclose(f), 0);
}

// Height of the nearest ball's normal along the line of sight (-1..1); -2 where it meets none.
static double meet_figure(const double eye[3], const double v[3], int n_balls)
{
    double nearest = 1e9, up = -2;
    for (int b = 0; b < n_balls; b++) {
        double d[3], along = 0, d2 = 0;
        for (int c = 0; c < 3; c++) {
            d[c] = balls[b][c] - eye[c];
            along += d[c] * v[c];
            d2 += d[c] * d[c];
        }
        const double inside = balls[b][3] * balls[b][3] - (d2 - along * along);
        if (inside < 0 || along - sqrt(inside) >= nearest)
            continue;
        nearest = along - sqrt(inside);
        up = (nearest * v[2] - d[2]) / balls[b][3];
    }
    return up;
}

static float figure_pixel(const double m[16], double x, double y, double f_px, int mask, int n_balls)
{
    enum { SUB = 4 };
    double sum = 0;
    for (int k = 0; k < SUB * SUB; k++) {
        const double q[3] = {(x + (k % SUB + 0.5) / SUB - 0.5) / f_px,
                             -(y + ((int)(k / SUB) + 0.5) / SUB - 0.5) / f_px, -1};
        const double length = sqrt(q[0] * q[0] + q[1] * q[1] + 1), eye[3] = {m[3], m[7], m[11]};
        double v[3];
        for (int i = 0; i < 3; i++)
            v[i] = (m[4 * i] * q[0] + m[4 * i + 1] * q[1] + m[4 * i + 2] * q[2]) / length;
        const double up = meet_figure(eye, v, n_balls);
        sum += mask ? up > -2 : up > -2 ? 0.1 + 0.05 * up : 0.5;
    }
    return (float)(sum / (SUB * SUB));
}

void fixture_figure_views(const char *dir, int width_px, int height_px, const char *const *names, int n_names,
                          int masks, int n_balls)
{
    sheen_image img;
    sheen_err err;
    assert_ok(sheen_image_init(&img, width_px, height_px, 3, &err), err);
    for (int i = 0; i < n_names; i++) {
        char path[SHEEN_PATH_MAX], file[128];
        double m[16];
        look(m, azimuth_rad(i, n_names));
        for (int y = 0; y < height_px; y++)
            for (int x = 0; x < width_px; x++) {
                const float v = figure_pixel(m, x - (width_px - 1) / 2.0, y - (height_px - 1) / 2.0,
                                             2.0 * width_px, masks, n_balls);
                for (int c = 0; c < 3; c++) // the writer codes light as sRGB; a mask's numbers are shares
                    sheen_image_at(&img, x, y)[c] = masks ? sheen_transfer_decode(SHEEN_TRANSFER_SRGB, v) : v;
            }
        snprintf(file, sizeof file, "%.100s.png", names[i]);
        assert_ok(sheen_path_join(path, dir, file, &err), err);
        assert_ok(sheen_png_write_srgb(path, &img, &err), err);
    }
    sheen_image_release(&img);
}

void fixture_figure_marks(const char *path, int width_px, int height_px, const char *const *names,
                          int n_names, double per_m)
{
    static const double points[6][3] = {{0.004, 0.006, 0.082}, {0.039, 0.008, 0.045}, {-0.005, -0.043, 0.02},
                                        {-0.03, 0, 0.03},      {0, 0.03, 0.03},       {0, 0, 0}};
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    fprintf(f, "# frame x y X Y Z\n");
    for (int i = 0; i < n_names; i++) {
        double m[16];
        look(m, azimuth_rad(i, n_names));
        for (int k = 0; k < 6; k++) {
            double q[3] = {0};
            for (int c = 0; c < 3; c++)
                for (int r = 0; r < 3; r++)
                    q[c] += m[4 * r + c] * (points[k][r] - m[4 * r + 3]);
            fprintf(f, "%s %.3f %.3f %.9g %.9g %.9g\n", names[i],
                    (width_px - 1) / 2.0 - 2.0 * width_px * q[0] / q[2],
                    (height_px - 1) / 2.0 + 2.0 * width_px * q[1] / q[2], per_m * points[k][0],
                    per_m * points[k][2], -per_m * points[k][1]);
        }
    }
    assert_int_equal(fclose(f), 0);
}

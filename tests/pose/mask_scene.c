// SPDX-License-Identifier: Apache-2.0
// mask_scene.c - masks from the ray tracer, with 4 x 4 rays a pixel, borders made to wander.
#include "mask_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "base/vec.h"
#include "pose/pose_tangent.h"
#include "render/gbuffer.h"
#include "support.h"
#include "support_board.h"
#include "support_scene.h"

static const double DEG = 3.14159265358979323846 / 180;

// Smooth noise, sigma 1: white noise on a grid of `pitch` pixels, interpolated.
static double wander(const double *grid, int columns, double x, double y, double pitch)
{
    const double u = x / pitch, v = y / pitch;
    const int i = (int)u, j = (int)v;
    const double a = u - i, b = v - j, *p = grid + (ptrdiff_t)j * columns + i;
    return 1.5 * ((1 - b) * ((1 - a) * p[0] + a * p[1]) + b * ((1 - a) * p[columns] + a * p[columns + 1]));
}

static void draw(mask_scene *scene, size_t v, const sheen_scene *rays, const sheen_mesh *mesh,
                 const double rt_cam_board[6], const mask_scene_options *o, uint64_t *seed)
{
    enum { SUB = 4, PITCH = 10 };
    sheen_err err;
    sheen_gbuffer g;
    const int columns = o->width_px / PITCH + 3, rows = o->height_px / PITCH + 3;
    double *grids = malloc(2 * (size_t)(columns * rows) * sizeof *grids);
    assert_non_null(grids);
    for (int i = 0; i < 2 * columns * rows; i++)
        grids[i] = o->mask_noise_px * test_random_normal(seed);
    assert_ok(sheen_gbuffer_make(&g, rays, mesh, &scene->camera, rt_cam_board, SUB, 1, &err), err);
    assert_ok(sheen_image_init(&scene->masks[v], o->width_px, o->height_px, 1, &err), err);
    if (o->with_pictures)
        assert_ok(sheen_image_init(&scene->pictures[v], o->width_px, o->height_px, 1, &err), err);
    for (int y = 0; y < o->height_px; y++)
        for (int x = 0; x < o->width_px; x++) {
            double share = 0, shade = 0;
            for (int k = 0; k < SUB * SUB; k++) {
                double qx = (x - g.x0_px) * SUB + k % SUB, qy = (y - g.y0_px) * SUB + k / SUB;
                const int plain_x = (int)qx, plain_y = (int)qy;
                if (o->mask_noise_px > 0) {
                    qx += SUB * wander(grids, columns, x, y, PITCH);
                    qy += SUB * wander(grids + columns * rows, columns, x, y, PITCH);
                }
                const int i = (int)lrint(qx), j = (int)lrint(qy), w = g.width_px * SUB, h = g.height_px * SUB;
                share += i >= 0 && j >= 0 && i < w && j < h && g.hits[j * w + i].triangle != SHEEN_NO_HIT;
                float n[3] = {0, 0, 0};
                const bool seen = plain_x >= 0 && plain_y >= 0 && plain_x < w && plain_y < h &&
                                  g.hits[plain_y * w + plain_x].triangle != SHEEN_NO_HIT;
                if (seen)
                    sheen_hit_surface(mesh, &g.hits[plain_y * w + plain_x], g.p_camera_obj, NULL, n, NULL);
                shade += seen ? 0.15 + 0.1 * (double)n[2] : 0.55;
            }
            *sheen_image_at(&scene->masks[v], x, y) = (float)(rint(255 * share / (SUB * SUB)) / 255);
            if (o->with_pictures)
                *sheen_image_at(&scene->pictures[v], x,
                                y) = (float)(shade / (SUB * SUB) + 0.01 * test_random_normal(seed));
        }
    sheen_gbuffer_release(&g);
    free(grids);
}

void mask_scene_make(mask_scene *scene, const sheen_mesh *mesh, const mask_scene_options *o)
{
    sheen_err err;
    sheen_scene *rays;
    uint64_t seed = o->seed;
    const double f = 1.15 * o->width_px, k[4] = {-0.12, 0.05, 0.0008, -0.0006};
    *scene = (mask_scene){.n_views = o->n_views};
    assert_ok(sheen_camera_opencv(&scene->camera, o->width_px, o->height_px,
                                  (const double[4]){f, f * 1.002, 0.505 * o->width_px, 0.49 * o->height_px},
                                  k, 4, &err),
              err);
    assert_ok(sheen_scene_new(&rays, mesh, &err), err);
    for (size_t v = 0; v < o->n_views; v++) {
        double rt[6], wd[6];
        sheen_Rt Rt;
        test_board_look(rt, (const double[2]){0.01 * test_random(&seed), 0.01 * test_random(&seed)},
                        o->distance_m * (0.9 + 0.2 * test_random(&seed)), 30 + 35 * test_random(&seed),
                        360.0 * (double)v / (double)o->n_views + 20 * test_random(&seed),
                        10 * test_random_normal(&seed));
        draw(scene, v, rays, mesh, rt, o, &seed);
        for (int i = 0; i < 6; i++)
            wd[i] = o->pose_noise * test_random_normal(&seed) * (i < 3 ? 0.01 * DEG : 0.02e-3);
        sheen_Rt_from_rt(&Rt, rt);
        sheen_pose_move(&Rt, &Rt, wd);
        sheen_rt_from_Rt(scene->views[v].rt_cam_board, &Rt);
        scene->views[v].mask = &scene->masks[v];
        scene->views[v].light = o->with_pictures ? &scene->pictures[v] : NULL;
    }
    sheen_scene_free(&rays);
}

void mask_scene_release(mask_scene *scene)
{
    for (size_t v = 0; v < scene->n_views; v++) {
        sheen_image_release(&scene->masks[v]);
        sheen_image_release(&scene->pictures[v]);
    }
}

static void set_down(sheen_mesh *mesh)
{
    float low[3], high[3];
    sheen_mesh_bounds(mesh, low, high);
    for (size_t i = 0; i < mesh->n_vertices; i++)
        mesh->p_obj[3 * i + 2] -= low[2];
    sheen_mesh_compute_normals(mesh);
}

void mask_scene_figure(sheen_mesh *mesh)
{
    test_sphere(mesh, 24, (const float[3]){0, 0, 0}, 1);
    for (size_t i = 0; i < mesh->n_vertices; i++) {
        float *p = mesh->p_obj + 3 * i;
        const double x = (double)p[0], y = (double)p[1], z = (double)p[2];
        const double arm = 0.6 *
                           exp(-12 * ((x - 0.8) * (x - 0.8) + (y - 0.3) * (y - 0.3) + (z - 0.4) * (z - 0.4)));
        const double nose = 0.4 * exp(-20 * (x * x + (y + 0.9) * (y + 0.9) + (z - 0.5) * (z - 0.5)));
        const double r = 1 + 0.12 * sin(2.3 * z + 1.5 * x) + arm + nose + 0.1 * x * y;
        p[0] = (float)(0.036 * r * x);
        p[1] = (float)(0.030 * r * y);
        p[2] = (float)(0.055 * r * z);
    }
    set_down(mesh);
}

void mask_scene_block(sheen_mesh *mesh)
{
    test_sphere(mesh, 40, (const float[3]){0, 0, 0}, 1);
    for (size_t i = 0; i < mesh->n_vertices; i++) {
        static const double half_m[3] = {0.05, 0.03, 0.04};
        float *p = mesh->p_obj + 3 * i;
        const double corner = exp(
            -6 * (pow((double)p[0] - 0.6, 2) + pow((double)p[1] - 0.6, 2) + pow((double)p[2] - 0.5, 2)));
        for (int c = 0; c < 3; c++)
            p[c] = (float)(half_m[c] * copysign(pow(fabs((double)p[c]), 0.35), (double)p[c]) *
                           (1 + 0.35 * corner));
    }
    set_down(mesh);
}

static void widen(sheen_image *mask)
{
    sheen_image narrow = *mask;
    const int w = mask->width_px, h = mask->height_px;
    narrow.data = malloc((size_t)(w * h) * sizeof *narrow.data);
    assert_non_null(narrow.data);
    memcpy(narrow.data, mask->data, (size_t)(w * h) * sizeof *narrow.data);
    for (int y = 1; y < h - 1; y++)
        for (int x = 1; x < w - 1; x++)
            for (int k = -1; k <= 1; k += 2) {
                float *m = sheen_image_at(mask, x, y);
                *m = fmaxf(*m, fmaxf(*sheen_image_at(&narrow, x + k, y), *sheen_image_at(&narrow, x, y + k)));
            }
    free(narrow.data);
}

// A disc about a place on the border that is drawn at random becomes empty.
static void bite(sheen_image *mask, uint64_t *seed)
{
    const int w = mask->width_px, h = mask->height_px;
    int at[2] = {0, 0}, n = 0;
    double area = 0;
    for (int y = 0; y < h; y++)
        for (int x = 1; x < w; x++) {
            const float m = *sheen_image_at(mask, x, y), before = *sheen_image_at(mask, x - 1, y);
            area += (double)m;
            if ((m >= 0.5f) != (before >= 0.5f) && test_random(seed) * ++n < 1) {
                at[0] = x;
                at[1] = y;
            }
        }
    const double radius_px = 0.1 * sqrt(area);
    for (int y = 0; y < h; y++)
        for (int x = 0; x < w; x++)
            if (hypot(x - at[0], y - at[1]) < radius_px)
                *sheen_image_at(mask, x, y) = 0;
}

// A disc of 25 mm radius on the ground, 30 mm from the origin.
static void shadow(sheen_image *mask, const sheen_camera *camera, const double rt_cam_board[6],
                   const double xy_m[2])
{
    enum { RINGS = 60, TURNS = 240 };
    for (int i = 1; i <= RINGS; i++)
        for (int j = 0; j < TURNS; j++) {
            const double r = 0.025 * i / RINGS, a = 360 * DEG * j / TURNS;
            double q[2];
            test_board_project(q, camera, rt_cam_board,
                               (const double[3]){xy_m[0] + r * cos(a), xy_m[1] + r * sin(a), 0});
            const int x = (int)lrint(q[0]), y = (int)lrint(q[1]);
            if (x >= 0 && y >= 0 && x < mask->width_px && y < mask->height_px)
                *sheen_image_at(mask, x, y) = 1;
        }
}

void mask_scene_spoil(mask_scene *scene, mask_scene_fault fault, uint64_t *seed)
{
    const double a = 360 * DEG * test_random(seed), xy_m[2] = {0.03 * cos(a), 0.03 * sin(a)};
    for (size_t v = 0; v < scene->n_views; v++) {
        if (fault == MASK_SCENE_WIDER)
            widen(&scene->masks[v]);
        else if (fault == MASK_SCENE_BITTEN)
            bite(&scene->masks[v], seed);
        else
            shadow(&scene->masks[v], &scene->camera, scene->views[v].rt_cam_board, xy_m);
    }
}

void mask_scene_bottle(sheen_mesh *mesh)
{
    test_sphere(mesh, 24, (const float[3]){0, 0, 0}, 1);
    for (size_t i = 0; i < mesh->n_vertices; i++) {
        float *p = mesh->p_obj + 3 * i;
        const double z = (double)p[2], r = 0.03 * (1 + 0.3 * sin(3 * z));
        p[0] = (float)(r * (double)p[0]);
        p[1] = (float)(r * (double)p[1]);
        p[2] = (float)(0.06 * z);
    }
    set_down(mesh);
}

bool mask_scene_print(float rgb[3], const sheen_board *b, double x_m, double y_m)
{
    const double u = x_m / b->square_m + 0.5 * b->n_cols, v = 0.5 * b->n_rows - y_m / b->square_m;
    static const float white[3] = {0.72f, 0.70f, 0.66f}, black[3] = {0.035f, 0.035f, 0.04f};
    if (!(u > 0 && v > 0 && u < b->n_cols && v < b->n_rows))
        return false;
    const double from_middle_m = b->square_m * fmax(fabs(u - floor(u) - 0.5), fabs(v - floor(v) - 0.5));
    const bool is_white = ((int)u + (int)v) % 2 == 1 && from_middle_m > 0.5 * b->tag_side_m;
    memcpy(rgb, is_white || hypot(x_m, y_m) < b->blank_radius_m ? white : black, 3 * sizeof *rgb);
    return true;
}

void mask_scene_move(sheen_mesh *out, const sheen_mesh *mesh, const double rt_board_obj[6], double unit_m)
{
    sheen_Rt Rt;
    *out = *mesh;
    sheen_Rt_from_rt(&Rt, rt_board_obj);
    sheen_Rt_invert(&Rt, &Rt);
    out->p_obj = malloc(3 * mesh->n_vertices * sizeof *out->p_obj);
    out->n_obj = malloc(3 * mesh->n_vertices * sizeof *out->n_obj);
    out->triangles = malloc(3 * mesh->n_triangles * sizeof *out->triangles);
    assert_true(out->p_obj && out->n_obj && out->triangles);
    memcpy(out->triangles, mesh->triangles, 3 * mesh->n_triangles * sizeof *out->triangles);
    for (size_t i = 0; i < mesh->n_vertices; i++) {
        double p[3];
        for (size_t c = 0; c < 3; c++)
            p[c] = (double)mesh->p_obj[3 * i + c];
        sheen_Rt_point(p, &Rt, p);
        for (size_t c = 0; c < 3; c++)
            out->p_obj[3 * i + c] = (float)(p[c] / unit_m);
    }
    sheen_mesh_compute_normals(out);
}

void mask_scene_error(double *distance_m, double *angle_rad, const sheen_placement *placement,
                      const double rt_board_obj[6], double unit_m, const sheen_mesh *mesh)
{
    sheen_Rt back, true_Rt;
    double wd[6];
    sheen_Rt_from_rt(&true_Rt, rt_board_obj);
    sheen_Rt_invert(&back, &true_Rt);
    sheen_pose_difference(wd, &placement->Rt_board_obj, &true_Rt);
    *angle_rad = sheen_norm(wd);
    *distance_m = 0;
    for (size_t i = 0; i < mesh->n_vertices; i++) {
        double p[3], q[3], d[3];
        for (size_t c = 0; c < 3; c++)
            p[c] = (double)mesh->p_obj[3 * i + c];
        sheen_Rt_point(q, &back, p);
        for (int c = 0; c < 3; c++)
            q[c] *= placement->scale / unit_m;
        sheen_Rt_point(q, &placement->Rt_board_obj, q);
        sheen_sub(d, q, p);
        *distance_m = fmax(*distance_m, sheen_norm(d));
    }
}

// SPDX-License-Identifier: Apache-2.0
// slow_background_masks.c - a whole turntable session in pictures, and one frame of it without the object: masks against the truth.
//
// Camera, lamp and surroundings stand still; board, plate and object turn about one axis. The object shades itself and throws its
// shadow on board, plate and table. Overlap is intersection over union of the mask with the pixels that the object covers
// by half or more.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "base/vec.h"
#include "mask_scene.h"
#include "pose/board_masks.h"
#include "render/gbuffer.h"
#include "support.h"
#include "support_board.h"

enum { STEPS = 8, SUB = 3 };

static const double pi = 3.14159265358979323846;
static const double plate_m = 0.16; // radius

typedef struct look {
    const char *name;
    float rgb[3];
    double size;  // of the figure of 0.12 m
    double least; // overlap of all views together
} look;

typedef struct studio {
    sheen_camera camera;
    sheen_board board;
    sheen_mesh mesh;
    sheen_scene *rays;
    double rt_cam_table[6];
    sheen_image photos[STEPS + 1], truth[STEPS], masks[STEPS]; // the last photo: the empty table
    sheen_plane_view views[STEPS + 1];
} studio;

static float sunlight(const studio *s, const float p_board[3], const float n[3], const float sun_board[3],
                      bool with_object)
{
    float target[3], from[3];
    uint8_t hidden = 0;
    for (int k = 0; k < 3; k++) {
        from[k] = p_board[k] + 2e-4f * n[k];
        target[k] = from[k] + 2 * sun_board[k];
    }
    const float cosine = sheen_dotf(n, sun_board);
    if (with_object && cosine > 0)
        sheen_scene_occluded(s->rays, &hidden, from, 1, target, 1e-5f);
    return hidden || cosine < 0 ? 0 : cosine;
}

// What is behind the object: print, the plate that turns with it, cloth on the table, and the room's wall.
static void paint_behind(float rgb[3], const studio *s, const double p_board[2], double turn, bool on_plane,
                         const double q_px[2])
{
    const double x = cos(turn) * p_board[0] - sin(turn) * p_board[1],
                 y = sin(turn) * p_board[0] + cos(turn) * p_board[1];
    float grey = (float)(0.3 + 0.1 * sin(0.06 * q_px[0]) * sin(0.05 * q_px[1]));
    const float wall[3] = {grey, 0.95f * grey, 0.8f * grey};
    memcpy(rgb, wall, sizeof wall);
    if (!on_plane || mask_scene_print(rgb, &s->board, p_board[0], p_board[1]))
        return;
    grey = hypot(x, y) < plate_m ? 0.1f : (float)(0.25 + 0.04 * sin(90 * x) * sin(70 * y));
    const float cloth[3] = {0.8f * grey, grey, 0.9f * grey};
    memcpy(rgb, cloth, sizeof cloth);
}

static void shade_place(float rgb[3], const studio *s, const look *l, const sheen_hit *hit,
                        const sheen_gbuffer *g, const sheen_Rt *Rt_board_cam, double turn,
                        const double q_px[2])
{
    const float sun[3] = {(float)(0.5 * cos(turn) + 0.4 * sin(turn)),
                          (float)(-0.5 * sin(turn) + 0.4 * cos(turn)), 0.76811f};
    float p[3], n[3] = {0, 0, 1}, v[3];
    if (hit && hit->triangle != SHEEN_NO_HIT) {
        sheen_hit_surface(&s->mesh, hit, g->p_camera_obj, p, n, v);
        const float light = 0.35f + 0.15f * n[2] + 0.6f * sunlight(s, p, n, sun, true);
        for (int c = 0; c < 3; c++)
            rgb[c] = light * l->rgb[c];
        return;
    }
    double d[3], p_m[2];
    sheen_err err;
    assert_ok(sheen_camera_unproject(&s->camera, d, q_px, 1, &err), err);
    sheen_Rt_direction(d, Rt_board_cam, d);
    const double t = -Rt_board_cam->t[2] / d[2];
    const bool on_plane = t > 0 && t < 1.1;
    for (int k = 0; k < 2; k++)
        p_m[k] = Rt_board_cam->t[k] + t * d[k];
    paint_behind(rgb, s, p_m, turn, on_plane, q_px);
    const float place[3] = {(float)p_m[0], (float)p_m[1], 0};
    const float light = on_plane ? 0.5f + 0.6f * sunlight(s, place, n, sun, l != NULL) : 0.8f;
    for (int c = 0; c < 3; c++)
        rgb[c] *= light;
}

// l NULL: without the object.
static void photograph(studio *s, size_t i, const look *l, double turn, uint64_t *seed)
{
    sheen_err err;
    sheen_gbuffer g = {0};
    sheen_Rt Rt_cam_board, Rt_board_cam;
    sheen_image *photo = &s->photos[i];
    const double rt_table_board[6] = {0, 0, turn, 0, 0, 0};
    double *rt = s->views[i].rt_cam_board;
    sheen_rt_compose(rt, s->rt_cam_table, rt_table_board);
    s->views[i].rgb = photo;
    sheen_Rt_from_rt(&Rt_cam_board, rt);
    sheen_Rt_invert(&Rt_board_cam, &Rt_cam_board);
    assert_ok(sheen_image_init(photo, s->camera.width_px, s->camera.height_px, 3, &err), err);
    if (l) {
        assert_ok(sheen_gbuffer_make(&g, s->rays, &s->mesh, &s->camera, rt, SUB, 1, &err), err);
        assert_ok(sheen_image_init(&s->truth[i], s->camera.width_px, s->camera.height_px, 1, &err), err);
    }
    for (int y = 0; y < s->camera.height_px; y++)
        for (int x = 0; x < s->camera.width_px; x++) {
            float *rgb = sheen_image_at(photo, x, y);
            const bool beside = !l || x < g.x0_px || y < g.y0_px || x >= g.x0_px + g.width_px ||
                                y >= g.y0_px + g.height_px;
            const int n = beside ? 1 : SUB; // the ground behind it is smooth or is seen plainly enough
            for (int k = 0; k < n * n; k++) {
                const double q_px[2] = {x + (k % n + 0.5) / n - 0.5, y + (k / n + 0.5) / n - 0.5};
                const int gx = (x - g.x0_px) * SUB + k % SUB, gy = (y - g.y0_px) * SUB + k / SUB;
                const bool in = l && x >= g.x0_px && y >= g.y0_px && gx < g.width_px * SUB &&
                                gy < g.height_px * SUB;
                const sheen_hit *hit = in ? &g.hits[(size_t)gy * (size_t)(g.width_px * SUB) + (size_t)gx]
                                          : NULL;
                float place[3];
                shade_place(place, s, l, hit, &g, &Rt_board_cam, turn, q_px);
                for (int c = 0; c < 3; c++)
                    rgb[c] += place[c] / (float)(n * n);
                if (hit && hit->triangle != SHEEN_NO_HIT)
                    *sheen_image_at(&s->truth[i], x, y) += 1.0f / (SUB * SUB);
            }
            for (int c = 0; c < 3; c++)
                rgb[c] = fminf(1, fmaxf(0, rgb[c] + 0.004f * (float)test_random_normal(seed)));
        }
    sheen_gbuffer_release(&g);
}

static void set_up(studio *s, const look *l)
{
    const sheen_board_layout layout = {
        .n_cols = 9, .n_rows = 8, .square_m = 0.024, .tag_side_m = 0.017, .blank_radius_m = 0.03};
    const double f = 540, k[4] = {-0.1, 0.04, 0.0008, -0.0006};
    uint64_t seed = 5;
    sheen_err err;
    memset(s, 0, sizeof *s);
    assert_ok(sheen_camera_opencv(&s->camera, 480, 360, (const double[4]){f, f, 238, 181}, k, 4, &err), err);
    assert_ok(sheen_board_make(&s->board, &layout, &err), err);
    mask_scene_figure(&s->mesh);
    for (size_t i = 0; i < 3 * s->mesh.n_vertices; i++)
        s->mesh.p_obj[i] *= (float)l->size;
    assert_ok(sheen_scene_new(&s->rays, &s->mesh, &err), err);
    test_board_look(s->rt_cam_table, (const double[2]){0, 0.02}, 0.55, 55, 70, 0);
    for (size_t i = 0; i < STEPS; i++)
        photograph(s, i, l, 2 * pi * (double)i / STEPS, &seed);
    photograph(s, STEPS, NULL, 0, &seed);
    for (size_t i = 0; i < STEPS; i++)
        s->views[i].empty = &s->views[STEPS];
}

static void tear_down(studio *s)
{
    for (size_t i = 0; i <= STEPS; i++)
        sheen_image_release(&s->photos[i]);
    for (size_t i = 0; i < STEPS; i++) {
        sheen_image_release(&s->truth[i]);
        sheen_image_release(&s->masks[i]);
    }
    sheen_board_release(&s->board);
    sheen_scene_free(&s->rays);
    sheen_mesh_release(&s->mesh);
}

static double overlap(double *right, const studio *s, size_t first, size_t last)
{
    size_t both = 0, either = 0, told = 0, n_right = 0;
    for (size_t v = first; v < last; v++)
        for (size_t i = 0; i < (size_t)s->camera.width_px * (size_t)s->camera.height_px; i++) {
            const bool truth = s->truth[v].data[i] >= 0.5f, mask = s->masks[v].data[i] > 0.5f;
            both += truth && mask;
            either += truth || mask;
            told += isnan(s->masks[v].data[i]) ? 0 : 1;
            n_right += !isnan(s->masks[v].data[i]) && truth == mask ? 1 : 0;
        }
    *right = (double)n_right / (double)told;
    return (double)both / (double)either;
}

static void masks_are_the_object(void **state)
{
    static const look looks[] = {
        {"terracotta", {0.7f, 0.3f, 0.08f}, 1, 0.97},
        {"blue, half the size", {0.12f, 0.25f, 0.6f}, 0.5, 0.97},
        {"pale green", {0.45f, 0.65f, 0.4f}, 0.8, 0.97},
        {"dark red", {0.15f, 0.02f, 0.03f}, 0.7, 0.97},
        // Here the board hidden looks as the object does, in the light or in a shadow
        {"white as the paper", {0.72f, 0.70f, 0.66f}, 0.9, 0.5},
        {"grey", {0.25f, 0.25f, 0.25f}, 0.6, 0.94}};
    (void)state;
    for (size_t k = 0; k < sizeof looks / sizeof *looks; k++) {
        studio s;
        sheen_err err;
        double right;
        set_up(&s, &looks[k]);
        assert_ok(sheen_board_masks_make(s.masks, &s.camera, &s.board, s.views, STEPS, true, 2, &err), err);
        const double all = overlap(&right, &s, 0, STEPS);
        print_message("%s: overlap %.3f; %.2f %% of what is told is right\n", looks[k].name, all,
                      100 * right);
        assert_true(all > looks[k].least);
        assert_true(right > 0.95);
        tear_down(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(masks_are_the_object)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

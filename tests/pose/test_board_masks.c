// SPDX-License-Identifier: Apache-2.0
// test_board_masks.c - an object photographed on a board on a table, without masks: what hides the board is the object.
#include "pose/board_masks.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "mask_scene.h"
#include "support.h"

static const double DEG = 3.14159265358979323846 / 180;

typedef struct studio {
    mask_scene scene;
    sheen_mesh mesh;
    sheen_board board;
    sheen_image photos[MASK_SCENE_MAX_VIEWS];
    sheen_plane_view views[MASK_SCENE_MAX_VIEWS];
    sheen_image masks[MASK_SCENE_MAX_VIEWS];
    sheen_image empty; // of a turned board: the same without the object, the board as in the first view
    sheen_plane_view empty_view; // its own
    bool turned;                 // under lights that stand still as the camera does
} studio;

// Shade of the plane's light, a shadow and a lamp nearer to one side, at a place seen from the camera's side of the board.
static float light_at(double x_m, double y_m)
{
    const double lamp = 1 + 1.2 * x_m;
    return (float)(hypot(x_m - 0.03, y_m + 0.02) < 0.06 ? 0.6 * lamp : lamp);
}

// The light of the plane at a place: the print with black squares for tags, a table with a pattern. turn_rad: of the
// light's frame in the board's.
static void paint_plane(float rgb[3], const sheen_board *b, double turn_rad, double x_m, double y_m)
{
    if (!mask_scene_print(rgb, b, x_m, y_m)) {
        const float wood = (float)(0.2 + 0.05 * sin(300 * x_m) * sin(60 * y_m));
        memcpy(rgb, (const float[3]){1.3f * wood, wood, 0.7f * wood}, 3 * sizeof *rgb);
        return;
    }
    const float light = light_at(cos(turn_rad) * x_m + sin(turn_rad) * y_m,
                                 cos(turn_rad) * y_m - sin(turn_rad) * x_m);
    for (int c = 0; c < 3; c++)
        rgb[c] *= light;
}

// What a camera that stands still sees beyond a board that turns: table, and a room with a bright window.
static void paint_room(float rgb[3], int x, int y)
{
    const float light = y < 60 && x > 250 ? 0.8f : (float)(0.25 + 0.1 * sin(0.05 * x) * sin(0.07 * y));
    memcpy(rgb, (const float[3]){1.1f * light, light, 0.8f * light}, 3 * sizeof *rgb);
}

static bool is_on_board(const sheen_board *b, double x_m, double y_m)
{
    return fabs(x_m) < 0.5 * b->n_cols * b->square_m && fabs(y_m) < 0.5 * b->n_rows * b->square_m;
}

// One photograph at its own exposure, with noise; beyond the horizon a room that is another one from each side, or (of a
// board that turns) the same from all. object_rgb NULL: without the object.
static void photograph(studio *s, sheen_image *photo, size_t view, const float *object_rgb, uint64_t *seed)
{
    const sheen_camera *cam = &s->scene.camera;
    sheen_err err;
    sheen_Rt Rt_cam_board, Rt_board_cam;
    assert_ok(sheen_image_init(photo, cam->width_px, cam->height_px, 3, &err), err);
    sheen_Rt_from_rt(&Rt_cam_board, s->scene.views[view].rt_cam_board);
    sheen_Rt_invert(&Rt_board_cam, &Rt_cam_board);
    const double gain = 0.85 + 0.3 * test_random(seed), room = test_random(seed);
    const double turn_rad = s->turned ? atan2(Rt_board_cam.t[1], Rt_board_cam.t[0]) : 0;
    for (int y = 0; y < cam->height_px; y++)
        for (int x = 0; x < cam->width_px; x++) {
            float *rgb = sheen_image_at(photo, x, y), plane[3];
            const float cover = object_rgb ? *sheen_image_at(&s->scene.masks[view], x, y) : 0,
                        shade = *sheen_image_at(&s->scene.pictures[view], x, y);
            double d[3];
            assert_ok(sheen_camera_unproject(cam, d, (const double[2]){x, y}, 1, &err), err);
            sheen_Rt_direction(d, &Rt_board_cam, d);
            const double t = -Rt_board_cam.t[2] / d[2];
            const double p_m[2] = {Rt_board_cam.t[0] + t * d[0], Rt_board_cam.t[1] + t * d[1]};
            if (s->turned && !(t > 0 && is_on_board(&s->board, p_m[0], p_m[1])))
                paint_room(plane, x, y);
            else if (t > 0 && t < 3)
                paint_plane(plane, &s->board, turn_rad, p_m[0], p_m[1]);
            else
                plane[0] = plane[1] = plane[2] = (float)(0.1 + 0.5 * room);
            for (int c = 0; c < 3; c++) {
                const double light = gain * (double)(cover > 0 ? cover * shade * object_rgb[c] +
                                                                     (1 - cover) * plane[c]
                                                               : plane[c]);
                rgb[c] = (float)fmin(1, fmax(0, light + 0.004 * test_random_normal(seed)));
            }
        }
}

static void place_view(sheen_plane_view *out, const studio *s, const sheen_image *photo, size_t view)
{
    *out = (sheen_plane_view){.rgb = photo};
    memcpy(out->rt_cam_board, s->scene.views[view].rt_cam_board, sizeof out->rt_cam_board);
}

static void set_up(studio *s, const float object_rgb[3], bool turned)
{
    const sheen_board_layout layout = {.n_cols = turned ? 8 : 12, // with room to see about it
                                       .n_rows = turned ? 7 : 9,
                                       .square_m = 0.025,
                                       .tag_side_m = 0.018,
                                       .blank_radius_m = 0.03};
    static const mask_scene_options options = {
        .width_px = 400, .height_px = 300, .n_views = 6, .distance_m = 0.42, .with_pictures = 1, .seed = 7};
    uint64_t seed = 11;
    sheen_err err;
    memset(s, 0, sizeof *s);
    s->turned = turned;
    mask_scene_figure(&s->mesh);
    mask_scene_make(&s->scene, &s->mesh, &options);
    assert_ok(sheen_board_make(&s->board, &layout, &err), err);
    for (size_t v = 0; v < s->scene.n_views; v++) {
        photograph(s, &s->photos[v], v, object_rgb, &seed);
        place_view(&s->views[v], s, &s->photos[v], v);
    }
    photograph(s, &s->empty, 0, NULL, &seed);
    place_view(&s->empty_view, s, &s->empty, 0);
}

static void tear_down(studio *s)
{
    for (size_t v = 0; v < s->scene.n_views; v++) {
        sheen_image_release(&s->photos[v]);
        sheen_image_release(&s->masks[v]);
    }
    sheen_image_release(&s->empty);
    sheen_board_release(&s->board);
    mask_scene_release(&s->scene);
    sheen_mesh_release(&s->mesh);
}

// Of the pixels that are told, the share that is told right; of the object's, the share that is told at all.
static void judge(double *right, double *told, const studio *s)
{
    size_t n = 0, n_right = 0, n_object = 0, n_told = 0;
    for (size_t v = 0; v < s->scene.n_views; v++)
        for (size_t i = 0; i < (size_t)s->masks[v].width_px * (size_t)s->masks[v].height_px; i++) {
            const float truth = s->scene.masks[v].data[i], mask = s->masks[v].data[i];
            n_object += truth > 0.5f;
            n_told += truth > 0.5f && mask > 0.5f;
            if (isnan(mask))
                continue;
            n++;
            n_right += (truth > 0.5f) == (mask > 0.5f);
        }
    *right = (double)n_right / (double)n;
    *told = (double)n_told / (double)n_object;
}

// Masks of a studio, and the mesh placed by them.
static void place_by_masks(studio *s, const char *name, double least_told)
{
    sheen_err err;
    sheen_register_view views[MASK_SCENE_MAX_VIEWS];
    sheen_registration r;
    double right, told, m, rad;
    assert_ok(sheen_board_masks_make(s->masks, &s->scene.camera, &s->board, s->views, s->scene.n_views,
                                     s->turned, 2, &err),
              err);
    judge(&right, &told, s);
    for (size_t v = 0; v < s->scene.n_views; v++) {
        views[v] = s->scene.views[v];
        views[v].mask = &s->masks[v];
    }
    const sheen_register_options o = {.unit_m = 1, .ups = SHEEN_UP_Z, .rough_masks = true};
    assert_ok(sheen_register_search(&r, &s->mesh, &s->scene.camera, views, s->scene.n_views, &o, &err), err);
    mask_scene_error(&m, &rad, &r.placement, (const double[6]){0}, 1, &s->mesh);
    print_message("%s: %.2f %% of what is told is right, %.0f %% of the object is told; placed to %.2f mm, "
                  "%.2f degrees\n",
                  name, 100 * right, 100 * told, 1e3 * m, rad / DEG);
    assert_true(right > 0.98);
    assert_true(told > least_told);
    assert_true(r.state == SHEEN_REGISTER_SURE ||
                told < 0.12);               // of a tenth of the object it may say that it is not sure
    assert_true(m < 1e-3 && rad < 1 * DEG); // of pictures of a tenth of a megapixel
}

static void what_hides_the_board_is_the_object(void **state)
{
    (void)state;
    static const float colour[3] = {0.7f, 0.3f, 0.08f};
    studio s;
    set_up(&s, colour, false);
    place_by_masks(&s, "camera in the hand", 0.15);
    tear_down(&s);
}

// The shadow and the lamp's bright side wander over the board as it turns: they are not the object.
static void a_shadow_that_wanders_is_not_the_object(void **state)
{
    (void)state;
    static const float colour[3] = {0.7f, 0.3f, 0.08f};
    studio s;
    set_up(&s, colour, true);
    place_by_masks(&s, "turntable", 0.08);
    tear_down(&s);
}

// One picture without the object tells what hides table and room, wherever the board lay in it.
static void what_hides_the_room_is_the_object_too(void **state)
{
    (void)state;
    static const float colour[3] = {0.7f, 0.3f, 0.08f};
    studio s;
    set_up(&s, colour, true);
    for (size_t v = 0; v < s.scene.n_views; v++)
        s.views[v].empty = &s.empty_view;
    place_by_masks(&s, "turntable with a background", 0.3);
    tear_down(&s);
}

// White as the paper: where it stands before paper nothing can be told, and that is what is said.
static void what_looks_like_the_board_is_not_told(void **state)
{
    (void)state;
    static const float paper[3] = {0.72f, 0.70f, 0.66f};
    studio s;
    sheen_err err;
    double right, told;
    set_up(&s, paper, false);
    assert_ok(
        sheen_board_masks_make(s.masks, &s.scene.camera, &s.board, s.views, s.scene.n_views, false, 1, &err),
        err);
    judge(&right, &told, &s);
    print_message("white object: %.2f %% of what is told is right, %.0f %% of the object is told\n",
                  100 * right, 100 * told);
    assert_true(right > 0.95);
    tear_down(&s);
}

static void threads_change_nothing(void **state)
{
    (void)state;
    static const float blue[3] = {0.12f, 0.25f, 0.6f};
    studio s;
    sheen_err err;
    sheen_image again[MASK_SCENE_MAX_VIEWS];
    set_up(&s, blue, false);
    assert_ok(sheen_board_masks_make(s.masks, &s.scene.camera, &s.board, s.views, 4, false, 1, &err), err);
    assert_ok(sheen_board_masks_make(again, &s.scene.camera, &s.board, s.views, 4, false, 3, &err), err);
    for (size_t v = 0; v < 4; v++) {
        assert_memory_equal(again[v].data, s.masks[v].data, 400 * 300 * sizeof(float));
        sheen_image_release(&again[v]);
    }
    tear_down(&s);
}

static void says_what_is_missing(void **state)
{
    (void)state;
    static const float blue[3] = {0.12f, 0.25f, 0.6f};
    studio s;
    sheen_err err;
    set_up(&s, blue, false);
    assert_fails(sheen_board_masks_make(s.masks, &s.scene.camera, &s.board, s.views, 2, false, 1, &err), err,
                 SHEEN_EDATA, "three photographs");
    // Poses of another board: half a square aside.
    sheen_board other;
    static const sheen_board_layout layout = {
        .n_cols = 11, .n_rows = 9, .square_m = 0.025, .tag_side_m = 0.001};
    assert_ok(sheen_board_make(&other, &layout, &err), err);
    assert_fails(
        sheen_board_masks_make(s.masks, &s.scene.camera, &other, s.views, s.scene.n_views, false, 1, &err),
        err, SHEEN_EDATA, "do not agree on the board");
    assert_null(s.masks[0].data);
    sheen_board_release(&other);
    tear_down(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_hides_the_board_is_the_object),
        cmocka_unit_test(a_shadow_that_wanders_is_not_the_object),
        cmocka_unit_test(what_hides_the_room_is_the_object_too),
        cmocka_unit_test(what_looks_like_the_board_is_not_told),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(says_what_is_missing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// SPDX-License-Identifier: Apache-2.0
// make_turn.c - what a camera sees of a turning table, as a session:
//
//     make_turn SESSION WIDTH HEIGHT PICTURES [ELEVATION_DEG]
//
// A figure on a board of tags under three lamps that stand still, every 360 / PICTURES degrees, as JPEG; with camera model,
// board and mesh. Picture k shows the table turned by k steps counter-clockwise, seen from above.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/image_file.h"
#include "base/pose3.h"
#include "base/session.h"
#include "base/vec.h"
#include "render/draw.h"
#include "tests/calib/support_board.h"
#include "tests/support.h"
#include "tests/support_scene.h"

enum { EDGE = 4 };

static const double RAD = 3.14159265358979323846 / 180;

typedef struct scene {
    sheen_camera camera;
    sheen_board board;
    sheen_model model;
    double rt_cam_world[6]; // world: the board's frame at angle 0
} scene;

static void stand_on_board(sheen_mesh *mesh)
{
    float lowest = 1;
    for (size_t i = 0; i < mesh->n_vertices; i++)
        lowest = fminf(lowest, mesh->p_obj[3 * i + 2]);
    for (size_t i = 0; i < mesh->n_vertices; i++)
        mesh->p_obj[3 * i + 2] -= lowest;
}

static void paint(sheen_model *m)
{
    const size_t per_triangle = sheen_texels_per_triangle(EDGE);
    float p_obj[3 * 16], n_obj[3 * 16];
    for (size_t f = 0; f < m->mesh.n_triangles; f++) {
        sheen_texture_lattice(&m->mesh, f, EDGE, p_obj, n_obj);
        for (size_t k = 0; k < per_triangle; k++) {
            const float *p = p_obj + 3 * k;
            const float band = 0.5f + 0.5f * sinf(180 * p[2] + 3 * atan2f(p[1], p[0]));
            const float rgb[3] = {0.1f + 0.4f * band, 0.25f, 0.5f - 0.35f * band};
            memcpy(m->texture.rgb + 3 * (f * per_triangle + k), rgb, sizeof rgb);
            m->texture.n_views[f * per_triangle + k] = 1;
        }
    }
}

static void light(sheen_model *m)
{
    static const float directions[3][3] = {
        {0.5f, -0.5f, 0.707f}, {-0.6f, -0.3f, 0.742f}, {0.1f, 0.6f, 0.794f}};
    static const float strengths[3] = {0.6f, 0.35f, 0.25f};
    sheen_lamp lamps[3];
    sheen_err err;
    m->sigma_rad = 0.09;
    m->shadows = 1;
    m->irradiance = (sheen_irradiance){.present = 1, .degree = 1, .n_lamps = 3};
    double lamp_part = 0;
    for (int i = 0; i < 3; i++) {
        lamps[i] = (sheen_lamp){.rgb = {strengths[i], strengths[i], strengths[i]}};
        sheen_irradiance_lamp *e = &m->irradiance.lamps[i];
        memcpy(e->l_world, directions[i], sizeof e->l_world);
        sheen_normalizef(e->l_world);
        memcpy(lamps[i].direction_world, e->l_world, sizeof e->l_world);
        for (int c = 0; c < 3; c++)
            e->rgb[c] = 1.5 * (double)strengths[i];
        lamp_part += e->rgb[0] / 4;
    }
    for (int c = 0; c < 3; c++)
        m->irradiance.rgb[0][c] = (1 - lamp_part) / 0.28209479177387814;
    assert_ok(sheen_model_set_lamps(m, lamps, 3, &err), err);
}

static void build(scene *s, int width_px, int height_px, double elevation_deg)
{
    sheen_err err;
    const double middle[2] = {0, 0};
    test_camera(&s->camera, width_px, height_px, 1.3 * width_px, 0);
    test_board_make(&s->board, 8, 8, 0.03, 0.7, 0, 0.045);
    test_board_look(s->rt_cam_world, middle, 0.42, 90 - elevation_deg, -90, 0);
    sheen_model_init(&s->model);
    test_figure(&s->model.mesh, 10, 0.04f, 0.008f);
    stand_on_board(&s->model.mesh);
    s->model.moving = SHEEN_MOVING_OBJECT;
    assert_ok(sheen_texture_init(&s->model.texture, s->model.mesh.n_triangles, EDGE, &err), err);
    paint(&s->model);
    light(&s->model);
}

// The board, with the figure in front of it, linear.
static void draw(sheen_image *out, const scene *s, const sheen_drawing *d, double angle_rad)
{
    const double turn[6] = {0, 0, angle_rad, 0, 0, 0};
    const sheen_draw_options o = {.layers = SHEEN_LAYER_COMPOSITE | SHEEN_LAYER_COVERAGE,
                                  .samples_per_side = 3};
    test_photo photo = {.board = &s->board, .camera = &s->camera, .blur_px = 0.5};
    sheen_layers layers;
    sheen_err err;
    sheen_rt_compose(photo.rt_cam_board, s->rt_cam_world, turn);
    uint8_t *grey = test_photo_render(&photo);
    assert_ok(sheen_draw(&layers, d, &s->camera, photo.rt_cam_board, turn, &o, &err), err);
    *out = layers.composite;
    for (size_t i = 0; i < (size_t)s->camera.width_px * (size_t)s->camera.height_px; i++)
        for (size_t c = 0; c < 3; c++)
            out->data[3 * i + c] += (1 - layers.coverage.data[i]) * 0.8f * (float)grey[i] / 255;
    layers.composite = (sheen_image){0};
    sheen_layers_release(&layers);
    free(grey);
}

static void add_frame(sheen_session *session, const sheen_image *picture, int k, double angle_deg)
{
    char path[TEST_PATH_MAX];
    sheen_frame_info f;
    sheen_raster r;
    sheen_err err;
    size_t size_bytes;
    snprintf(path, sizeof path, "%.400s/picture.jpg", session->path);
    assert_ok(sheen_raster_from_linear(&r, picture, &err), err);
    assert_ok(sheen_jpeg_write(path, &r, 90, &err), err);
    sheen_raster_release(&r);
    uint8_t *data = test_file_read(path, &size_bytes);
    remove(path);
    sheen_frame_info_init(&f);
    snprintf(f.name, sizeof f.name, "a%03d", k);
    f.width_px = picture->width_px;
    f.height_px = picture->height_px;
    f.transfer = SHEEN_TRANSFER_SRGB;
    f.sequence = k;
    f.table_asked_deg = f.table_measured_deg = angle_deg;
    assert_ok(sheen_session_add_frame(session, &f, "jpg", data, size_bytes, &err), err);
    free(data);
}

int main(int argc, char **argv)
{
    scene s;
    sheen_session session;
    sheen_drawing *d;
    char path[TEST_PATH_MAX];
    sheen_err err;
    if (argc < 5)
        return 2;
    const int n = atoi(argv[4]);                                            // NOLINT(cert-err34-c)
    build(&s, atoi(argv[2]), atoi(argv[3]), argc > 5 ? atof(argv[5]) : 35); // NOLINT(cert-err34-c)
    assert_ok(sheen_session_create(&session, argv[1], SHEEN_MOVING_OBJECT, &err), err);
    snprintf(path, sizeof path, "%.400s/" SHEEN_SESSION_CAMERA, argv[1]);
    assert_ok(sheen_camera_save(&s.camera, path, &err), err);
    snprintf(path, sizeof path, "%.400s/" SHEEN_SESSION_BOARD, argv[1]);
    test_board_save(&s.board, path);
    snprintf(path, sizeof path, "%.400s/mesh.ply", argv[1]);
    assert_ok(sheen_mesh_save_ply(&s.model.mesh, path, &err), err);
    assert_ok(sheen_drawing_new(&d, &s.model, &err), err);
    for (int k = 0; k < n; k++) {
        sheen_image picture;
        draw(&picture, &s, d, 360.0 * k / n * RAD);
        add_frame(&session, &picture, k, 360.0 * k / n);
        sheen_image_release(&picture);
    }
    sheen_drawing_free(&d);
    sheen_model_release(&s.model);
    sheen_board_release(&s.board);
    sheen_session_release(&session);
    return 0;
}

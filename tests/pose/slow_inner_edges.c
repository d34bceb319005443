// SPDX-License-Identifier: Apache-2.0
// Would edges inside of the outline help a registration? slow_inner_edges SESSION... (camera, poses, mesh where it
// stands, pictures): what the pictures' steepest steps are off the mesh's edges, where the mesh is already: along the
// outline, along inner contours (one part before another) and along creases. An edge helps if it is found, if its
// distance scatters little, and if the mean of a frame is no other than the outline's.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/order.h"
#include "base/pose3.h"
#include "base/session.h"
#include "base/vec.h"
#include "pose/outline_border.h"
#include "render/scene.h"
#include "support.h"

enum { OUTER, CONTOUR, CREASE, KINDS, MAX_SAMPLES = 1 << 20 };

static const double REACH_PX = 4, SPACING_PX = 2;
static const double SHARP_COS = 0.766; // of 40 degrees between the triangles of a crease
static const double BESIDE_M = 2e-4;   // what is looked at of a point lies so much before it

typedef struct found {
    double *distance_px;
    size_t n, n_sought;
} found;

typedef struct object {
    sheen_mesh mesh;
    sheen_outline_mesh edges;
    sheen_scene *rays;
    sheen_placement placement;
} object;

static void look(found *f, const sheen_outline_view *v, const sheen_outline_sample *s)
{
    double d;
    f->n_sought++;
    if (sheen_outline_find_edge(&d, v, s, REACH_PX) && f->n < MAX_SAMPLES)
        f->distance_px[f->n++] = d;
}

static void normal_of(double n[3], const object *o, uint32_t triangle)
{
    const uint32_t *t = o->edges.triangles + 3 * (size_t)triangle;
    double a[3], b[3];
    for (size_t c = 0; c < 3; c++) {
        a[c] = (double)o->edges.p_obj[3 * t[1] + c] - (double)o->edges.p_obj[3 * t[0] + c];
        b[c] = (double)o->edges.p_obj[3 * t[2] + c] - (double)o->edges.p_obj[3 * t[0] + c];
    }
    sheen_cross(n, a, b);
    const double length = fmax(sheen_norm(n), 1e-30);
    for (int c = 0; c < 3; c++)
        n[c] /= length;
}

// OUTER: neither; the outline itself is sampled by sheen_outline_draw.
static int kind_of(const object *o, const uint32_t *edge, const double eye_obj[3])
{
    double n[2][3], to_eye[3];
    if (edge[3] == UINT32_MAX)
        return OUTER;
    for (size_t c = 0; c < 3; c++)
        to_eye[c] = eye_obj[c] - (double)o->edges.p_obj[3 * edge[0] + c];
    normal_of(n[0], o, edge[2]);
    normal_of(n[1], o, edge[3]);
    const bool front[2] = {sheen_dot(n[0], to_eye) > 0, sheen_dot(n[1], to_eye) > 0};
    return front[0] != front[1] ? CONTOUR : front[0] && sheen_dot(n[0], n[1]) < SHARP_COS ? CREASE : OUTER;
}

static bool visible(const object *o, const double p_obj[3], const double eye_obj[3])
{
    double d[3];
    float from[3], v[3];
    sheen_sub(d, eye_obj, p_obj);
    const double length = sheen_norm(d);
    for (int c = 0; c < 3; c++) {
        v[c] = (float)(d[c] / length);
        from[c] = (float)(p_obj[c] + BESIDE_M * d[c] / length);
    }
    return !sheen_scene_blocked(o->rays, from, v);
}

static bool is_inside(const sheen_outline *drawn, const double q_px[2], double by_px)
{
    for (int k = 0; k < 8; k++) {
        const int x = (int)lrint(q_px[0] + by_px * cos(0.785398 * k)),
                  y = (int)lrint(q_px[1] + by_px * sin(0.785398 * k));
        if (x < 0 || y < 0 || x >= drawn->width_px || y >= drawn->height_px ||
            !drawn->cover[(size_t)y * (size_t)drawn->width_px + (size_t)x])
            return false;
    }
    return true;
}

// The edges inside of what is drawn, further from the outline than is looked.
static void look_inside(found *f, const object *o, const sheen_outline *drawn, const sheen_outline_view *v,
                        const double eye_obj[3], uint64_t *seed)
{
    for (size_t e = 0; e < o->edges.n_edges; e++) {
        const uint32_t *edge = o->edges.edges + 4 * e;
        const double *a = drawn->q_px + 2 * (size_t)edge[0], *b = drawn->q_px + 2 * (size_t)edge[1];
        const double length = hypot(b[0] - a[0], b[1] - a[1]);
        const int kind = length > 1e-6 ? kind_of(o, edge, eye_obj) : OUTER;
        if (kind == OUTER || test_random(seed) > length / SPACING_PX)
            continue;
        const double share = test_random(seed);
        double p[3];
        sheen_outline_sample s = {.n_px = {(b[1] - a[1]) / length, (a[0] - b[0]) / length}};
        for (size_t c = 0; c < 3; c++)
            p[c] = (1 - share) * (double)o->edges.p_obj[3 * edge[0] + c] +
                   share * (double)o->edges.p_obj[3 * edge[1] + c];
        for (int k = 0; k < 2; k++)
            s.q_px[k] = (1 - share) * a[k] + share * b[k];
        if (is_inside(drawn, s.q_px, REACH_PX + 2) && visible(o, p, eye_obj))
            look(&f[kind], v, &s);
    }
}

static void say(const char *name, found *f)
{
    const double n = (double)f->n;
    qsort(f->distance_px, f->n, sizeof *f->distance_px, sheen_ascending);
    double near = 0, sum2 = 0;
    for (size_t i = 0; i < f->n; i++) {
        near += fabs(f->distance_px[i]) < 1;
        sum2 += f->distance_px[i] * f->distance_px[i];
    }
    printf("  %-15s %7zu samples, %5.1f %% with an edge, of these %5.1f %% within a pixel; rms %.2f px; "
           "quartiles "
           "%+.2f %+.2f %+.2f px\n",
           name, f->n_sought, 100 * n / fmax(1, (double)f->n_sought), 100 * near / fmax(1, n),
           sqrt(sum2 / fmax(1, n)), f->n ? f->distance_px[f->n / 4] : 0, f->n ? f->distance_px[f->n / 2] : 0,
           f->n ? f->distance_px[f->n * 3 / 4] : 0);
}

static void one_frame(found *f, const object *o, const sheen_session *s, const sheen_frame_info *frame,
                      const double rt_cam_board[6], const sheen_camera *camera, uint64_t *seed)
{
    sheen_err err;
    sheen_image light, everywhere;
    sheen_outline drawn = {0};
    sheen_outline_view v = {
        .canvas = {
            .camera = camera, .factor = 1, .width_px = camera->width_px, .height_px = camera->height_px}};
    sheen_Rt Rt_obj_cam;
    sheen_Rt_from_rt(&v.canvas.Rt_cam_board, rt_cam_board);
    sheen_Rt_compose(&Rt_obj_cam, &v.canvas.Rt_cam_board, &o->placement.Rt_board_obj);
    sheen_Rt_invert(&Rt_obj_cam, &Rt_obj_cam);
    assert_ok(sheen_session_grey(&light, s, frame, &err), err);
    assert_ok(sheen_image_init(&everywhere, camera->width_px, camera->height_px, 1, &err), err);
    v.light = light.data;
    v.mask = everywhere.data;
    assert_ok(sheen_outline_draw(&drawn, &o->edges, &o->placement, &v.canvas, SPACING_PX, &err), err);
    for (size_t i = 0; i < drawn.n_samples; i++)
        look(&f[OUTER], &v, &drawn.samples[i]);
    look_inside(f, o, &drawn, &v, Rt_obj_cam.t, seed);
    sheen_outline_release(&drawn);
    sheen_image_release(&everywhere);
    sheen_image_release(&light);
}

static void one_session(const char *path)
{
    static const char *const names[KINDS] = {"outline", "inner contours", "creases"};
    sheen_err err;
    sheen_session s;
    sheen_camera camera;
    sheen_poses poses;
    object o = {.placement.scale = 1};
    found f[KINDS];
    char file[SHEEN_PATH_MAX];
    double rt[6];
    uint64_t seed = 1;
    for (int k = 0; k < KINDS; k++) {
        f[k] = (found){.distance_px = malloc(MAX_SAMPLES * sizeof(double))};
        assert_non_null(f[k].distance_px);
    }
    assert_ok(sheen_session_open(&s, path, &err), err);
    assert_ok(sheen_session_path(file, &s, SHEEN_SESSION_CAMERA, &err), err);
    assert_ok(sheen_camera_load(&camera, file, &err), err);
    assert_ok(sheen_poses_load(&poses, &s, &err), err);
    assert_ok(sheen_registration_load(rt, &s, &err), err);
    sheen_Rt_from_rt(&o.placement.Rt_board_obj, rt);
    assert_ok(sheen_session_path(file, &s, sheen_session_mesh_file(&s), &err), err);
    assert_ok(sheen_mesh_load(&o.mesh, file, &err), err);
    assert_ok(sheen_outline_mesh_make(&o.edges, &o.mesh, &err), err);
    assert_ok(sheen_scene_new(&o.rays, &o.mesh, &err), err);
    for (size_t i = 0; i < s.n_frames; i++) {
        const sheen_frame_pose *p = sheen_poses_find(&poses, s.frames[i].name);
        if (s.frames[i].role == SHEEN_ROLE_INPUT && p && p->found)
            one_frame(f, &o, &s, &s.frames[i], p->rt_cam_board, &camera, &seed);
    }
    printf("%s\n", path);
    for (int k = 0; k < KINDS; k++) {
        say(names[k], &f[k]);
        free(f[k].distance_px);
    }
    sheen_scene_free(&o.rays);
    sheen_outline_mesh_release(&o.edges);
    sheen_mesh_release(&o.mesh);
    sheen_poses_release(&poses);
    sheen_session_release(&s);
}

int main(int argc, char **argv)
{
    for (int i = 1; i < argc; i++)
        one_session(argv[i]);
    return argc > 1 ? 0 : 77;
}

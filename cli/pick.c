// SPDX-License-Identifier: Apache-2.0
// pick.c - marks of a mesh's points in frames: pictures of the mesh by the ray tracer, and a list kept in a file.
#include "cli/pick.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json_write.h"
#include "base/pose3.h"
#include "base/vec.h"
#include "cli/page_photos.h"
#include "cli/viewer_html.h"
#include "pose/register_points.h"
#include "render/gbuffer.h"

enum { SIDE_PX = 640, MAX_MARKS = 200, MAX_FILE_BYTES = 1 << 20 };

static const double RAD_PER_DEG = 3.14159265358979323846 / 180;
static const double DISTANCE = 5; // of the mesh's pictures, in its radii

struct sheen_pick {
    const sheen_session *session;
    const sheen_mesh *mesh;
    const char *path;
    double unit_m, axes_obj[3][3], centre_obj[3], radius_obj;
    sheen_scene *rays;
    sheen_camera eye, camera; // of the mesh's pictures; of the session
    sheen_page_photos photos;
    sheen_register_point *marks;
    size_t n_marks;
};

size_t sheen_pick_count(const sheen_pick *pick)
{
    return pick->n_marks;
}

void sheen_pick_close(sheen_pick **pick)
{
    sheen_pick *p = *pick;
    if (!p)
        return;
    sheen_scene_free(&p->rays);
    sheen_page_photos_close(&p->photos);
    free(p->marks);
    free(p);
    *pick = NULL;
}

// Two axes across the mesh's up, and that itself.
static void set_axes(sheen_pick *p, unsigned up)
{
    int bit = 4;
    for (int i = 0; i < 6; i++)
        bit = up == 1U << i ? i : bit;
    const double sign = bit % 2 ? -1 : 1;
    p->axes_obj[2][bit / 2] = sign;
    p->axes_obj[0][(bit / 2 + 1) % 3] = 1;
    p->axes_obj[1][(bit / 2 + 2) % 3] = sign;
}

static sheen_status load_marks(sheen_pick *p, sheen_err *err)
{
    uint8_t *data;
    size_t size_bytes, n;
    sheen_register_point *list;
    sheen_err ignored;
    p->marks = calloc(MAX_MARKS, sizeof *p->marks);
    if (!p->marks)
        return sheen_fail_memory(err, MAX_MARKS * sizeof *p->marks, "marks");
    if (!sheen_file_exists(p->path) || sheen_file_read(&data, &size_bytes, p->path, MAX_FILE_BYTES, &ignored))
        return SHEEN_OK;
    const sheen_status st = sheen_register_points_parse(&list, &n, data, size_bytes, err);
    free(data);
    if (st == SHEEN_EDATA) // no mark in it yet
        return SHEEN_OK;
    if (st)
        return sheen_wrap(err, st, "'%s' is there but holds no marks", p->path);
    p->n_marks = n < MAX_MARKS ? n : MAX_MARKS;
    memcpy(p->marks, list, p->n_marks * sizeof *list);
    free(list);
    return SHEEN_OK;
}

static sheen_status look_at_session(sheen_pick *p, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    if (!sheen_session_has(p->session, SHEEN_SESSION_CAMERA) ||
        !sheen_session_has(p->session, SHEEN_SESSION_POSES))
        return sheen_fail(err, SHEEN_EDATA,
                          "session '%s' has no camera or no poses: run sheen calibrate and sheen pose first",
                          p->session->path);
    sheen_status st = sheen_session_path(path, p->session, SHEEN_SESSION_CAMERA, err);
    if (!st)
        st = sheen_camera_load(&p->camera, path, err);
    if (!st)
        st = sheen_page_photos_open(&p->photos, p->session, SHEEN_PAGE_MAX_PHOTOS, err);
    if (!st && !p->photos.count)
        st = sheen_fail(err, SHEEN_EDATA, "no input frame of session '%s' has a pose", p->session->path);
    return st;
}

static sheen_status look_at_mesh(sheen_pick *p, sheen_err *err)
{
    float centre[3], radius;
    sheen_mesh_sphere(p->mesh, centre, &radius);
    for (int c = 0; c < 3; c++)
        p->centre_obj[c] = (double)centre[c];
    p->radius_obj = (double)radius;
    const double f_px = 0.48 * SIDE_PX * sqrt(DISTANCE * DISTANCE - 1), middle = (SIDE_PX - 1) / 2.0;
    const double fxycxy[4] = {f_px, f_px, middle, middle};
    const sheen_status st = sheen_camera_opencv(&p->eye, SIDE_PX, SIDE_PX, fxycxy, NULL, 0, err);
    return st ? st : sheen_scene_new(&p->rays, p->mesh, err);
}

sheen_status sheen_pick_open(sheen_pick **out, const sheen_session *s, const sheen_mesh *mesh,
                             const char *path, unsigned up, double unit_m, sheen_err *err)
{
    *out = NULL;
    if (!sheen_pick_html[0])
        return sheen_fail(err, SHEEN_EUNSUP,
                          "this build has no page to mark on; install nodejs and npm, and build again");
    sheen_pick *p = calloc(1, sizeof *p);
    if (!p)
        return sheen_fail_memory(err, sizeof *p, "marks");
    p->session = s;
    p->mesh = mesh;
    p->path = path;
    p->unit_m = unit_m;
    set_axes(p, up);
    sheen_status st = load_marks(p, err);
    if (!st)
        st = look_at_session(p, err);
    if (!st)
        st = look_at_mesh(p, err);
    if (st)
        sheen_pick_close(&p);
    *out = p;
    return st;
}

// The pose of the mesh's picture from azimuth and elevation: x right, y down, z forward.
static void eye_pose(double rt_cam_obj[6], const sheen_pick *p, double az_deg, double el_deg)
{
    const double a = az_deg * RAD_PER_DEG, e = el_deg * RAD_PER_DEG;
    const double away[3] = {cos(e) * cos(a), cos(e) * sin(a), sin(e)}, across[2] = {-sin(a), cos(a)};
    sheen_Rt Rt;
    for (int c = 0; c < 3; c++) {
        Rt.R[0][c] = across[0] * p->axes_obj[0][c] + across[1] * p->axes_obj[1][c];
        Rt.R[2][c] = 0;
        for (int k = 0; k < 3; k++)
            Rt.R[2][c] -= away[k] * p->axes_obj[k][c];
    }
    sheen_cross(Rt.R[1], Rt.R[2], Rt.R[0]);
    for (int i = 0; i < 3; i++)
        Rt.t[i] = -sheen_dot(Rt.R[i], p->centre_obj) + (i == 2 ? DISTANCE * p->radius_obj : 0);
    sheen_rt_from_Rt(rt_cam_obj, &Rt);
}

static sheen_status draw_mesh(uint8_t **jpeg, size_t *jpeg_bytes, const sheen_pick *p, double az_deg,
                              double el_deg, sheen_err *err)
{
    double rt[6];
    sheen_gbuffer g;
    sheen_image lin;
    eye_pose(rt, p, az_deg, el_deg);
    sheen_status st = sheen_image_init(&lin, SIDE_PX, SIDE_PX, 3, err);
    if (st)
        return st;
    for (size_t i = 0; i < (size_t)3 * SIDE_PX * SIDE_PX; i++)
        lin.data[i] = 0.03f;
    st = sheen_gbuffer_make(&g, p->rays, p->mesh, &p->eye, rt, 1, 0, err);
    if (!st) {
        for (int y = 0; y < g.height_px; y++)
            for (int x = 0; x < g.width_px; x++) {
                const sheen_hit *hit = &g.hits[(size_t)y * (size_t)g.width_px + (size_t)x];
                float n[3], v[3], *out = sheen_image_at(&lin, g.x0_px + x, g.y0_px + y);
                if (hit->triangle == SHEEN_NO_HIT)
                    continue;
                sheen_hit_surface(p->mesh, hit, g.p_camera_obj, NULL, n, v); // lit from the camera
                out[0] = out[1] = out[2] = 0.08f + 0.6f * fabsf(n[0] * v[0] + n[1] * v[1] + n[2] * v[2]);
            }
        sheen_gbuffer_release(&g);
        st = sheen_page_jpeg(jpeg, jpeg_bytes, &lin, err);
    }
    sheen_image_release(&lin);
    return st;
}

static sheen_status load_frame(uint8_t **jpeg, size_t *jpeg_bytes, const sheen_pick *p, size_t i,
                               sheen_err *err)
{
    sheen_image lin;
    const sheen_frame_info *f = sheen_session_find(p->session,
                                                   p->photos.poses.poses[p->photos.i_pose[i]].name);
    if (!f)
        return sheen_fail(err, SHEEN_EDATA, "the frame is gone from the session");
    sheen_status st = sheen_session_image(&lin, p->session, f, err);
    if (st)
        return st;
    st = sheen_page_jpeg(jpeg, jpeg_bytes, &lin, err);
    sheen_image_release(&lin);
    return st;
}

// The mesh's point under a place of its picture.
static bool meet_mesh(double p_obj[3], const sheen_pick *p, double az_deg, double el_deg, const double q[2])
{
    double rt[6];
    sheen_gbuffer g;
    float at[3];
    eye_pose(rt, p, az_deg, el_deg);
    if (sheen_gbuffer_make(&g, p->rays, p->mesh, &p->eye, rt, 1, 0, NULL))
        return false;
    const long x = lrint(q[0]) - g.x0_px, y = lrint(q[1]) - g.y0_px;
    const bool inside = x >= 0 && y >= 0 && x < g.width_px && y < g.height_px;
    const sheen_hit *hit = inside ? &g.hits[y * g.width_px + x] : NULL;
    const bool met = hit && hit->triangle != SHEEN_NO_HIT;
    if (met)
        sheen_hit_surface(p->mesh, hit, g.p_camera_obj, at, NULL, NULL);
    for (int c = 0; c < 3 && met; c++)
        p_obj[c] = (double)at[c];
    sheen_gbuffer_release(&g);
    return met;
}

static sheen_status save(const sheen_pick *p, sheen_err *err)
{
    static const char head[] = "# frame x y X Y Z: pixel, and point of the mesh in its own unit\n";
    const size_t room = sizeof head + p->n_marks * 256;
    char *text = malloc(room);
    if (!text)
        return sheen_fail_memory(err, (double)room, "marks");
    memcpy(text, head, sizeof head);
    size_t n = sizeof head - 1;
    for (size_t i = 0; i < p->n_marks; i++) {
        const sheen_register_point *m = &p->marks[i];
        n += (size_t)snprintf(text + n, room - n, "%s %.2f %.2f %.9g %.9g %.9g\n", m->frame, m->q_px[0],
                              m->q_px[1], m->p_obj[0], m->p_obj[1], m->p_obj[2]);
    }
    const sheen_status st = sheen_file_write(p->path, text, n, err);
    free(text);
    return st;
}

static sheen_status add_mark(sheen_pick *p, size_t frame, const double x[6], sheen_err *err)
{
    sheen_register_point *m = &p->marks[p->n_marks];
    if (p->n_marks == MAX_MARKS)
        return sheen_fail(err, SHEEN_EARG, "%d marks are enough", (int)MAX_MARKS);
    if (!meet_mesh(m->p_obj, p, x[2], x[3], x + 4))
        return sheen_fail(err, SHEEN_EARG, "there is no mesh at that place");
    snprintf(m->frame, sizeof m->frame, "%s", p->photos.poses.poses[p->photos.i_pose[frame]].name);
    memcpy(m->q_px, x, sizeof m->q_px);
    p->n_marks++;
    const sheen_status st = save(p, err);
    p->n_marks -= st != SHEEN_OK;
    return st;
}

static sheen_status undo(sheen_pick *p, sheen_err *err)
{
    p->n_marks -= p->n_marks > 0;
    return save(p, err);
}

static void send_json(sheen_answer *to, sheen_json_writer *w)
{
    const char *text = sheen_json_text(w);
    if (text)
        sheen_answer_text(to, "application/json", text);
    sheen_json_writer_release(w);
}

static void answer_done(sheen_answer *to, sheen_status st, const sheen_err *err)
{
    sheen_json_writer w = {0};
    sheen_json_open(&w, NULL, '{');
    sheen_json_put_bool(&w, "ok", !st);
    if (st)
        sheen_json_put_string(&w, "why", err->msg);
    sheen_json_close(&w);
    send_json(to, &w);
}

static void answer_frames(const sheen_pick *p, sheen_answer *to)
{
    sheen_json_writer w = {0};
    sheen_json_open(&w, NULL, '{');
    sheen_json_put_int(&w, "mesh_side_px", SIDE_PX);
    sheen_json_put_int(&w, "width_px", p->camera.width_px);
    sheen_json_put_int(&w, "height_px", p->camera.height_px);
    sheen_json_open(&w, "frames", '[');
    for (size_t i = 0; i < p->photos.count; i++)
        sheen_json_put_string(&w, NULL, p->photos.poses.poses[p->photos.i_pose[i]].name);
    sheen_json_close(&w);
    sheen_json_close(&w);
    send_json(to, &w);
}

// How the marks fit as they are: what `sheen register` will find of them.
static void put_fit(sheen_json_writer *w, const sheen_pick *p)
{
    sheen_register_points_fit fit;
    sheen_err err;
    const sheen_status st = sheen_register_points_solve(&fit, p->marks, p->n_marks, &p->camera,
                                                        &p->photos.poses, p->unit_m, &err);
    if (st) {
        sheen_json_put_string(w, "why", err.msg);
        return;
    }
    sheen_json_put_number(w, "rms_px", fit.rms_px);
    sheen_json_put_number(w, "worst_px", fit.worst_px);
    sheen_json_put_int(w, "worst", (long long)fit.i_worst + 1);
}

static void answer_marks(const sheen_pick *p, double az_deg, double el_deg, sheen_answer *to)
{
    sheen_json_writer w = {0};
    double rt[6], p_cam[3], q[2];
    sheen_Rt Rt;
    eye_pose(rt, p, az_deg, el_deg);
    sheen_Rt_from_rt(&Rt, rt);
    sheen_json_open(&w, NULL, '{');
    sheen_json_open(&w, "marks", '[');
    for (size_t i = 0; i < p->n_marks; i++) {
        sheen_Rt_point(p_cam, &Rt, p->marks[i].p_obj);
        if (sheen_camera_project(&p->eye, q, NULL, p_cam, 1, NULL))
            q[0] = q[1] = -1;
        sheen_json_open(&w, NULL, '{');
        sheen_json_put_string(&w, "frame", p->marks[i].frame);
        sheen_json_put_numbers(&w, "q_px", p->marks[i].q_px, 2);
        sheen_json_put_numbers(&w, "mesh_px", q, 2);
        sheen_json_close(&w);
    }
    sheen_json_close(&w);
    put_fit(&w, p);
    sheen_json_close(&w);
    send_json(to, &w);
}

// "NAME/1.5/2" to its n numbers, all finite; nothing else may follow.
static bool numbers(double *x, size_t n, const char *what, const char *name)
{
    const size_t length = strlen(name);
    if (strncmp(what, name, length) != 0)
        return false;
    what += length;
    for (size_t i = 0; i < n; i++) {
        char *end;
        if (*what++ != '/')
            return false;
        x[i] = strtod(what, &end);
        if (end == what || !(fabs(x[i]) < 1e6))
            return false;
        what = end;
    }
    return !*what;
}

void sheen_pick_answer(void *pick, const char *what, sheen_answer *to)
{
    sheen_pick *p = pick;
    sheen_err err = {0};
    double x[7];
    uint8_t *jpeg = NULL;
    const double count = (double)p->photos.count;
    if (!*what)
        sheen_answer_text(to, "text/html; charset=utf-8", sheen_pick_html);
    else if (!strcmp(what, "frames"))
        answer_frames(p, to);
    else if (!strcmp(what, "undo"))
        answer_done(to, undo(p, &err), &err);
    else if (numbers(x, 2, what, "marks"))
        answer_marks(p, x[0], x[1], to);
    else if (numbers(x, 7, what, "mark") && x[0] >= 0 && x[0] < count)
        answer_done(to, add_mark(p, (size_t)x[0], x + 1, &err), &err);
    else if ((numbers(x, 1, what, "frame") && x[0] >= 0 && x[0] < count &&
              !load_frame(&jpeg, &to->size_bytes, p, (size_t)x[0], &err)) ||
             (numbers(x, 2, what, "mesh") && !draw_mesh(&jpeg, &to->size_bytes, p, x[0], x[1], &err))) {
        to->data = jpeg;
        to->type = "image/jpeg";
    }
}

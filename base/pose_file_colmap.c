// SPDX-License-Identifier: Apache-2.0
// pose_file_colmap.c - COLMAP's text model: cameras.txt and images.txt.
//
// images.txt has two lines an image: the pose (world to camera, quaternion qw qx qy qz, OpenCV's axes), then its
// keypoints, a line that may be empty. COLMAP's pixel (0.5, 0.5) is our (0, 0).
#include "base/pose_file.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/image.h"
#include "base/pose_file_build.h"
#include "base/scan.h"

// Where a model's parameters are: its focal lengths, then cx cy, then n distortion numbers of OpenCV's order.
typedef struct model {
    const char *name;
    int n_focal, n_distortion;
} model;

static const model models[] = {{"SIMPLE_PINHOLE", 1, 0}, {"PINHOLE", 2, 0}, {"SIMPLE_RADIAL", 1, 1},
                               {"RADIAL", 1, 2},         {"OPENCV", 2, 4},  {"FULL_OPENCV", 2, 8}};

static sheen_status fail_line(const sheen_scan *line, const char *file, const char *what, sheen_err *err)
{
    return sheen_fail(err, SHEEN_EFORMAT, "%s, line %zu: %s", file, line->line, what);
}

// The first word of a line that says something, or false: blank, or a comment.
static bool begin_line(sheen_scan *line, sheen_word *word)
{
    return sheen_scan_word(line, word) && word->text[0] != '#';
}

static sheen_status find_model(const sheen_scan *line, const sheen_word *name, const model **out,
                               sheen_err *err)
{
    for (size_t i = 0; i < sizeof models / sizeof *models; i++)
        if (sheen_word_is(name, models[i].name)) {
            *out = &models[i];
            return SHEEN_OK;
        }
    return sheen_fail(
        err, SHEEN_EUNSUP,
        "cameras.txt, line %zu: lens model '%.*s' is not supported: undistort the images with COLMAP",
        line->line, name->length < 40 ? (int)name->length : 40, name->text);
}

// CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]
static sheen_status read_camera(sheen_scan *line, const sheen_word *first, int *id, sheen_camera *cam,
                                sheen_err *err)
{
    sheen_word word, width, height;
    long long camera_id, width_px, height_px;
    if (!sheen_word_integer(first, 0, INT_MAX, &camera_id) || !sheen_scan_word(line, &word))
        return fail_line(line, "cameras.txt",
                         "a camera begins with its number and the name of its lens model", err);
    const model *m = NULL;
    sheen_status s = find_model(line, &word, &m, err);
    if (s)
        return s;
    if (!sheen_scan_word(line, &width) ||
        !sheen_word_integer(&width, 1, SHEEN_IMAGE_MAX_SIDE_PX, &width_px) ||
        !sheen_scan_word(line, &height) ||
        !sheen_word_integer(&height, 1, SHEEN_IMAGE_MAX_SIDE_PX, &height_px))
        return fail_line(line, "cameras.txt", "width and height are not numbers of pixels", err);
    double x[12] = {0}, distortion[8] = {0};
    const int n = m->n_focal + 2 + m->n_distortion;
    for (int i = 0; i < n; i++)
        if (!sheen_scan_number(line, &x[i]))
            return sheen_fail(err, SHEEN_EFORMAT, "cameras.txt, line %zu: %s has %d parameters, all finite",
                              line->line, m->name, n);
    if (sheen_scan_word(line, &word))
        return sheen_fail(err, SHEEN_EFORMAT, "cameras.txt, line %zu: %s has %d parameters, here are more",
                          line->line, m->name, n);
    const double fxycxy[4] = {x[0], x[m->n_focal - 1], x[m->n_focal], x[m->n_focal + 1]};
    memcpy(distortion, x + m->n_focal + 2, (size_t)m->n_distortion * sizeof *distortion);
    *id = (int)camera_id;
    const int n_distortion = m->n_distortion > 0 && m->n_distortion < 4 ? 4 : m->n_distortion;
    s = sheen_camera_from_foreign(cam, (int)width_px, (int)height_px, fxycxy, distortion, n_distortion, err);
    return s ? sheen_wrap(err, s, "cameras.txt, line %zu", line->line) : SHEEN_OK;
}

static int compare_ints(const void *a, const void *b)
{
    const int x = *(const int *)a, y = *(const int *)b;
    return (x > y) - (x < y);
}

static sheen_status check_ids(const int *ids, size_t n, sheen_err *err)
{
    int *sorted = malloc(n * sizeof *sorted);
    if (!sorted)
        return sheen_fail_memory(err, (double)(n * sizeof *sorted), "cameras");
    memcpy(sorted, ids, n * sizeof *sorted);
    qsort(sorted, n, sizeof *sorted, compare_ints);
    sheen_status s = SHEEN_OK;
    for (size_t i = 1; i < n && !s; i++)
        if (sorted[i - 1] == sorted[i])
            s = sheen_fail(err, SHEEN_EFORMAT, "cameras.txt: camera %d is there twice", sorted[i]);
    free(sorted);
    return s;
}

static sheen_status read_cameras(sheen_pose_file *out, int **ids, const void *data, size_t size_bytes,
                                 sheen_err *err)
{
    sheen_scan text = {data, (const char *)data + size_bytes, 0}, line;
    sheen_word word;
    sheen_status s = SHEEN_OK;
    while (!s && sheen_scan_line(&text, &line)) {
        if (!begin_line(&line, &word))
            continue;
        sheen_camera cam;
        int id = 0;
        s = read_camera(&line, &word, &id, &cam, err);
        if (!s)
            s = sheen_pose_file_add_camera(out, &cam, err);
        if (s)
            break;
        int *grown = realloc(*ids, out->n_cameras * sizeof *grown);
        if (!grown)
            return sheen_fail_memory(err, (double)(out->n_cameras * sizeof *grown), "cameras");
        *ids = grown;
        grown[out->n_cameras - 1] = id;
    }
    if (!s && !out->n_cameras)
        return sheen_fail(err, SHEEN_EFORMAT, "cameras.txt holds no camera");
    return s ? s : check_ids(*ids, out->n_cameras, err);
}

// The rotation of a quaternion w x y z of any length.
static void R_from_quaternion(double R[3][3], const double q[4])
{
    const double n2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const double x = q[1 + i], y = q[1 + j], z = q[1 + k];
        R[i][i] = 1 - 2 * (y * y + z * z) / n2;
        R[i][j] = 2 * (x * y - q[0] * z) / n2;
        R[i][k] = 2 * (x * z + q[0] * y) / n2;
    }
}

// IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME
static sheen_status read_image(sheen_pose_file *out, const int *ids, sheen_scan *line,
                               const sheen_word *first, sheen_err *err)
{
    long long image_id, camera_id;
    double x[7];
    bool ok = sheen_word_integer(first, 0, LLONG_MAX, &image_id);
    for (int i = 0; i < 7; i++)
        ok = ok && sheen_scan_number(line, &x[i]);
    sheen_word word;
    ok = ok && sheen_scan_word(line, &word) && sheen_word_integer(&word, 0, INT_MAX, &camera_id);
    const sheen_word name = sheen_scan_rest(line);
    if (!ok || !name.length)
        return fail_line(line, "images.txt",
                         "an image is a number, a pose of seven finite numbers, a camera, a name", err);
    const double norm = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3]);
    if (!(fabs(norm - 1) < 1e-2))
        return fail_line(line, "images.txt", "the quaternion is not a rotation", err);
    size_t i_camera = 0;
    while (i_camera < out->n_cameras && ids[i_camera] != camera_id)
        i_camera++;
    if (i_camera == out->n_cameras)
        return sheen_fail(err, SHEEN_EFORMAT, "images.txt, line %zu: cameras.txt has no camera %lld",
                          line->line, camera_id);
    sheen_view *view = NULL;
    const sheen_status s = sheen_pose_file_add_view(out, name.text, name.length, "", &view, err);
    if (s)
        return s;
    sheen_Rt Rt_cam_world;
    R_from_quaternion(Rt_cam_world.R, x);
    memcpy(Rt_cam_world.t, x + 4, sizeof Rt_cam_world.t);
    sheen_rt_from_Rt(view->rt_cam_world, &Rt_cam_world);
    view->i_camera = (int)i_camera;
    view->width_px = out->cameras[i_camera].width_px;
    view->height_px = out->cameras[i_camera].height_px;
    return SHEEN_OK;
}

static sheen_status read_images(sheen_pose_file *out, const int *ids, const void *data, size_t size_bytes,
                                sheen_err *err)
{
    sheen_scan text = {data, (const char *)data + size_bytes, 0}, line;
    sheen_word word;
    sheen_status s = SHEEN_OK;
    while (!s && sheen_scan_line(&text, &line)) {
        if (!begin_line(&line, &word))
            continue;
        s = read_image(out, ids, &line, &word, err);
        sheen_scan_line(&text, &line); // its keypoints
    }
    return s ? s : sheen_pose_file_check(out, err);
}

sheen_status sheen_colmap_parse(sheen_pose_file *out, const void *cameras_txt, size_t cameras_bytes,
                                const void *images_txt, size_t images_bytes, sheen_err *err)
{
    *out = (sheen_pose_file){0};
    int *ids = NULL;
    sheen_status s = read_cameras(out, &ids, cameras_txt, cameras_bytes, err);
    if (!s)
        s = read_images(out, ids, images_txt, images_bytes, err);
    free(ids);
    if (s)
        sheen_pose_file_release(out);
    return s;
}

sheen_status sheen_colmap_cameras_parse(sheen_camera **cameras_out, int **ids_out, size_t *n_cameras,
                                        const void *data, size_t size_bytes, sheen_err *err)
{
    sheen_pose_file p = {0};
    int *ids = NULL;
    const sheen_status s = read_cameras(&p, &ids, data, size_bytes, err);
    if (s) {
        sheen_pose_file_release(&p);
        free(ids);
        ids = NULL;
    }
    *cameras_out = p.cameras;
    *ids_out = ids;
    *n_cameras = p.n_cameras;
    return s;
}

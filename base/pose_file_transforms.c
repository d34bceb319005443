// SPDX-License-Identifier: Apache-2.0
// pose_file_transforms.c - transforms.json, as instant-ngp, nerfstudio and Blender scripts write it.
//
// Its transform_matrix takes camera points to the world, with the camera's y up and z back; ours takes world
// points to the camera, with y down and z forward. With F = diag(1, -1, -1):
//     R_world_cam = R_file F,   rt_cam_world = invert(R_world_cam, t_file)
// Its pixel (0.5, 0.5) is our (0, 0). Its distortion k1 k2 p1 p2 is OpenCV's.
#include "base/pose_file.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/file.h"
#include "base/image.h"
#include "base/json_write.h"
#include "base/pose_file_build.h"

// Matrices in files have been through float and a few decimals.
static const double rotation_tolerance = 1e-3;

typedef struct reader {
    const sheen_json *root;
    int width_px, height_px; // where the file states none; 0: unknown
    sheen_err *err;
} reader;

// A member of the frame, else of the file: NULL where neither has it.
static const sheen_json *member(const reader *r, const sheen_json *frame, const char *key)
{
    const sheen_json *own = sheen_json_get(frame, key);
    return own ? own : sheen_json_get(r->root, key);
}

// A number that may be absent (`fallback` then), but not be something else.
static sheen_status number(const reader *r, const sheen_json *frame, const char *key, double fallback,
                           double *out)
{
    const sheen_json *v = member(r, frame, key);
    if (v && !sheen_json_is_number(v))
        return sheen_fail(r->err, SHEEN_EFORMAT, "'%s' is not a number", key);
    *out = sheen_json_value_number(v, fallback);
    return SHEEN_OK;
}

static sheen_status side(const reader *r, const sheen_json *frame, const char *key, int fallback, int *out)
{
    double x;
    const sheen_status s = number(r, frame, key, fallback, &x);
    if (s)
        return s;
    const bool stated = member(r, frame, key) != NULL;
    if (x != floor(x) || x < (stated ? 1 : 0) || x > SHEEN_IMAGE_MAX_SIDE_PX)
        return sheen_fail(r->err, SHEEN_EFORMAT, "'%s' is %g, not a number of pixels", key, x);
    *out = (int)x;
    return SHEEN_OK;
}

// A flag or a number that is there and neither false nor 0.
static bool is_set(const reader *r, const sheen_json *frame, const char *key)
{
    const sheen_json *owner = sheen_json_get(frame, key) ? frame : r->root, *v = sheen_json_get(owner, key);
    bool flag = true;
    if (sheen_json_is_number(v))
        return sheen_json_value_number(v, 0) != 0;
    return v && (sheen_json_bool(owner, key, &flag, NULL) || flag);
}

// Lens models whose mathematics is not OpenCV's pinhole with k1 k2 p1 p2.
static sheen_status check_model(const reader *r, const sheen_json *frame)
{
    static const char *const known[] = {"OPENCV",      "PINHOLE",       "SIMPLE_PINHOLE",
                                        "PERSPECTIVE", "SIMPLE_RADIAL", "RADIAL"};
    const char *model = sheen_json_value_string(member(r, frame, "camera_model"), "OPENCV");
    bool is_known = false;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        is_known |= !strcmp(model, known[i]);
    if (!is_known)
        return sheen_fail(r->err, SHEEN_EUNSUP,
                          "camera model '%.40s' is not supported: undistort the images first", model);
    static const char *const others[] = {"is_fisheye", "ftheta_p0", "latlong", "equirectangular"};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        if (is_set(r, frame, others[i]))
            return sheen_fail(r->err, SHEEN_EUNSUP,
                              "a lens with '%s' is not supported: undistort the images first", others[i]);
    static const char *const higher[] = {"k3", "k4", "k5", "k6"};
    for (size_t i = 0; i < sizeof higher / sizeof *higher; i++) {
        double k;
        const sheen_status s = number(r, frame, higher[i], 0, &k);
        if (s)
            return s;
        if (k != 0)
            return sheen_fail(
                r->err, SHEEN_EUNSUP,
                "distortion '%s' = %g is not supported, only k1 k2 p1 p2 are: undistort the images first",
                higher[i], k);
    }
    return SHEEN_OK;
}

// f from its own key, else from the angle of view over the side, else `fallback`; 0: unknown.
static sheen_status focal_length(const reader *r, const sheen_json *frame, const char *key,
                                 const char *angle_key, int side_px, double fallback, double *out)
{
    double angle_rad;
    sheen_status s = number(r, frame, key, 0, out);
    if (!s)
        s = number(r, frame, angle_key, 0, &angle_rad);
    if (s)
        return s;
    if (member(r, frame, key)) {
        if (!(*out > 0))
            return sheen_fail(r->err, SHEEN_EFORMAT, "'%s' is %g, not a focal length", key, *out);
    } else if (member(r, frame, angle_key)) {
        if (!(angle_rad > 0 && angle_rad < 3.14159))
            return sheen_fail(r->err, SHEEN_EFORMAT, "'%s' is %g, not an angle between 0 and pi", angle_key,
                              angle_rad);
        *out = side_px / (2 * tan(angle_rad / 2)); // 0 where the side is unknown
    } else {
        *out = fallback;
    }
    return SHEEN_OK;
}

// The camera of one frame (NULL: of the file); *found false where its focal length or size is not stated.
static sheen_status read_camera(const reader *r, const sheen_json *frame, sheen_camera *cam, int size_px[2],
                                bool *found)
{
    double fxycxy[4] = {0}, d[4] = {0};
    static const char *const names[] = {"k1", "k2", "p1", "p2"};
    *found = false;
    sheen_status s = side(r, frame, "w", r->width_px, &size_px[0]);
    if (!s)
        s = side(r, frame, "h", r->height_px, &size_px[1]);
    if (!s)
        s = check_model(r, frame);
    if (!s)
        s = focal_length(r, frame, "fl_x", "camera_angle_x", size_px[0], 0, &fxycxy[0]);
    if (!s)
        s = focal_length(r, frame, "fl_y", "camera_angle_y", size_px[1], fxycxy[0], &fxycxy[1]);
    if (!s)
        s = number(r, frame, "cx", size_px[0] / 2.0, &fxycxy[2]);
    if (!s)
        s = number(r, frame, "cy", size_px[1] / 2.0, &fxycxy[3]);
    for (int i = 0; i < 4 && !s; i++)
        s = number(r, frame, names[i], 0, &d[i]);
    if (s || !(fxycxy[0] > 0) || !size_px[0] || !size_px[1])
        return s;
    *found = true;
    const bool is_plain = d[0] == 0 && d[1] == 0 && d[2] == 0 && d[3] == 0;
    return sheen_camera_from_foreign(cam, size_px[0], size_px[1], fxycxy, d, is_plain ? 0 : 4, r->err);
}

static bool same_camera(const sheen_camera *a, const sheen_camera *b)
{
    bool same = a->n_intrinsics == b->n_intrinsics && a->width_px == b->width_px &&
                a->height_px == b->height_px;
    for (int i = 0; i < a->n_intrinsics && same; i++)
        same = a->intrinsics[i] == b->intrinsics[i];
    return same;
}

static sheen_status read_pose(const reader *r, const sheen_json *frame, double rt_cam_world[6])
{
    double m[16];
    const size_t n_rows = sheen_json_count(sheen_json_get(frame, "transform_matrix"));
    sheen_status s = sheen_json_numbers(frame, "transform_matrix", m, n_rows == 3 ? 12 : 16, r->err);
    if (s)
        return s;
    if (n_rows != 3 && (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1))
        return sheen_fail(r->err, SHEEN_EFORMAT, "the last row of 'transform_matrix' is not 0 0 0 1");
    sheen_Rt Rt_world_cam;
    for (size_t i = 0; i < 3; i++) {
        for (size_t j = 0; j < 3; j++)
            Rt_world_cam.R[i][j] = j ? -m[4 * i + j] : m[4 * i]; // F: y and z of the camera turn round
        Rt_world_cam.t[i] = m[4 * i + 3];
    }
    if (!sheen_R_orthonormalize(Rt_world_cam.R, rotation_tolerance))
        return sheen_fail(r->err, SHEEN_EFORMAT, "'transform_matrix' is not a rotation and a translation");
    sheen_Rt Rt_cam_world;
    sheen_Rt_invert(&Rt_cam_world, &Rt_world_cam);
    sheen_rt_from_Rt(rt_cam_world, &Rt_cam_world);
    return SHEEN_OK;
}

// Frames that share a camera come one after the other, or all have the file's own, which is camera 0 then.
static sheen_status find_or_add_camera(sheen_pose_file *out, const sheen_camera *cam, int *i_camera,
                                       sheen_err *err)
{
    const size_t n = out->n_cameras;
    *i_camera = (int)n;
    if (n && same_camera(&out->cameras[n - 1], cam))
        *i_camera = (int)n - 1;
    else if (n && same_camera(&out->cameras[0], cam))
        *i_camera = 0;
    else
        return sheen_pose_file_add_camera(out, cam, err);
    return SHEEN_OK;
}

static sheen_status read_frame(const reader *r, sheen_pose_file *out, const sheen_json *frame, size_t i)
{
    char fallback[32];
    snprintf(fallback, sizeof fallback, "%06zu", i);
    const char *file = sheen_json_value_string(sheen_json_get(frame, "file_path"), "");
    double rt_cam_world[6];
    sheen_view *view = NULL;
    sheen_camera cam;
    int size_px[2] = {0};
    bool has_camera = false;
    sheen_status s = read_pose(r, frame, rt_cam_world);
    if (!s)
        s = read_camera(r, frame, &cam, size_px, &has_camera);
    if (!s)
        s = sheen_pose_file_add_view(out, file, strlen(file), fallback, &view, r->err);
    if (s)
        return s;
    memcpy(view->rt_cam_world, rt_cam_world, sizeof rt_cam_world);
    view->width_px = size_px[0];
    view->height_px = size_px[1];
    return has_camera ? find_or_add_camera(out, &cam, &view->i_camera, r->err) : SHEEN_OK;
}

sheen_status sheen_transforms_parse_sized(sheen_pose_file *out, const sheen_json *root, int width_px,
                                          int height_px, sheen_err *err)
{
    const reader r = {root, width_px, height_px, err};
    const sheen_json *frames;
    sheen_status s = sheen_json_array(root, "frames", &frames, err);
    for (size_t i = 0; !s && i < sheen_json_count(frames); i++) {
        s = read_frame(&r, out, sheen_json_at(frames, i), i);
        if (s)
            s = sheen_wrap(err, s, "frame %zu", i);
    }
    return s ? s : sheen_pose_file_check(out, err);
}

sheen_status sheen_transforms_parse(sheen_pose_file *out, const void *data, size_t size_bytes, sheen_err *err)
{
    *out = (sheen_pose_file){0};
    sheen_json *root = NULL;
    sheen_status s = sheen_json_parse(&root, data, size_bytes, err);
    if (!s)
        s = sheen_transforms_parse_sized(out, root, 0, 0, err);
    sheen_json_free(&root);
    if (s)
        sheen_pose_file_release(out);
    return s;
}

static void put_camera(sheen_json_writer *w, const sheen_camera *cam)
{
    static const char *const names[] = {"fl_x", "fl_y", "cx", "cy", "k1", "k2", "p1", "p2"};
    sheen_json_put_string(w, "camera_model", cam->n_intrinsics == 4 ? "PINHOLE" : "OPENCV");
    sheen_json_put_int(w, "w", cam->width_px);
    sheen_json_put_int(w, "h", cam->height_px);
    for (int i = 0; i < cam->n_intrinsics; i++)
        sheen_json_put_number(w, names[i], cam->intrinsics[i] + (i == 2 || i == 3 ? 0.5 : 0));
}

static void put_view(sheen_json_writer *w, const sheen_view *view)
{
    sheen_Rt Rt;
    sheen_Rt_from_rt(&Rt, view->rt_cam_world);
    sheen_Rt_invert(&Rt, &Rt);
    sheen_json_open(w, NULL, '{');
    sheen_json_put_string(w, "file_path", view->file[0] ? view->file : view->name);
    sheen_json_open(w, "transform_matrix", '[');
    for (int i = 0; i < 3; i++) {
        const double row[4] = {Rt.R[i][0], -Rt.R[i][1], -Rt.R[i][2], Rt.t[i]};
        sheen_json_put_numbers(w, NULL, row, 4);
    }
    static const double last_row[4] = {0, 0, 0, 1};
    sheen_json_put_numbers(w, NULL, last_row, 4);
    sheen_json_close(w);
    sheen_json_close(w);
}

bool sheen_transforms_holds(const sheen_camera *cam)
{
    return !strcmp(cam->lensmodel, "LENSMODEL_PINHOLE") || !strcmp(cam->lensmodel, "LENSMODEL_OPENCV4");
}

sheen_status sheen_transforms_save(const char *path, const sheen_camera *cam, const sheen_view *views,
                                   size_t n_views, sheen_err *err)
{
    if (!sheen_transforms_holds(cam))
        return sheen_fail(err, SHEEN_EUNSUP,
                          "cannot write '%s': transforms.json has no place for the lens model '%s'", path,
                          cam->lensmodel);
    const sheen_status s = sheen_camera_check(cam, err);
    if (s)
        return sheen_wrap(err, s, "cannot write '%s'", path);
    sheen_json_writer w = {0};
    sheen_json_open(&w, NULL, '{');
    put_camera(&w, cam);
    sheen_json_open(&w, "frames", '[');
    for (size_t i = 0; i < n_views; i++)
        put_view(&w, &views[i]);
    sheen_json_close(&w);
    sheen_json_close(&w);
    return sheen_json_save(&w, path, err);
}

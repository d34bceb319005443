// SPDX-License-Identifier: Apache-2.0
// camera_export.c - writes a camera with a pinhole core and OpenCV's distortion in the words of other programs.
#include "base/camera_export.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "base/file.h"

enum { TEXT_BYTES = 4096, NUMBERS_BYTES = 400, MAX_DISTORTION = 8 };

static const struct {
    const char *ending;
    sheen_camera_format format;
} endings[] = {{".opencv.yaml", SHEEN_CAMERA_OPENCV},
               {".ros.yaml", SHEEN_CAMERA_ROS},
               {".kalibr.yaml", SHEEN_CAMERA_KALIBR},
               {".colmap.txt", SHEEN_CAMERA_COLMAP}};

sheen_status sheen_camera_format_of(sheen_camera_format *out, const char *path, sheen_err *err)
{
    const size_t length = strlen(path);
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++) {
        const size_t n = strlen(endings[i].ending);
        if (length > n && !strcasecmp(path + length - n, endings[i].ending)) {
            *out = endings[i].format;
            return SHEEN_OK;
        }
    }
    return sheen_fail(err, SHEEN_EARG,
                      "'%s' is no kind of camera file: end it in .cameramodel, .opencv.yaml, .ros.yaml, "
                      ".kalibr.yaml or .colmap.txt",
                      path);
}

// k1 k2 p1 p2 k3 k4 k5 k6 of OpenCV's models, -1 for any other lens.
static int distortion_of(double k[MAX_DISTORTION], const sheen_camera *camera)
{
    static const struct {
        const char *name;
        int n;
    } models[] = {{"LENSMODEL_PINHOLE", 0},
                  {"LENSMODEL_OPENCV4", 4},
                  {"LENSMODEL_OPENCV5", 5},
                  {"LENSMODEL_OPENCV8", 8}};
    for (size_t i = 0; i < sizeof models / sizeof *models; i++)
        if (!strcmp(camera->lensmodel, models[i].name)) {
            memset(k, 0, MAX_DISTORTION * sizeof *k);
            memcpy(k, camera->intrinsics + 4, (size_t)models[i].n * sizeof *k);
            return models[i].n;
        }
    return -1;
}

// "1, 2, 3"
static const char *join(char out[NUMBERS_BYTES], const double *x, int n, const char *separator)
{
    size_t used = 0;
    out[0] = 0;
    for (int i = 0; i < n && used < NUMBERS_BYTES - 40; i++)
        used += (size_t)snprintf(out + used, NUMBERS_BYTES - used, "%s%.17g", i ? separator : "", x[i]);
    return out;
}

static int write_yaml(char *text, const sheen_camera *c, const double *k, int n, bool ros)
{
    char numbers[NUMBERS_BYTES];
    const double *f = c->intrinsics;
    const int n_written = n <= 5 ? 5 : 8;
    const char *matrix = ros ? "" : " !!opencv-matrix", *type = ros ? "" : "   dt: d\n";
    int used = snprintf(text, TEXT_BYTES,
                        "%simage_width: %d\nimage_height: %d\n%scamera_matrix:%s\n   rows: 3\n   cols: 3\n%s"
                        "   data: [%.17g, 0., %.17g, 0., %.17g, %.17g, 0., 0., 1.]\n",
                        ros ? "" : "%YAML:1.0\n---\n", c->width_px, c->height_px,
                        ros ? "camera_name: camera\n" : "", matrix, type, f[0], f[2], f[1], f[3]);
    if (ros)
        used += snprintf(text + used, (size_t)(TEXT_BYTES - used), "distortion_model: %s\n",
                         n <= 5 ? "plumb_bob" : "rational_polynomial");
    used += snprintf(text + used, (size_t)(TEXT_BYTES - used),
                     "distortion_coefficients:%s\n   rows: 1\n   cols: %d\n%s   data: [%s]\n", matrix,
                     n_written, type, join(numbers, k, n_written, ", "));
    if (ros)
        used += snprintf(
            text + used, (size_t)(TEXT_BYTES - used),
            "rectification_matrix:\n   rows: 3\n   cols: 3\n"
            "   data: [1., 0., 0., 0., 1., 0., 0., 0., 1.]\nprojection_matrix:\n   rows: 3\n   cols: 4\n"
            "   data: [%.17g, 0., %.17g, 0., 0., %.17g, %.17g, 0., 0., 0., 1., 0.]\n",
            f[0], f[2], f[1], f[3]);
    return used;
}

static int write_kalibr(char *text, const sheen_camera *c, const double *k)
{
    char core[NUMBERS_BYTES], distortion[NUMBERS_BYTES];
    return snprintf(text, TEXT_BYTES,
                    "cam0:\n  camera_model: pinhole\n  intrinsics: [%s]\n  distortion_model: radtan\n"
                    "  distortion_coeffs: [%s]\n  resolution: [%d, %d]\n  rostopic: /cam0/image_raw\n",
                    join(core, c->intrinsics, 4, ", "), join(distortion, k, 4, ", "), c->width_px,
                    c->height_px);
}

static int write_colmap(char *text, const sheen_camera *c, const double *k, int n)
{
    char core[NUMBERS_BYTES], distortion[NUMBERS_BYTES];
    const double f[4] = {c->intrinsics[0], c->intrinsics[1], c->intrinsics[2] + 0.5, c->intrinsics[3] + 0.5};
    return snprintf(text, TEXT_BYTES, "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n1 %s %d %d %s%s%s\n",
                    n == 0   ? "PINHOLE"
                    : n <= 4 ? "OPENCV"
                             : "FULL_OPENCV",
                    c->width_px, c->height_px, join(core, f, 4, " "), n ? " " : "",
                    join(distortion, k,
                         n == 0   ? 0
                         : n <= 4 ? 4
                                  : 8,
                         " "));
}

sheen_status sheen_camera_export(const sheen_camera *camera, sheen_camera_format format, const char *path,
                                 sheen_err *err)
{
    char text[TEXT_BYTES];
    double k[MAX_DISTORTION];
    int used;
    const int n = distortion_of(k, camera);
    if (n < 0)
        return sheen_fail(
            err, SHEEN_EUNSUP,
            "'%s' cannot hold a lens of the model %.60s: calibrate with --model opencv4, opencv5 or "
            "opencv8",
            path, camera->lensmodel);
    if (format == SHEEN_CAMERA_KALIBR && n > 4)
        return sheen_fail(err, SHEEN_EUNSUP,
                          "'%s' cannot hold a lens of %d coefficients: calibrate with --model opencv4", path,
                          n);
    if (format == SHEEN_CAMERA_KALIBR)
        used = write_kalibr(text, camera, k);
    else if (format == SHEEN_CAMERA_COLMAP)
        used = write_colmap(text, camera, k, n);
    else
        used = write_yaml(text, camera, k, n, format == SHEEN_CAMERA_ROS);
    return sheen_file_write(path, text, (size_t)used, err);
}

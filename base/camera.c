// SPDX-License-Identifier: Apache-2.0
// camera.c - cameras made from numbers, and .cameramodel files written with all digits.
#include "base/camera.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/camera_private.h"
#include "base/file.h"
#include "base/image.h"
#include "base/text.h"

#define SHEEN_CAMERA_TAKEN_BY "# taken by: "

sheen_status sheen_camera_opencv(sheen_camera *cam, int width_px, int height_px, const double fxycxy[4],
                                 const double *distortion, int n_distortion, sheen_err *err)
{
    static const struct {
        int n;
        const char *name;
    } models[] = {{0, "LENSMODEL_PINHOLE"},
                  {4, "LENSMODEL_OPENCV4"},
                  {5, "LENSMODEL_OPENCV5"},
                  {8, "LENSMODEL_OPENCV8"},
                  {12, "LENSMODEL_OPENCV12"}};
    const char *name = NULL;
    for (size_t i = 0; i < sizeof models / sizeof *models; i++)
        if (models[i].n == n_distortion)
            name = models[i].name;
    if (!name)
        return sheen_fail(err, SHEEN_EARG,
                          "no lens model has %d distortion coefficients (0, 4, 5, 8 and 12 do)",
                          n_distortion);
    *cam = (sheen_camera){.n_intrinsics = 4 + n_distortion, .width_px = width_px, .height_px = height_px};
    snprintf(cam->lensmodel, sizeof cam->lensmodel, "%s", name);
    memcpy(cam->intrinsics, fxycxy, 4 * sizeof *fxycxy);
    if (n_distortion)
        memcpy(cam->intrinsics + 4, distortion, (size_t)n_distortion * sizeof *distortion);
    const sheen_status s = sheen_camera_check(cam, err);
    if (err && s)
        err->code = SHEEN_EARG;
    return s ? SHEEN_EARG : SHEEN_OK;
}

sheen_status sheen_camera_scale(sheen_camera *out, const sheen_camera *cam, double factor, sheen_err *err)
{
    if (strstr(cam->lensmodel, "SPLINED"))
        return sheen_fail(err, SHEEN_EUNSUP,
                          "a splined lens model cannot be scaled: render at its own %d x %d", cam->width_px,
                          cam->height_px);
    if (!(factor > 0) || !isfinite(factor))
        return sheen_fail(err, SHEEN_EARG, "cannot scale a camera by %g", factor);
    *out = *cam;
    out->width_px = (int)lround(cam->width_px * factor);
    out->height_px = (int)lround(cam->height_px * factor);
    for (int i = 0; i < 2; i++) {
        out->intrinsics[i] = cam->intrinsics[i] * factor;
        out->intrinsics[2 + i] = (cam->intrinsics[2 + i] + 0.5) * factor - 0.5;
    }
    return sheen_camera_check(out, err);
}

// From the comment that sheen_camera_save writes.
static void read_taken_by(sheen_camera *cam, const char *data, size_t size_bytes)
{
    const size_t length = sizeof SHEEN_CAMERA_TAKEN_BY - 1;
    for (const char *at = data, *end = data + size_bytes; at < end;) {
        const char *line_end = memchr(at, '\n', (size_t)(end - at));
        const size_t n = (size_t)((line_end ? line_end : end) - at);
        if (n > length && !memcmp(at, SHEEN_CAMERA_TAKEN_BY, length)) {
            const size_t n_text = n - length < sizeof cam->taken_by ? n - length : sizeof cam->taken_by - 1;
            memcpy(cam->taken_by, at + length, n_text);
            cam->taken_by[n_text] = 0;
            return;
        }
        at += n + 1;
    }
}

sheen_status sheen_camera_parse(sheen_camera *cam, const void *data, size_t size_bytes, sheen_err *err)
{
    const sheen_status s = sheen_camera_parse_mrcal(cam, data, size_bytes, err);
    if (!s)
        read_taken_by(cam, data, size_bytes);
    return s;
}

sheen_status sheen_camera_load(sheen_camera *cam, const char *path, sheen_err *err)
{
    uint8_t *data;
    size_t size_bytes;
    sheen_status s = sheen_file_read(&data, &size_bytes, path, (size_t)64 << 20, err);
    if (s)
        return s;
    s = sheen_camera_parse(cam, data, size_bytes, err);
    free(data);
    return s ? sheen_wrap(err, s, "cannot read '%s'", path) : SHEEN_OK;
}

static void add_numbers(sheen_text *t, const char *key, const double *x, int n)
{
    sheen_text_put(t, "    '%s': [", key);
    for (int i = 0; i < n; i++)
        sheen_text_put(t, " %.17g,", x[i]);
    sheen_text_put(t, "],\n");
}

static void add_extras(sheen_text *t, const sheen_camera_extras *extras)
{
    if (extras->n_region) {
        sheen_text_put(t, "\n    'valid_intrinsics_region': [\n");
        for (size_t i = 0; i < extras->n_region; i++)
            sheen_text_put(t, "    [ %.10g, %.10g ],\n", extras->region_px[2 * i],
                           extras->region_px[2 * i + 1]);
        sheen_text_put(t, "    ],\n");
    }
    if (extras->optimization_inputs)
        sheen_text_put(
            t,
            "\n    # the solve that made this camera, for mrcal's tools: it holds as long as the intrinsics "
            "do\n"
            "    'icam_intrinsics': 0,\n    'optimization_inputs': b'%s',\n",
            extras->optimization_inputs);
}

// mrcal 2.2's own writer keeps six decimals, which is too few for tangential distortion.
sheen_status sheen_camera_save_with(const sheen_camera *cam, const sheen_camera_extras *extras,
                                    const char *path, sheen_err *err)
{
    const sheen_status s = sheen_camera_check(cam, err);
    if (s)
        return s;
    sheen_text t = {0};
    if (cam->taken_by[0])
        sheen_text_put(&t, "%s%s\n", SHEEN_CAMERA_TAKEN_BY, cam->taken_by);
    if (extras->note)
        sheen_text_put(&t, "# %.500s\n", extras->note);
    sheen_text_put(&t, "{\n    'lensmodel':  '%s',\n\n", cam->lensmodel);
    sheen_text_put(&t, "    # intrinsics are fx,fy,cx,cy,distortion0,distortion1,....\n");
    add_numbers(&t, "intrinsics", cam->intrinsics, cam->n_intrinsics);
    sheen_text_put(&t, "\n    # extrinsics are rt_fromref\n");
    add_numbers(&t, "extrinsics", cam->rt_cam_ref, 6);
    sheen_text_put(&t, "\n    'imagersize': [ %d, %d,],\n", cam->width_px, cam->height_px);
    add_extras(&t, extras);
    sheen_text_put(&t, "}\n");
    return sheen_text_save(&t, path, err);
}

sheen_status sheen_camera_save(const sheen_camera *cam, const char *path, sheen_err *err)
{
    const sheen_camera_extras none = {0};
    return sheen_camera_save_with(cam, &none, path, err);
}

// SPDX-License-Identifier: Apache-2.0
// camera_mrcal.c - lens models through libmrcal: one of the two files that include it.
#include "base/camera.h"

#include <limits.h>
#include <math.h>
#include <mrcal/mrcal.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/camera_private.h"
#include "base/image.h"
#include "base/quiet.h"
#include "base/vec.h"

_Static_assert(sizeof(mrcal_point2_t) == 2 * sizeof(double), "arrays of points are arrays of numbers");
_Static_assert(sizeof(mrcal_point3_t) == 3 * sizeof(double), "arrays of points are arrays of numbers");

static bool lens_of(mrcal_lensmodel_t *lens, const sheen_camera *cam)
{
    return mrcal_lensmodel_from_name(lens, cam->lensmodel);
}

sheen_status sheen_camera_check(const sheen_camera *cam, sheen_err *err)
{
    mrcal_lensmodel_t lens;
    const int token = sheen_quiet_begin(); // mrcal says what it dislikes about a name
    const bool known = memchr(cam->lensmodel, 0, sizeof cam->lensmodel) && lens_of(&lens, cam);
    sheen_quiet_end(token);
    if (!known)
        return sheen_fail(err, SHEEN_EFORMAT, "unknown lens model '%.80s'", cam->lensmodel);
    const int n = mrcal_lensmodel_num_params(&lens);
    if (n < 4 || n > SHEEN_CAMERA_MAX_INTRINSICS)
        return sheen_fail(err, SHEEN_EFORMAT, "lens model '%s' has %d parameters, which is out of range",
                          cam->lensmodel, n);
    if (cam->n_intrinsics != n)
        return sheen_fail(err, SHEEN_EFORMAT, "lens model '%s' has %d parameters, not %d", cam->lensmodel, n,
                          cam->n_intrinsics);
    for (int i = 0; i < n; i++)
        if (!isfinite(cam->intrinsics[i]))
            return sheen_fail(err, SHEEN_EFORMAT, "a parameter of the camera's lens is not a finite number");
    for (int i = 0; i < 6; i++)
        if (!isfinite(cam->rt_cam_ref[i]))
            return sheen_fail(err, SHEEN_EFORMAT, "the camera's pose is not finite");
    if (!(cam->intrinsics[0] > 0 && cam->intrinsics[1] > 0))
        return sheen_fail(err, SHEEN_EFORMAT, "the camera's focal length %g x %g px is not positive",
                          cam->intrinsics[0], cam->intrinsics[1]);
    if (cam->width_px < 1 || cam->height_px < 1 || cam->width_px > SHEEN_IMAGE_MAX_SIDE_PX ||
        cam->height_px > SHEEN_IMAGE_MAX_SIDE_PX)
        return sheen_fail(err, SHEEN_EFORMAT, "the camera's image size %d x %d px is out of range",
                          cam->width_px, cam->height_px);
    return SHEEN_OK;
}

// mrcal takes and gives arrays of its own point types, which hold nothing but their numbers.
static mrcal_point2_t *points2(double *x)
{
    return (mrcal_point2_t *)(void *)x;
}

static mrcal_point3_t *points3(double *x)
{
    return (mrcal_point3_t *)(void *)x;
}

sheen_status sheen_camera_project(const sheen_camera *cam, double *q_px, double *dq_dp, const double *p_cam,
                                  size_t n, sheen_err *err)
{
    mrcal_lensmodel_t lens;
    if (!lens_of(&lens, cam))
        return sheen_fail(err, SHEEN_EARG, "unknown lens model '%.80s'", cam->lensmodel);
    if (n > INT_MAX)
        return sheen_fail(err, SHEEN_EARG, "too many points to project: %zu", n);
    const mrcal_lensmodel_metadata_t meta = mrcal_lensmodel_metadata(&lens);
    const mrcal_point3_t *p = (const mrcal_point3_t *)(const void *)p_cam;
    bool ok = true;
    if (!dq_dp)
        ok = mrcal_project(points2(q_px), NULL, NULL, p, (int)n, &lens, cam->intrinsics);
    // one by one: mrcal 2.2 puts the gradient of every point of an OpenCV model into the first one's place
    for (size_t i = 0; dq_dp && ok && i < n; i++)
        ok = mrcal_project(points2(q_px) + i, points3(dq_dp) + 2 * i, NULL, p + i, 1, &lens, cam->intrinsics);
    if (!ok)
        return sheen_fail(err, SHEEN_EARG, "the lens model '%s' could not project", cam->lensmodel);
    if (!meta.can_project_behind_camera)
        for (size_t i = 0; i < n; i++)
            if (!(p_cam[3 * i + 2] > 0))
                q_px[2 * i] = q_px[2 * i + 1] = NAN;
    return SHEEN_OK;
}

sheen_status sheen_camera_unproject(const sheen_camera *cam, double *v_cam, const double *q_px, size_t n,
                                    sheen_err *err)
{
    mrcal_lensmodel_t lens;
    if (!lens_of(&lens, cam))
        return sheen_fail(err, SHEEN_EARG, "unknown lens model '%.80s'", cam->lensmodel);
    if (n > INT_MAX)
        return sheen_fail(err, SHEEN_EARG, "too many points to unproject: %zu", n);
    const mrcal_point2_t *q = (const mrcal_point2_t *)(const void *)q_px;
    if (!mrcal_unproject(points3(v_cam), q, (int)n, &lens, cam->intrinsics))
        return sheen_fail(err, SHEEN_EARG, "the lens model '%s' could not unproject", cam->lensmodel);
    for (size_t i = 0; i < n; i++)
        sheen_normalize(v_cam + 3 * i);
    return SHEEN_OK;
}

sheen_status sheen_camera_parse_mrcal(sheen_camera *cam, const void *data, size_t size_bytes, sheen_err *err)
{
    *cam = (sheen_camera){0};
    // mrcal's parser takes a length of 0 for "up to a NUL"
    if (!size_bytes || size_bytes > INT_MAX || memchr(data, 0, size_bytes))
        return sheen_fail(err, SHEEN_EFORMAT, "not a .cameramodel: it is empty or not a text");
    const int token = sheen_quiet_begin();
    mrcal_cameramodel_t *m = mrcal_read_cameramodel_string(data, (int)size_bytes);
    sheen_quiet_end(token);
    if (!m)
        return sheen_fail(err, SHEEN_EFORMAT, "not a .cameramodel as mrcal writes it");
    sheen_status s = SHEEN_OK;
    const int n = mrcal_lensmodel_num_params(&m->lensmodel);
    if (n < 4 || n > SHEEN_CAMERA_MAX_INTRINSICS ||
        !mrcal_lensmodel_name(cam->lensmodel, (int)sizeof cam->lensmodel, &m->lensmodel)) {
        s = sheen_fail(err, SHEEN_EFORMAT, "its lens model has %d parameters, which is out of range", n);
        goto done;
    }
    cam->n_intrinsics = n;
    memcpy(cam->intrinsics, m->intrinsics, (size_t)n * sizeof *cam->intrinsics);
    memcpy(cam->rt_cam_ref, m->rt_cam_ref, sizeof cam->rt_cam_ref);
    if (m->imagersize[0] <= INT_MAX && m->imagersize[1] <= INT_MAX) {
        cam->width_px = (int)m->imagersize[0];
        cam->height_px = (int)m->imagersize[1];
    }
    s = sheen_camera_check(cam, err);

done:
    mrcal_free_cameramodel(&m);
    return s;
}

// SPDX-License-Identifier: Apache-2.0
// camera_undistort.c - what a pinhole would have photographed from the same place.
#include "base/camera_undistort.h"

#include <stdlib.h>

#include "base/parallel.h"

typedef struct job {
    sheen_image *out;
    const sheen_image *img;
    const sheen_camera *cam, *pinhole;
    sheen_status status; // of any row; every writer writes the same
} job;

static void undistort_rows(void *self, size_t begin, size_t end)
{
    job *j = self;
    const size_t width = (size_t)j->out->width_px;
    double *p = malloc(3 * width * sizeof *p), *q_px = malloc(2 * width * sizeof *q_px);
    const double *k = j->pinhole->intrinsics;
    for (size_t y = begin; y < end; y++) {
        sheen_err ignored;
        for (size_t x = 0; p && q_px && x < width; x++) {
            p[3 * x] = ((double)x - k[2]) / k[0];
            p[3 * x + 1] = ((double)y - k[3]) / k[1];
            p[3 * x + 2] = 1;
        }
        if (!p || !q_px || sheen_camera_project(j->cam, q_px, NULL, p, width, &ignored)) {
            j->status = SHEEN_ENOMEM;
            break;
        }
        for (size_t x = 0; x < width; x++) // outside of the photograph: stays black
            (void)sheen_image_bilinear(sheen_image_at(j->out, (int)x, (int)y), j->img, q_px[2 * x],
                                       q_px[2 * x + 1]);
    }
    free(p);
    free(q_px);
}

sheen_status sheen_image_undistort(sheen_image *out, const sheen_image *img, const sheen_camera *cam,
                                   const sheen_camera *pinhole, int n_threads, sheen_err *err)
{
    sheen_status s = sheen_camera_check(cam, err);
    if (s)
        return s;
    if (img->width_px != cam->width_px || img->height_px != cam->height_px || pinhole->n_intrinsics != 4)
        return sheen_fail(err, SHEEN_EARG, "a picture of %d x %d px is not of this camera", img->width_px,
                          img->height_px);
    s = sheen_image_init(out, pinhole->width_px, pinhole->height_px, img->n_channels, err);
    if (s)
        return s;
    job j = {.out = out, .img = img, .cam = cam, .pinhole = pinhole, .status = SHEEN_OK};
    sheen_parallel_for((size_t)out->height_px, 16, n_threads, undistort_rows, &j);
    if (!j.status)
        return SHEEN_OK;
    sheen_image_release(out);
    return sheen_fail(err, j.status, "no memory left to straighten a picture");
}

// SPDX-License-Identifier: Apache-2.0
// pose_file_colmap_write.c - a COLMAP text model: cameras.txt, images.txt, points3D.txt (pixel centres at 0.5).
#include <math.h>
#include <string.h>

#include "base/file.h"
#include "base/pose3.h"
#include "base/pose_file.h"
#include "base/text.h"

static sheen_status save(sheen_text *t, const char *dir, const char *name, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    const sheen_status s = sheen_path_join(path, dir, name, err);
    if (!s)
        return sheen_text_save(t, path, err);
    sheen_text_release(t);
    return s;
}

// Unit quaternion w x y z, w >= 0, of a rotation (the largest of the four squares first, so that none is divided by little).
static void quaternion_of(double q[4], double R[3][3])
{
    const double squares[4] = {1 + R[0][0] + R[1][1] + R[2][2], 1 + R[0][0] - R[1][1] - R[2][2],
                               1 - R[0][0] + R[1][1] - R[2][2], 1 - R[0][0] - R[1][1] + R[2][2]};
    int best = 0;
    for (int i = 1; i < 4; i++)
        best = squares[i] > squares[best] ? i : best;
    const double twice[4][4] = {
        {squares[0], R[2][1] - R[1][2], R[0][2] - R[2][0], R[1][0] - R[0][1]},
        {R[2][1] - R[1][2], squares[1], R[0][1] + R[1][0], R[0][2] + R[2][0]},
        {R[0][2] - R[2][0], R[0][1] + R[1][0], squares[2], R[1][2] + R[2][1]},
        {R[1][0] - R[0][1], R[0][2] + R[2][0], R[1][2] + R[2][1], squares[3]},
    };
    const double scale = (twice[best][0] < 0 ? -0.5 : 0.5) / sqrt(squares[best]);
    for (int i = 0; i < 4; i++)
        q[i] = scale * twice[best][i];
}

// COLMAP's models that hold a lens of ours: what a smaller one lacks is zero.
static const struct lens {
    const char *ours, *name;
    int n_parameters;
} lenses[] = {{"LENSMODEL_PINHOLE", "PINHOLE", 4},
              {"LENSMODEL_OPENCV4", "OPENCV", 8},
              {"LENSMODEL_OPENCV5", "FULL_OPENCV", 12},
              {"LENSMODEL_OPENCV8", "FULL_OPENCV", 12}};

static const struct lens *lens_of(const sheen_camera *cam)
{
    for (size_t i = 0; i < sizeof lenses / sizeof *lenses; i++)
        if (!strcmp(cam->lensmodel, lenses[i].ours))
            return &lenses[i];
    return NULL;
}

bool sheen_colmap_holds(const sheen_camera *cam)
{
    return lens_of(cam) != NULL;
}

static sheen_status save_camera(const char *dir, const sheen_camera *cam, const struct lens *lens,
                                sheen_err *err)
{
    sheen_text t = {0};
    sheen_text_put(&t, "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n1 %s %d %d", lens->name, cam->width_px,
                   cam->height_px);
    for (int i = 0; i < lens->n_parameters; i++)
        sheen_text_put(&t, " %.17g",
                       i >= cam->n_intrinsics ? 0 : cam->intrinsics[i] + (i == 2 || i == 3 ? 0.5 : 0));
    sheen_text_put(&t, "\n");
    return save(&t, dir, "cameras.txt", err);
}

static sheen_status save_views(const char *dir, const sheen_view *views, size_t n_views, sheen_err *err)
{
    sheen_text t = {0};
    sheen_text_put(&t, "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, and a line of POINTS2D[] (none)\n");
    for (size_t i = 0; i < n_views; i++) {
        sheen_Rt Rt;
        double q[4];
        sheen_Rt_from_rt(&Rt, views[i].rt_cam_world);
        quaternion_of(q, Rt.R);
        sheen_text_put(&t, "%zu %.17g %.17g %.17g %.17g %.17g %.17g %.17g 1 %s\n\n", i + 1, q[0], q[1], q[2],
                       q[3], Rt.t[0], Rt.t[1], Rt.t[2], views[i].file[0] ? views[i].file : views[i].name);
    }
    return save(&t, dir, "images.txt", err);
}

static sheen_status save_points(const char *dir, const float *p_world, const uint8_t *rgb, size_t n,
                                sheen_err *err)
{
    sheen_text t = {0};
    sheen_text_put(&t, "# POINT3D_ID X Y Z R G B ERROR TRACK[] (none)\n");
    for (size_t i = 0; i < n; i++)
        sheen_text_put(&t, "%zu %.9g %.9g %.9g %d %d %d 0\n", i + 1, (double)p_world[3 * i],
                       (double)p_world[3 * i + 1], (double)p_world[3 * i + 2], rgb[3 * i], rgb[3 * i + 1],
                       rgb[3 * i + 2]);
    return save(&t, dir, "points3D.txt", err);
}

sheen_status sheen_colmap_save(const char *dir, const sheen_camera *cam, const sheen_view *views,
                               size_t n_views, const float *p_world, const uint8_t *rgb, size_t n_points,
                               sheen_err *err)
{
    const struct lens *lens = lens_of(cam);
    if (!lens)
        return sheen_fail(err, SHEEN_EUNSUP, "cannot write '%s': COLMAP has no name for the lens model '%s'",
                          dir, cam->lensmodel);
    sheen_status s = sheen_camera_check(cam, err);
    if (!s)
        s = sheen_dir_make(dir, err);
    if (!s)
        s = save_camera(dir, cam, lens, err);
    if (!s)
        s = save_views(dir, views, n_views, err);
    return s ? s : save_points(dir, p_world, rgb, n_points, err);
}

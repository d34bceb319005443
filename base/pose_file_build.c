// SPDX-License-Identifier: Apache-2.0
// pose_file_build.c - lists of views and cameras that grow as a file is read, and the checks on both.
#include "base/pose_file_build.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"

enum { MAX_VIEWS = 100000, MAX_CAMERAS = 10000 };

void sheen_pose_file_release(sheen_pose_file *p)
{
    free(p->views);
    free(p->cameras);
    *p = (sheen_pose_file){0};
}

// Capacities are the powers of two: full exactly when the count is one.
static bool grow(void **list, size_t count, size_t item_bytes)
{
    if (count & (count - 1))
        return true;
    void *grown = realloc(*list, (count ? 2 * count : 1) * item_bytes);
    if (grown)
        *list = grown;
    return grown != NULL;
}

sheen_status sheen_pose_file_add_view(sheen_pose_file *p, const char *file, size_t length,
                                      const char *fallback, sheen_view **view_out, sheen_err *err)
{
    if (p->n_views == MAX_VIEWS)
        return sheen_fail(err, SHEEN_EFORMAT, "more than %d frames", MAX_VIEWS);
    void *views = p->views;
    const bool ok = grow(&views, p->n_views, sizeof *p->views);
    p->views = views;
    if (!ok)
        return sheen_fail_memory(err, (double)p->n_views * 2 * sizeof *p->views, "views");
    sheen_view *v = &p->views[p->n_views];
    *v = (sheen_view){.i_camera = -1};
    if (length >= sizeof v->file || memchr(file, 0, length))
        return sheen_fail(err, SHEEN_EFORMAT, "a file name is too long: '%.60s...'", file);
    memcpy(v->file, file, length);
    v->file[length] = 0;
    const char *name = length ? sheen_path_base(v->file) : fallback;
    const char *dot = length ? strrchr(name, '.') : NULL;
    const size_t n = dot && dot > name ? (size_t)(dot - name) : strlen(name);
    if (!n || n >= sizeof v->name)
        return sheen_fail(err, SHEEN_EFORMAT, "a file name is empty or too long: '%.60s'", v->file);
    memcpy(v->name, name, n);
    v->name[n] = 0;
    *view_out = v;
    p->n_views++;
    return SHEEN_OK;
}

sheen_status sheen_pose_file_add_camera(sheen_pose_file *p, const sheen_camera *cam, sheen_err *err)
{
    if (p->n_cameras == MAX_CAMERAS)
        return sheen_fail(err, SHEEN_EFORMAT, "more than %d cameras", MAX_CAMERAS);
    void *cameras = p->cameras;
    const bool ok = grow(&cameras, p->n_cameras, sizeof *p->cameras);
    p->cameras = cameras;
    if (!ok)
        return sheen_fail_memory(err, (double)p->n_cameras * 2 * sizeof *p->cameras, "cameras");
    p->cameras[p->n_cameras++] = *cam;
    return SHEEN_OK;
}

static int compare_names(const void *a, const void *b)
{
    const sheen_view *const *va = a, *const *vb = b;
    return strcmp((*va)->name, (*vb)->name);
}

sheen_status sheen_pose_file_check(const sheen_pose_file *p, sheen_err *err)
{
    if (!p->n_views)
        return sheen_fail(err, SHEEN_EFORMAT, "it holds no frame with a pose");
    const sheen_view **sorted = malloc(p->n_views * sizeof *sorted);
    if (!sorted)
        return sheen_fail_memory(err, (double)(p->n_views * sizeof *sorted), "views");
    for (size_t i = 0; i < p->n_views; i++)
        sorted[i] = &p->views[i];
    qsort(sorted, p->n_views, sizeof *sorted, compare_names);
    sheen_status s = SHEEN_OK;
    for (size_t i = 1; i < p->n_views && !s; i++)
        if (!strcmp(sorted[i - 1]->name, sorted[i]->name))
            s = sheen_fail(err, SHEEN_EFORMAT, "frame '%s' is there twice", sorted[i]->name);
    free(sorted);
    return s;
}

sheen_status sheen_camera_from_foreign(sheen_camera *cam, int width_px, int height_px, const double fxycxy[4],
                                       const double *distortion, int n_distortion, sheen_err *err)
{
    const double ours[4] = {fxycxy[0], fxycxy[1], fxycxy[2] - 0.5, fxycxy[3] - 0.5};
    const sheen_status s = sheen_camera_opencv(cam, width_px, height_px, ours, distortion, n_distortion, err);
    if (s != SHEEN_EARG)
        return s;
    if (err)
        err->code = SHEEN_EFORMAT;
    return SHEEN_EFORMAT;
}

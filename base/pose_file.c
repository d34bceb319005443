// SPDX-License-Identifier: Apache-2.0
// pose_file.c - pose and camera files of any kind: telling them apart, lists of views, and sheen's poses.json.
#include "base/pose_file.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/pose_file_build.h"

enum { MAX_FILE_BYTES = 256 << 20, MAX_VIEWS = 100000, MAX_CAMERAS = 10000 };

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

// A frame of poses.json; one without a pose is left out.
static sheen_status read_pose(sheen_pose_file *out, const sheen_json *frame, sheen_err *err)
{
    const char *name;
    double rt_cam_board[6];
    sheen_status s = sheen_json_string(frame, "name", &name, err);
    if (s || !sheen_json_get(frame, "rt_cam_board"))
        return s;
    s = sheen_json_numbers(frame, "rt_cam_board", rt_cam_board, 6, err);
    sheen_view *view = NULL;
    if (!s)
        s = sheen_pose_file_add_view(out, "", 0, name, &view, err);
    if (s)
        return s;
    assert(view);
    memcpy(view->rt_cam_world, rt_cam_board, sizeof rt_cam_board);
    return SHEEN_OK;
}

static sheen_status read_poses(sheen_pose_file *out, const sheen_json *root, sheen_err *err)
{
    const sheen_json *frames = NULL;
    sheen_status s = sheen_json_schema(root, "sheen-poses", 1, NULL, err);
    if (!s)
        s = sheen_json_array(root, "frames", &frames, err);
    for (size_t i = 0; i < sheen_json_count(frames) && !s; i++) {
        s = read_pose(out, sheen_json_at(frames, i), err);
        if (s)
            s = sheen_wrap(err, s, "frame %zu", i);
    }
    return s ? s : sheen_pose_file_check(out, err);
}

sheen_status sheen_poses_json_parse(sheen_pose_file *out, const void *data, size_t size_bytes, sheen_err *err)
{
    *out = (sheen_pose_file){0};
    sheen_json *root = NULL;
    sheen_status s = sheen_json_parse(&root, data, size_bytes, err);
    if (!s)
        s = read_poses(out, root, err);
    sheen_json_free(&root);
    if (s)
        sheen_pose_file_release(out);
    return s;
}

// A JSON file of either kind, told by its members.
static sheen_status load_json(sheen_pose_file *out, const char *path, sheen_err *err)
{
    uint8_t *data;
    size_t size_bytes;
    sheen_status s = sheen_file_read(&data, &size_bytes, path, MAX_FILE_BYTES, err);
    if (s)
        return s;
    sheen_json *root = NULL;
    s = sheen_json_parse(&root, data, size_bytes, err);
    if (!s && sheen_json_get(root, "schema"))
        s = read_poses(out, root, err);
    else if (!s && sheen_json_get(root, "frames"))
        s = sheen_transforms_parse_sized(out, root, 0, 0, err);
    else if (!s)
        s = sheen_fail(err, SHEEN_EFORMAT, "neither transforms.json nor poses.json: it has no list 'frames'");
    sheen_json_free(&root);
    free(data);
    return s ? sheen_wrap(err, s, "cannot read '%s'", path) : SHEEN_OK;
}

static sheen_status load_colmap(sheen_pose_file *out, const char *dir, sheen_err *err)
{
    char cameras_path[SHEEN_PATH_MAX], images_path[SHEEN_PATH_MAX];
    sheen_status s = sheen_path_join(cameras_path, dir, "cameras.bin", err);
    if (!s && sheen_file_exists(cameras_path)) {
        s = sheen_path_join(cameras_path, dir, "cameras.txt", err);
        if (!s && !sheen_file_exists(cameras_path))
            return sheen_fail(
                err, SHEEN_EUNSUP,
                "'%s' is a binary COLMAP model: convert it with 'colmap model_converter --output_type TXT'",
                dir);
    }
    uint8_t *cameras = NULL, *images = NULL;
    size_t cameras_bytes = 0, images_bytes = 0;
    if (!s)
        s = sheen_path_join(cameras_path, dir, "cameras.txt", err);
    if (!s)
        s = sheen_path_join(images_path, dir, "images.txt", err);
    if (!s)
        s = sheen_file_read(&cameras, &cameras_bytes, cameras_path, MAX_FILE_BYTES, err);
    if (!s)
        s = sheen_file_read(&images, &images_bytes, images_path, MAX_FILE_BYTES, err);
    if (!s) {
        s = sheen_colmap_parse(out, cameras, cameras_bytes, images, images_bytes, err);
        if (s)
            s = sheen_wrap(err, s, "cannot read the COLMAP model '%s'", dir);
    }
    free(cameras);
    free(images);
    return s;
}

sheen_status sheen_pose_file_load(sheen_pose_file *out, const char *path, sheen_err *err)
{
    *out = (sheen_pose_file){0};
    const sheen_status s = sheen_dir_exists(path) ? load_colmap(out, path, err) : load_json(out, path, err);
    if (s)
        sheen_pose_file_release(out);
    return s;
}

// The first character that is not blank and not in a comment ("#" to the end of the line); 0: none.
static char first_character(const uint8_t *data, size_t size_bytes)
{
    bool in_comment = false;
    for (size_t i = 0; i < size_bytes; i++) {
        const char c = (char)data[i];
        if (in_comment || c == '#')
            in_comment = c != '\n' && c != '\r';
        else if (c != ' ' && c != '\t' && c != '\n' && c != '\r')
            return c;
    }
    return 0;
}

static sheen_status one_camera(sheen_camera *cam, const sheen_camera *cameras, size_t n, sheen_err *err)
{
    if (n != 1)
        return sheen_fail(err, SHEEN_EFORMAT, "it holds %zu cameras: leave the one that is meant", n);
    *cam = *cameras;
    return SHEEN_OK;
}

static sheen_status parse_colmap_camera(sheen_camera *cam, const void *data, size_t size_bytes,
                                        sheen_err *err)
{
    sheen_camera *cameras = NULL;
    int *ids = NULL;
    size_t n = 0;
    sheen_status s = sheen_colmap_cameras_parse(&cameras, &ids, &n, data, size_bytes, err);
    if (!s)
        s = one_camera(cam, cameras, n, err);
    free(cameras);
    free(ids);
    return s;
}

static sheen_status parse_transforms_camera(sheen_camera *cam, const sheen_json *root, int width_px,
                                            int height_px, sheen_err *err)
{
    sheen_pose_file p = {0};
    sheen_status s = sheen_transforms_parse_sized(&p, root, width_px, height_px, err);
    if (!s)
        s = one_camera(cam, p.cameras, p.n_cameras, err);
    sheen_pose_file_release(&p);
    return s;
}

// Told by content: a .cameramodel names its lens model, of JSON there is one other kind, YAML begins with letters,
// COLMAP's lines with numbers.
static sheen_status parse_any(sheen_camera *cam, const uint8_t *data, size_t size_bytes, int width_px,
                              int height_px, sheen_err *err)
{
    const char first = first_character(data, size_bytes);
    if (!first)
        return sheen_fail(err, SHEEN_EFORMAT, "the file is empty");
    if (first >= '0' && first <= '9')
        return parse_colmap_camera(cam, data, size_bytes, err);
    if (first != '{')
        return sheen_opencv_yaml_parse(cam, data, size_bytes, width_px, height_px, err);
    if (strstr((const char *)data, "lensmodel")) // sheen_file_read ends the text with a NUL
        return sheen_camera_parse(cam, data, size_bytes, err);
    sheen_json *root = NULL;
    sheen_status s = sheen_json_parse(&root, data, size_bytes, err);
    if (!s)
        s = parse_transforms_camera(cam, root, width_px, height_px, err);
    sheen_json_free(&root);
    return s;
}

sheen_status sheen_camera_load_any(sheen_camera *cam, const char *path, int width_px, int height_px,
                                   sheen_err *err)
{
    *cam = (sheen_camera){0};
    uint8_t *data;
    size_t size_bytes;
    sheen_status s = sheen_file_read(&data, &size_bytes, path, MAX_FILE_BYTES, err);
    if (s)
        return s;
    s = parse_any(cam, data, size_bytes, width_px, height_px, err);
    free(data);
    return s ? sheen_wrap(err, s, "cannot read a camera from '%s'", path) : SHEEN_OK;
}

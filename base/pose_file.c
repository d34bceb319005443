// SPDX-License-Identifier: Apache-2.0
// pose_file.c - pose files of any kind: telling them apart, and sheen's own poses.json.
#include "base/pose_file.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/pose_file_build.h"

enum { MAX_FILE_BYTES = 256 << 20 };

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

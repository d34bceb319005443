// SPDX-License-Identifier: Apache-2.0
// camera_any.c - a camera from a file of any kind, told by its content.
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/pose_file_build.h"

enum { MAX_FILE_BYTES = 256 << 20 };

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

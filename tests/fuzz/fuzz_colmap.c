// SPDX-License-Identifier: Apache-2.0
// fuzz_colmap.c - any bytes as a COLMAP text model: cameras.txt up to the first line "====", images.txt after it.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose_file.h"

static size_t split(const uint8_t *data, size_t size_bytes)
{
    static const char mark[] = "====\n";
    const size_t n = sizeof mark - 1;
    for (size_t i = 0; i + n <= size_bytes; i++)
        if (!memcmp(data + i, mark, n))
            return i;
    return size_bytes;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    sheen_err err;
    sheen_pose_file p;
    const size_t at = split(data, size_bytes), images_at = at + 5 < size_bytes ? at + 5 : size_bytes;
    sheen_camera *cameras;
    int *ids;
    size_t n_cameras;
    if (!sheen_colmap_cameras_parse(&cameras, &ids, &n_cameras, data, at, &err) && !n_cameras)
        abort();
    free(cameras);
    free(ids);
    if (sheen_colmap_parse(&p, data, at, data + images_at, size_bytes - images_at, &err))
        return 0;
    for (size_t i = 0; i < p.n_views; i++) {
        if (p.views[i].i_camera < 0 || p.views[i].i_camera >= (int)p.n_cameras)
            abort();
        for (int k = 0; k < 6; k++)
            if (!isfinite(p.views[i].rt_cam_world[k]))
                abort();
    }
    sheen_pose_file_release(&p);
    return 0;
}

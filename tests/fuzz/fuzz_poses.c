// SPDX-License-Identifier: Apache-2.0
// fuzz_poses.c - any bytes as a file of poses, read by PARSE: what is read is finite and refers to what is there.
#include <math.h>
#include <stdlib.h>

#include "base/pose_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    sheen_err err;
    sheen_pose_file p;
    if (PARSE(&p, data, size_bytes, &err))
        return 0;
    if (!p.n_views)
        abort();
    for (size_t i = 0; i < p.n_views; i++) {
        if (p.views[i].i_camera >= (int)p.n_cameras || !p.views[i].name[0])
            abort();
        for (int k = 0; k < 6; k++)
            if (!isfinite(p.views[i].rt_cam_world[k]))
                abort();
    }
    sheen_pose_file_release(&p);
    return 0;
}

// SPDX-License-Identifier: Apache-2.0
// fuzz_session_poses.c - any bytes as a session's poses.json: names are good, each is there once and can be found.
#include <math.h>
#include <stdlib.h>

#include "base/session.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    sheen_poses p;
    sheen_err err;
    if (sheen_poses_parse(&p, data, size_bytes, &err))
        return 0;
    for (size_t i = 0; i < p.n_poses; i++) {
        const sheen_frame_pose *q = &p.poses[i];
        if (!sheen_frame_name_ok(q->name) || sheen_poses_find(&p, q->name) != q)
            abort();
        for (int k = 0; k < 6; k++)
            if (!isfinite(q->rt_cam_board[k]))
                abort();
    }
    sheen_poses_release(&p);
    return 0;
}

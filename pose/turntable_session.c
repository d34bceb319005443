// SPDX-License-Identifier: Apache-2.0
// turntable_session.c - a session's poses and commanded angles, put before turntable_axis.
#include "pose/turntable_session.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double RAD_PER_DEG = 3.14159265358979323846 / 180;

static sheen_status solve(sheen_session_turntable *out, sheen_turntable_pose *list, const sheen_session *s,
                          const sheen_poses *poses, sheen_err *err)
{
    size_t n = 0;
    for (size_t i = 0; i < poses->n_poses; i++) {
        const sheen_frame_pose *p = &poses->poses[i];
        const sheen_frame_info *f = sheen_session_find(s, p->name);
        if (!p->found)
            continue;
        memcpy(list[n].rt_cam_board, p->rt_cam_board, sizeof p->rt_cam_board);
        memcpy(list[n].covariance, p->covariance, sizeof p->covariance);
        out->frames[n] = p;
        out->asked_rad[n++] = f ? f->table_asked_deg * RAD_PER_DEG : (double)NAN;
    }
    return sheen_turntable_solve(&out->table, list, n, err);
}

sheen_status sheen_session_turntable_find(sheen_session_turntable *out, const sheen_session *s,
                                          const sheen_poses *poses, sheen_err *err)
{
    *out = (sheen_session_turntable){0};
    sheen_err why = {0};
    sheen_turntable_pose *list = calloc(poses->n_poses + 1, sizeof *list);
    out->frames = calloc(poses->n_poses + 1, sizeof *out->frames);
    out->asked_rad = calloc(poses->n_poses + 1, sizeof *out->asked_rad);
    sheen_status st = list && out->frames && out->asked_rad
                          ? solve(out, list, s, poses, err)
                          : sheen_fail_memory(err, (double)poses->n_poses * sizeof *list,
                                              "a turntable's views");
    free(list);
    if (!st) {
        out->has_gain = !sheen_turntable_compare(&out->gain, &out->table, out->asked_rad, &why);
        snprintf(out->reason, sizeof out->reason, "%.*s", (int)sizeof out->reason - 1, why.msg);
    } else
        sheen_session_turntable_release(out);
    return st;
}

void sheen_session_turntable_release(sheen_session_turntable *t)
{
    sheen_turntable_release(&t->table);
    free(t->frames);
    free(t->asked_rad);
    *t = (sheen_session_turntable){0};
}

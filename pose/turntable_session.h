// SPDX-License-Identifier: Apache-2.0
// turntable_session.h - the turntable of a session: from its frames' poses and the angles that were asked for.
#ifndef SHEEN_POSE_TURNTABLE_SESSION_H
#define SHEEN_POSE_TURNTABLE_SESSION_H

#include <stdbool.h>
#include <stddef.h>

#include "base/session.h"
#include "pose/turntable_axis.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_session_turntable {
    sheen_turntable table;
    const sheen_frame_pose **frames; // [table.n_views]: the pose of each view, lent by the poses given
    double *asked_rad;               // [table.n_views]: commanded angle; NaN: none is known
    bool has_gain; // false: too few commanded angles, or they are not followed (`reason` says)
    sheen_turntable_gain gain;
    char reason[160];
} sheen_session_turntable;

// Axis and angles from all frames that have a pose. `poses` must outlive *out. Errors as sheen_turntable_solve.
sheen_status sheen_session_turntable_find(sheen_session_turntable *out, const sheen_session *s,
                                          const sheen_poses *poses, sheen_err *err);
void sheen_session_turntable_release(sheen_session_turntable *t);

#ifdef __cplusplus
}
#endif
#endif

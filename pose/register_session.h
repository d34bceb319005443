// SPDX-License-Identifier: Apache-2.0
// register_session.h - a mesh into the board's frame of a session: from marks, from masks, or from both. Where the
// session has neither, masks are made of what hides the board (board_masks.h).
#ifndef SHEEN_POSE_REGISTER_SESSION_H
#define SHEEN_POSE_REGISTER_SESSION_H

#include "base/session.h"
#include "pose/register_points.h"
#include "pose/register_search.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SHEEN_SESSION_OVERLAYS "registration" // <frame>.png: the frame, the mesh's outline drawn into it

typedef struct sheen_register_session_options {
    const sheen_register_point *points; // NULL: from masks alone
    size_t n_points;
    sheen_register_options search;
} sheen_register_session_options;

typedef struct sheen_register_result {
    sheen_registration registration; // from masks; where there are none, placement and sigmas from the marks
    bool from_points, from_masks;
    bool masks_made;      // of what hides the board,
    size_t n_backgrounds; // and of what hides so many pictures without the object
    sheen_register_points_fit points;
    size_t n_masks, n_overlays;
} sheen_register_result;

// Finds the mesh's place in the session's input frames and writes the overlays; nothing else in the session changes.
// EDATA: no camera or poses, no masks nor marks and none can be made, or nothing fits; and what the parts say.
sheen_status sheen_register_in_session(sheen_register_result *out, const sheen_session *s,
                                       const sheen_mesh *mesh, const sheen_register_session_options *options,
                                       sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

// SPDX-License-Identifier: Apache-2.0
// session_private.h - what the session_*.c files share among themselves.
#ifndef SHEEN_BASE_SESSION_PRIVATE_H
#define SHEEN_BASE_SESSION_PRIVATE_H

#include "base/session.h"

// "mesh.ply", "mesh.obj", "mesh.glb", NULL: a session has at most one of them.
extern const char *const sheen_session_mesh_files[];

bool sheen_frame_extension_ok(const char *extension);
sheen_status sheen_frame_info_save(const sheen_frame_info *f, const char *path, sheen_err *err);

// Reads every sidecar in frames/ into s->frames (which must be empty), sorted by name.
sheen_status sheen_session_list_frames(sheen_session *s, sheen_err *err);

// Completes a commit that was interrupted (session_stage.c); does nothing where there is none.
sheen_status sheen_session_roll_forward(const sheen_session *s, sheen_err *err);

#endif

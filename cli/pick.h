// SPDX-License-Identifier: Apache-2.0
// pick.h - the page on which a person marks points of a mesh in frames: what it asks for, and the file that it fills.
#ifndef SHEEN_CLI_PICK_H
#define SHEEN_CLI_PICK_H

#include "base/mesh.h"
#include "base/session.h"
#include "cli/serve.h"

typedef struct sheen_pick sheen_pick;

// path: the file of marks, as sheen_register_points_parse takes it; one that is there is gone on with, and it is
// written anew after each change. up: one of SHEEN_UP_..., 0: z. unit_m: as sheen_register_points_solve takes it. All
// are lent. EDATA: the session has no frames with poses, or no camera; EUNSUP: this build has no pages.
sheen_status sheen_pick_open(sheen_pick **out, const sheen_session *s, const sheen_mesh *mesh,
                             const char *path, unsigned up, double unit_m, sheen_err *err);
void sheen_pick_close(sheen_pick **pick);
size_t sheen_pick_count(const sheen_pick *pick);

// A sheen_answering, for the page's
//   ""                                  itself
//   "frames"                            JSON: the frames' names and size, and the size of the mesh's pictures
//   "frame/I"                           the frame as it was taken, JPEG
//   "mesh/AZ/EL"                        the mesh seen from there (degrees), JPEG
//   "marks/AZ/EL"                       JSON: the marks, where that picture shows them, and how well they fit
//   "mark/I/X/Y/AZ/EL/U/V"              frame I shows at (X, Y) what that picture shows at (U, V)
//   "undo"                              forgets the last mark
// The last two answer {"ok": true}, or with a sentence: {"ok": false, "why": ...}.
void sheen_pick_answer(void *pick, const char *what, sheen_answer *to);

#endif

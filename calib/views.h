// SPDX-License-Identifier: Apache-2.0
// views.h - the board in many frames: all frames of a session or of a list of files, in parallel.
#ifndef SHEEN_CALIB_VIEWS_H
#define SHEEN_CALIB_VIEWS_H

#include <stddef.h>

#include "base/board.h"
#include "base/progress.h"
#include "base/session.h"
#include "calib/view.h"
#include "calib/vnl.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_views {
    sheen_board_view *views; // in the order of the frames
    size_t n_views;
} sheen_views;

void sheen_views_release(sheen_views *views);

// The board in n_frames frames of a session, given as pointers into s->frames. n_threads 0: one per processor;
// results do not depend on it. Fails with the sentence of the first frame that cannot be read; ECANCEL.
sheen_status sheen_views_of_session(sheen_views *out, const sheen_session *s,
                                    const sheen_frame_info *const *frames, size_t n_frames,
                                    const sheen_board *board, int n_threads, const sheen_progress *progress,
                                    sheen_err *err);

typedef struct sheen_views_options {
    int n_threads;
    const sheen_progress *progress;
    // Called with the views[n_boards] of each frame while its picture is at hand, from several threads at once; may add
    // to them. NULL: nothing more is looked for.
    sheen_status (*look)(const void *self, sheen_board_view *views, const uint8_t *grey, sheen_err *err);
    const void *self;
} sheen_views_options;

// The same for a set of boards: out->views[n_frames * boards->n_boards], all boards of a frame side by side.
sheen_status sheen_set_views_of_session(sheen_views *out, const sheen_session *s,
                                        const sheen_frame_info *const *frames, size_t n_frames,
                                        const sheen_board_set *boards, const sheen_views_options *options,
                                        sheen_err *err);
// The same of image files (sRGB); names are the files' names without folder and extension.
sheen_status sheen_views_of_files(sheen_views *out, const char *const *paths, size_t n_paths,
                                  const sheen_board *board, int n_threads, const sheen_progress *progress,
                                  sheen_err *err);

// The corners of a table for this board, of pictures of size_px[2]; without tags. EDATA: a corner beyond the picture.
sheen_status sheen_views_of_vnl(sheen_views *out, const sheen_vnl *vnl, const int size_px[2],
                                const sheen_board *board, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

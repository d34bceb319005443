// SPDX-License-Identifier: Apache-2.0
// session_masks.c - reads the pictures that board_masks.h wants; each background once.
#include "pose/session_masks.h"

#include <stdlib.h>
#include <string.h>

#include "pose/board_masks.h"

// Pictures of frames and of their backgrounds, with their poses.
typedef struct pictures {
    const sheen_session *session;
    const sheen_poses *poses;
    sheen_image *images;              // [2 n] frames, then backgrounds
    sheen_plane_view *views;          // [2 n]
    const sheen_frame_info **empties; // [n] whose backgrounds they are
    size_t n, n_empties;
} pictures;

static sheen_status read_view(pictures *p, size_t i, const sheen_frame_info *f, sheen_err *err)
{
    const sheen_frame_pose *pose = sheen_poses_find(p->poses, f->name);
    memcpy(p->views[i].rt_cam_board, pose->rt_cam_board, sizeof p->views[i].rt_cam_board);
    p->views[i].rgb = &p->images[i];
    return sheen_session_image(&p->images[i], p->session, f, err);
}

// The scene without the object as the camera of frame f saw it; NULL: not known.
static const sheen_frame_info *background_of(const pictures *p, const sheen_frame_info *f)
{
    const sheen_session *s = p->session;
    for (size_t i = 0; i < s->n_frames && s->moving == SHEEN_MOVING_OBJECT; i++) {
        const sheen_frame_info *b = &s->frames[i];
        const sheen_frame_pose *pose = sheen_poses_find(p->poses, b->name);
        if (b->role == SHEEN_ROLE_BACKGROUND && pose && pose->found &&
            sheen_frame_round(b) == sheen_frame_round(f) && b->width_px == f->width_px &&
            b->height_px == f->height_px)
            return b;
    }
    return NULL;
}

static sheen_status find_background(pictures *p, size_t i, const sheen_frame_info *frame, sheen_err *err)
{
    const sheen_frame_info *empty = background_of(p, frame);
    size_t k = 0;
    if (!empty)
        return SHEEN_OK;
    while (k < p->n_empties && p->empties[k] != empty)
        k++;
    p->views[i].empty = &p->views[p->n + k];
    if (k < p->n_empties)
        return SHEEN_OK;
    p->empties[p->n_empties++] = empty;
    return read_view(p, p->n + k, empty, err);
}

sheen_status sheen_session_masks_make(sheen_session_masks *out, const sheen_session *s,
                                      const sheen_camera *camera, const sheen_poses *poses,
                                      const sheen_frame_info *const *frames, size_t n_frames, int n_threads,
                                      sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    sheen_board board;
    pictures p = {.session = s, .poses = poses, .n = n_frames};
    out->n_backgrounds = 0;
    sheen_status st = sheen_session_path(path, s, SHEEN_SESSION_BOARD, err);
    if (st || (st = sheen_board_load(&board, path, err)))
        return st;
    p.images = calloc(2 * n_frames + 1, sizeof *p.images);
    p.views = calloc(2 * n_frames + 1, sizeof *p.views);
    p.empties = calloc(n_frames + 1, sizeof *p.empties);
    if (!p.images || !p.views || !p.empties)
        st = sheen_fail_memory(err, 300.0 * (double)n_frames, "masks");
    for (size_t i = 0; i < n_frames && !st; i++) {
        st = read_view(&p, i, frames[i], err);
        if (!st)
            st = find_background(&p, i, frames[i], err);
    }
    if (!st)
        st = sheen_board_masks_make(out->masks, camera, &board, p.views, n_frames,
                                    s->moving == SHEEN_MOVING_OBJECT, n_threads, err);
    out->n_backgrounds = p.n_empties;
    for (size_t i = 0; p.images && i < 2 * n_frames; i++)
        sheen_image_release(&p.images[i]);
    free(p.images);
    free(p.views);
    free(p.empties);
    sheen_board_release(&board);
    return st;
}

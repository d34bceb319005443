// SPDX-License-Identifier: Apache-2.0
// board_masks.h - masks of what stands on the board, from the photographs alone: what hides the board is the object.
#ifndef SHEEN_POSE_BOARD_MASKS_H
#define SHEEN_POSE_BOARD_MASKS_H

#include <stdbool.h>

#include "pose/plane_picture.h"

#ifdef __cplusplus
extern "C" {
#endif

// masks[n_views]: one channel of the camera's size, above 1/2 the object, below the plane that it stands on, NaN where that
// cannot be told: beyond the plane that plane_picture.h knows, and where object and board look the same. The views' picture
// without the object shows what stands still beyond the board, as do, where the board lay in it, views whose board has turned
// away from there; views that share one follow each other. Of what hides the
// plane the largest piece in each photograph is the object. turned: board and object turned together under lights that stood
// still, so that shadows wander over the board and its places change in brightness: what could be the plane in other light
// is not taken for the object. The caller releases them. EDATA: as plane_picture.h says; ENOMEM.
sheen_status sheen_board_masks_make(sheen_image *masks, const sheen_camera *camera, const sheen_board *board,
                                    const sheen_plane_view *views, size_t n_views, bool turned, int n_threads,
                                    sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

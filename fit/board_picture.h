// SPDX-License-Identifier: Apache-2.0
// board_picture.h - the radiance of the board and the table about the object, taken from the photographs themselves.
#ifndef SHEEN_FIT_BOARD_PICTURE_H
#define SHEEN_FIT_BOARD_PICTURE_H

#include "fit/photos.h"
#include "render/scene.h"
#include "render/surroundings.h"

// Fills board and table_rgb of *out: the plane z = 0 of world, a square about the object five of its radii to each side.
// A place is the median, channel by channel, of the photographs in which nothing hides it; where none shows it, it is
// filled from its neighbours. photos: of a camera that moved (world = board). ENOMEM; EDATA: no photograph shows the plane.
sheen_status sheen_board_picture_make(sheen_surroundings *out, const sheen_photos *photos,
                                      const sheen_mesh *mesh, const sheen_scene *scene, int n_threads,
                                      sheen_err *err);

#endif

// SPDX-License-Identifier: Apache-2.0
// draw_private.h - the inside of sheen_drawing. Used inside render only.
#ifndef SHEEN_RENDER_DRAW_PRIVATE_H
#define SHEEN_RENDER_DRAW_PRIVATE_H

#include "render/draw.h"

struct sheen_drawing {
    const sheen_model *model; // lent
    sheen_scene *scene;
    sheen_light_cells *cells;
    sheen_lamp_points lamps;
};

#endif

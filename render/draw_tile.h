// SPDX-License-Identifier: Apache-2.0
// draw_tile.h - colours of a small square of a picture's samples. Used inside render only.
#ifndef SHEEN_RENDER_DRAW_TILE_H
#define SHEEN_RENDER_DRAW_TILE_H

#include <stdbool.h>

#include "render/gbuffer.h"
#include "render/lobe_block.h"
#include "render/shade.h"

enum { SHEEN_TILE_SAMPLES = SHEEN_LOBE_BLOCK, SHEEN_TILE_MAX_SIDE = 16 };

// Samples of a square that see the object, in Morton order: neighbours stay together however the list is cut.
typedef struct sheen_tile {
    int count;
    sheen_hit hits[SHEEN_TILE_SAMPLES];
    uint8_t x[SHEEN_TILE_SAMPLES], y[SHEEN_TILE_SAMPLES]; // sample within the square
    float diffuse[SHEEN_TILE_SAMPLES][3], specular[SHEEN_TILE_SAMPLES][3];
    float gloss[SHEEN_TILE_SAMPLES]; // by the texture's colour
    bool hole[SHEEN_TILE_SAMPLES];   // no photograph saw the place; diffuse is black there
} sheen_tile;

// The samples [x0, x0 + side) x [y0, y0 + side) of g, cut to it; side <= SHEEN_TILE_MAX_SIDE.
void sheen_tile_gather(sheen_tile *tile, const sheen_gbuffer *g, int x0, int y0, int side);
void sheen_tile_diffuse(sheen_tile *tile, const sheen_shading *shading, const double p_camera_obj[3]);
// After sheen_tile_diffuse, which finds the gloss.
void sheen_tile_specular(sheen_tile *tile, const sheen_shading *shading, const double p_camera_obj[3]);

#endif

// SPDX-License-Identifier: Apache-2.0
// lobe_block.h - the lobe's sum for many neighbouring samples at once.
#ifndef SHEEN_RENDER_LOBE_BLOCK_H
#define SHEEN_RENDER_LOBE_BLOCK_H

#include <stdalign.h>

#include "render/lobe.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SHEEN_LOBE_BLOCK = 256 };

// Unit normals and directions to the camera, component by component, in the lights' frame; neighbours in the
// picture should stand near each other (Morton order), or time is lost.
typedef struct sheen_lobe_block {
    alignas(64) float nx[SHEEN_LOBE_BLOCK]; // so that no vector straddles two cache lines
    float ny[SHEEN_LOBE_BLOCK], nz[SHEEN_LOBE_BLOCK];
    float vx[SHEEN_LOBE_BLOCK], vy[SHEEN_LOBE_BLOCK], vz[SHEEN_LOBE_BLOCK];
    float sum[SHEEN_LOBE_BLOCK]; // out
    int count;
} sheen_lobe_block;

// Cells with lists wide enough for neighbouring samples to share one. Any cells serve, more slowly.
sheen_status sheen_lobe_block_cells(sheen_light_cells **out, const sheen_lights *lights, float sigma_rad,
                                    sheen_err *err);

// sum[i] = sheen_light_cells_sum(cells, n_i, v_i), eq. (7) without k_S, to within `tolerance` or a thousandth
// of it, whichever is more. Where the lobe is wide against what the normals of a group of samples differ by,
// the sum is taken once, with its derivatives, and checked at the sample that lies farthest off.
void sheen_lobe_block_sum(sheen_lobe_block *block, const sheen_light_cells *cells, float tolerance);
// The same at a given level of instruction set up to sheen_cpu_level().
void sheen_lobe_block_sum_level(sheen_lobe_block *block, const sheen_light_cells *cells, float tolerance,
                                int level);
// Sample by sample.
void sheen_lobe_block_sum_ref(sheen_lobe_block *block, const sheen_light_cells *cells);

#ifdef __cplusplus
}
#endif
#endif

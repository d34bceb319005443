// SPDX-License-Identifier: Apache-2.0
// texture.h - the global texture: one normalised patch a triangle (section 3.2).
//
// A patch has T texels an edge on the lattice b1 = i/(T-1), b2 = j/(T-1), i + j <= T-1: its edge texels lie
// exactly on the triangle's edges, so that neighbours agree along them and no seam shows. Two triangles share
// a block of T x (T+1) pixels in the atlas picture: triangle 2k has pixel (i, j) of block k, triangle 2k+1
// has (T-1-i, T-j). Blocks stand in rows, columns_blocks of them in a row.
#ifndef SHEEN_RENDER_TEXTURE_H
#define SHEEN_RENDER_TEXTURE_H

#include <stddef.h>
#include <stdint.h>

#include "base/image.h"
#include "base/mesh.h"
#include "render/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SHEEN_TEXTURE_MIN_EDGE = 2, SHEEN_TEXTURE_MAX_EDGE = 64 };

// Linear light. Texel k of triangle f is at (f * texels_per_triangle + k); see sheen_texel_index.
typedef struct sheen_texture {
    int texels_per_edge; // T
    size_t n_triangles;
    float *rgb;       // [n_triangles * T(T+1)/2][3], and one float more that may be read but means nothing
    uint8_t *n_views; // [n_triangles * T(T+1)/2] photographs that saw it (255: or more); 0: never seen
} sheen_texture;

static inline size_t sheen_texels_per_triangle(int texels_per_edge)
{
    return (size_t)texels_per_edge * (size_t)(texels_per_edge + 1) / 2;
}

// Index of lattice point (i, j) within its triangle: rows of constant j, each one shorter.
static inline size_t sheen_texel_index(int texels_per_edge, int i, int j)
{
    const int index = j * texels_per_edge - j * (j - 1) / 2 + i;
    return (size_t)index;
}

// All unseen, black. EARG: T outside 2..64. ENOMEM.
sheen_status sheen_texture_init(sheen_texture *t, size_t n_triangles, int texels_per_edge, sheen_err *err);
void sheen_texture_release(sheen_texture *t);

// Place and unit normal (n_obj may be NULL) of every texel of triangle f, in the order of the texels.
void sheen_texture_lattice(const sheen_mesh *mesh, size_t triangle, int texels_per_edge, float *p_obj,
                           float *n_obj);

// The place of texel number `texel` of a texture (triangle and b1, b2; the rest is 0).
sheen_hit sheen_texel_hit(int texels_per_edge, size_t texel);

// The three texels round a hit and their weights, which add up to 1. Of t only the lattice is asked.
void sheen_texture_cell(size_t texel[3], float weight[3], const sheen_texture *t, const sheen_hit *hit);

// Linear interpolation on the lattice at a hit; never-seen texels have no part in it. Returns the weight of
// the seen ones, 0..1; 0: a hole, rgb is what it was filled with (black where it was not).
float sheen_texture_sample(const sheen_texture *t, const sheen_hit *hit, float rgb[3]);

// The same of n hits: rgb[n][3], seen[n].
void sheen_texture_samples(float *rgb, float *seen, const sheen_texture *t, const sheen_hit *hits, size_t n);
// Asks the memory for what they will read, some while before: a texture is larger than the caches.
void sheen_texture_ask(const sheen_texture *t, const sheen_hit *hits, size_t n);
// The same at a given level of instruction set up to sheen_cpu_level().
void sheen_texture_samples_level(float *rgb, float *seen, const sheen_texture *t, const sheen_hit *hits,
                                 size_t n, int level);

// The same surface with another number of texels an edge: means of the old texels about each new one; a new texel
// is unseen where all of those are. Seams stay closed. EARG, ENOMEM.
sheen_status sheen_texture_resample(sheen_texture *out, const sheen_texture *t, int texels_per_edge,
                                    sheen_err *err);

// Atlas as a picture: RGB and A = n_views / 255. Size for n_triangles and T by the first function.
void sheen_texture_atlas_size(size_t n_triangles, int texels_per_edge, int *columns_blocks, int *width_px,
                              int *height_px);
sheen_status sheen_texture_to_atlas(sheen_image *atlas, const sheen_texture *t, sheen_err *err);
sheen_status sheen_texture_from_atlas(sheen_texture *t, const sheen_image *atlas, size_t n_triangles,
                                      int texels_per_edge, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

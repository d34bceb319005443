// SPDX-License-Identifier: Apache-2.0
// texture_atlas.c - the global texture as one picture and back: two triangles a block (texture.h).
#include "render/texture.h"

#include <math.h>
#include <string.h>

// The atlas's pixel of texel (i, j) of a triangle.
static float *pixel_of(const sheen_image *atlas, int columns_blocks, int texels_per_edge, size_t triangle,
                       int i, int j)
{
    const size_t block = triangle / 2;
    const int x0 = (int)(block % (size_t)columns_blocks) * texels_per_edge;
    const int y0 = (int)(block / (size_t)columns_blocks) * (texels_per_edge + 1);
    const int second = (int)(triangle % 2);
    return sheen_image_at(atlas, x0 + (second ? texels_per_edge - 1 - i : i),
                          y0 + (second ? texels_per_edge - j : j));
}

void sheen_texture_atlas_size(size_t n_triangles, int texels_per_edge, int *columns_blocks, int *width_px,
                              int *height_px)
{
    const size_t n_blocks = (n_triangles + 1) / 2;
    size_t columns = (size_t)ceil(sqrt((double)n_blocks * (texels_per_edge + 1) / texels_per_edge));
    columns = columns > n_blocks ? n_blocks : columns;
    columns = columns ? columns : 1;
    const size_t rows = n_blocks ? (n_blocks + columns - 1) / columns : 1;
    *columns_blocks = (int)columns;
    *width_px = (int)columns * texels_per_edge;
    *height_px = (int)rows * (texels_per_edge + 1);
}

sheen_status sheen_texture_to_atlas(sheen_image *atlas, const sheen_texture *t, sheen_err *err)
{
    int columns, width_px, height_px;
    sheen_texture_atlas_size(t->n_triangles, t->texels_per_edge, &columns, &width_px, &height_px);
    const sheen_status s = sheen_image_init(atlas, width_px, height_px, 4, err);
    if (s)
        return sheen_wrap(err, s, "cannot lay out a texture of %zu triangles; fewer texels an edge would fit",
                          t->n_triangles);
    const float *rgb = t->rgb;
    const uint8_t *n_views = t->n_views;
    for (size_t triangle = 0; triangle < t->n_triangles; triangle++)
        for (int j = 0; j < t->texels_per_edge; j++)
            for (int i = 0; i + j < t->texels_per_edge; i++, rgb += 3, n_views++) {
                float *px = pixel_of(atlas, columns, t->texels_per_edge, triangle, i, j);
                memcpy(px, rgb, 3 * sizeof *rgb);
                px[3] = (float)*n_views / 255.0f;
            }
    return SHEEN_OK;
}

// The sizes are compared before anything is allocated, so a few wrong numbers cannot ask for much memory.
sheen_status sheen_texture_from_atlas(sheen_texture *t, const sheen_image *atlas, size_t n_triangles,
                                      int texels_per_edge, sheen_err *err)
{
    *t = (sheen_texture){0};
    if (texels_per_edge < SHEEN_TEXTURE_MIN_EDGE || texels_per_edge > SHEEN_TEXTURE_MAX_EDGE ||
        !n_triangles || n_triangles > SHEEN_MESH_MAX_TRIANGLES)
        return sheen_fail(err, SHEEN_EFORMAT,
                          "a texture of %zu triangles with %d texels an edge is out of range", n_triangles,
                          texels_per_edge);
    int columns, width_px, height_px;
    sheen_texture_atlas_size(n_triangles, texels_per_edge, &columns, &width_px, &height_px);
    if (atlas->n_channels != 4 || atlas->width_px != width_px || atlas->height_px != height_px)
        return sheen_fail(
            err, SHEEN_EFORMAT,
            "the texture is a picture of %d x %d px with %d channels, not the %d x %d px with 4 channels "
            "that %zu triangles with %d texels an edge need",
            atlas->width_px, atlas->height_px, atlas->n_channels, width_px, height_px, n_triangles,
            texels_per_edge);
    const sheen_status s = sheen_texture_init(t, n_triangles, texels_per_edge, err);
    if (s)
        return s;
    float *rgb = t->rgb;
    uint8_t *n_views = t->n_views;
    for (size_t triangle = 0; triangle < n_triangles; triangle++)
        for (int j = 0; j < texels_per_edge; j++)
            for (int i = 0; i + j < texels_per_edge; i++, rgb += 3, n_views++) {
                const float *px = pixel_of(atlas, columns, texels_per_edge, triangle, i, j);
                if (!isfinite(px[0]) || !isfinite(px[1]) || !isfinite(px[2]) || !(px[3] >= 0 && px[3] <= 1)) {
                    sheen_texture_release(t);
                    return sheen_fail(err, SHEEN_EFORMAT, "the texture holds something that is not a colour");
                }
                memcpy(rgb, px, 3 * sizeof *rgb);
                *n_views = (uint8_t)(px[3] * 255.0f + 0.5f);
            }
    return SHEEN_OK;
}

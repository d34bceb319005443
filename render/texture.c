// SPDX-License-Identifier: Apache-2.0
// texture.c - the global texture (section 3.2): a lattice of texels on every triangle, interpolated linearly.
//
// The lattice cuts a triangle into (T-1)^2 small ones, upright and upside down; a sample is the barycentric
// mean of the three texels round it. Texels on an edge lie at the same points for both its triangles, so
// where both hold the same values the picture is continuous across the edge.
#include "render/texture.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"

sheen_status sheen_texture_init(sheen_texture *t, size_t n_triangles, int texels_per_edge, sheen_err *err)
{
    *t = (sheen_texture){0};
    if (texels_per_edge < SHEEN_TEXTURE_MIN_EDGE || texels_per_edge > SHEEN_TEXTURE_MAX_EDGE)
        return sheen_fail(err, SHEEN_EARG, "a texture of %d texels an edge is out of range (%d to %d)",
                          texels_per_edge, SHEEN_TEXTURE_MIN_EDGE, SHEEN_TEXTURE_MAX_EDGE);
    if (!n_triangles || n_triangles > SHEEN_MESH_MAX_TRIANGLES)
        return sheen_fail(err, SHEEN_EARG, "a texture of %zu triangles is out of range", n_triangles);
    const size_t n = n_triangles * sheen_texels_per_triangle(texels_per_edge);
    t->texels_per_edge = texels_per_edge;
    t->n_triangles = n_triangles;
    t->rgb = calloc(n, 3 * sizeof *t->rgb);
    t->n_views = calloc(n, sizeof *t->n_views);
    if (!t->rgb || !t->n_views) {
        sheen_texture_release(t);
        return sheen_fail_memory(err, 13.0 * (double)n, "the texture; fewer texels an edge need less");
    }
    return SHEEN_OK;
}

void sheen_texture_release(sheen_texture *t)
{
    free(t->rgb);
    free(t->n_views);
    *t = (sheen_texture){0};
}

void sheen_texture_lattice(const sheen_mesh *mesh, size_t triangle, int texels_per_edge, float *p_obj,
                           float *n_obj)
{
    const uint32_t *corner = mesh->triangles + 3 * triangle;
    const float last = (float)(texels_per_edge - 1);
    size_t texel = 0;
    for (int j = 0; j < texels_per_edge; j++)
        for (int i = 0; i + j < texels_per_edge; i++, texel++) {
            const float b[3] = {(float)(texels_per_edge - 1 - i - j) / last, (float)i / last,
                                (float)j / last};
            float p[3] = {0, 0, 0}, n[3] = {0, 0, 0};
            for (int c = 0; c < 3; c++)
                for (int k = 0; k < 3; k++) {
                    p[k] += b[c] * mesh->p_obj[3 * (size_t)corner[c] + (size_t)k];
                    n[k] += b[c] * mesh->n_obj[3 * (size_t)corner[c] + (size_t)k];
                }
            sheen_normalizef(n);
            memcpy(p_obj + 3 * texel, p, sizeof p);
            if (n_obj)
                memcpy(n_obj + 3 * texel, n, sizeof n);
        }
}

// The lattice's small triangle at a place: the indices of its three texels, and their weights.
static inline void cell_at(const sheen_texture *t, const sheen_hit *hit, size_t texel[3], float weight[3])
{
    const int T = t->texels_per_edge, last = T - 1;
    const float a = hit->b1 * (float)last, b = hit->b2 * (float)last;
    int i = (int)a, j = (int)b;
    i = i < 0 ? 0 : i > last - 1 ? last - 1 : i;
    j = j < 0 ? 0 : j > last - 1 ? last - 1 : j;
    if (i + j > last - 1) { // on the far edge, by rounding: into the last small triangle before it
        if (i > 0)
            i = last - 1 - j;
        else
            j = last - 1 - i;
    }
    const float fi = a - (float)i, fj = b - (float)j, f = fi + fj;
    const size_t at = hit->triangle * sheen_texels_per_triangle(T) + sheen_texel_index(T, i, j);
    const size_t above = at + (size_t)(T - j); // (i, j + 1)
    texel[1] = at + 1;
    texel[2] = above;
    if (f <= 1 || i + j == last - 1) { // upright
        const float over = f > 1 ? 1 / f : 1;
        texel[0] = at;
        weight[1] = fi * over;
        weight[2] = fj * over;
        weight[0] = 1 - weight[1] - weight[2];
    } else { // upside down
        texel[0] = above + 1;
        weight[0] = f - 1;
        weight[1] = 1 - fj;
        weight[2] = 1 - fi;
    }
}

void sheen_texture_cell(size_t texel[3], float weight[3], const sheen_texture *t, const sheen_hit *hit)
{
    cell_at(t, hit, texel, weight);
}

sheen_hit sheen_texel_hit(int texels_per_edge, size_t texel)
{
    const size_t per_triangle = sheen_texels_per_triangle(texels_per_edge), k = texel % per_triangle;
    const float last = (float)(texels_per_edge - 1);
    int j = 0;
    while (j < texels_per_edge - 1 && k >= sheen_texel_index(texels_per_edge, 0, j + 1))
        j++;
    return (sheen_hit){.triangle = (uint32_t)(texel / per_triangle),
                       .b1 = (float)(k - sheen_texel_index(texels_per_edge, 0, j)) / last,
                       .b2 = (float)j / last};
}

// Mean of three texels, those that were never seen left out.
static float mean_of_seen(const sheen_texture *t, const size_t texel[3], const float weight[3], float rgb[3])
{
    float sum[3] = {0, 0, 0}, filled[3] = {0, 0, 0}, seen = 0;
    for (int c = 0; c < 3; c++) {
        const int is_seen = t->n_views[texel[c]] && weight[c] > 0;
        seen += is_seen ? weight[c] : 0;
        for (int k = 0; k < 3; k++)
            (is_seen ? sum : filled)[k] += weight[c] * t->rgb[3 * texel[c] + (size_t)k];
    }
    for (int k = 0; k < 3; k++)
        rgb[k] = seen > 0 ? sum[k] / seen : filled[k];
    return seen < 1 ? seen : 1;
}

float sheen_texture_sample(const sheen_texture *t, const sheen_hit *hit, float rgb[3])
{
    size_t texel[3];
    float weight[3];
    cell_at(t, hit, texel, weight);
    const uint8_t *views = t->n_views;
    if (!views[texel[0]] || !views[texel[1]] || !views[texel[2]])
        return mean_of_seen(t, texel, weight, rgb);
    const float *a = t->rgb + 3 * texel[0], *b = t->rgb + 3 * texel[1], *c = t->rgb + 3 * texel[2];
    for (int k = 0; k < 3; k++)
        rgb[k] = weight[0] * a[k] + weight[1] * b[k] + weight[2] * c[k];
    return 1;
}

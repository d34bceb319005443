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

#include "base/cpu_level.h"
#include "base/vec.h"

enum { LANES = 16 };

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
    t->rgb = calloc(3 * n + 1, sizeof *t->rgb); // texels are read four floats at a time
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

SHEEN_KERNEL_INLINE float sample_cell(const sheen_texture *t, const size_t texel[3], const float weight[3],
                                      float rgb[3])
{
    const uint8_t *views = t->n_views;
    if (!views[texel[0]] || !views[texel[1]] || !views[texel[2]])
        return mean_of_seen(t, texel, weight, rgb);
    const float *a = t->rgb + 3 * texel[0], *b = t->rgb + 3 * texel[1], *c = t->rgb + 3 * texel[2];
    rgb[0] = weight[0] * a[0] + weight[1] * b[0] + weight[2] * c[0];
    rgb[1] = weight[0] * a[1] + weight[1] * b[1] + weight[2] * c[1];
    rgb[2] = weight[0] * a[2] + weight[1] * b[2] + weight[2] * c[2];
    return 1;
}

float sheen_texture_sample(const sheen_texture *t, const sheen_hit *hit, float rgb[3])
{
    size_t texel[3];
    float weight[3];
    cell_at(t, hit, texel, weight);
    return sample_cell(t, texel, weight, rgb);
}

// cell_at of LANES hits without a branch (gcc 12 makes none of integers; non-negative floats order like their bits); texels are
// counted from the triangle's first.
typedef struct cells {
    int32_t texel[3][LANES];
    float weight[3][LANES];
} cells;

SHEEN_KERNEL_INLINE void cells_at(cells *out, int T, const sheen_hit *hits)
{
    const int last = T - 1;
    const int32_t one_bits = 0x3f800000; // of 1.0f
#pragma omp simd
    for (int k = 0; k < LANES; k++) {
        const float a = hits[k].b1 * (float)last, b = hits[k].b2 * (float)last;
        const int i0 = (int)a, j0 = (int)b, j1 = j0 < 0 ? 0 : j0, j = j1 > last - 1 ? last - 1 : j1;
        const int i1 = i0 < 0 ? 0 : i0, i = i1 > last - 1 - j ? last - 1 - j : i1;
        const float fi = a - (float)i, fj = b - (float)j, f = fi + fj;
        int32_t bits;
        memcpy(&bits, &f, sizeof bits);
        const int32_t most_bits = bits > one_bits ? bits : one_bits;
        const int32_t upright = (bits <= one_bits) | (i + j == last - 1);
        float most; // of f and 1
        memcpy(&most, &most_bits, sizeof most);
        const float scale = 1 / most, up = (float)upright, down = 1 - up, u1 = fi * scale, u2 = fj * scale;
        const int at = j * T - j * (j - 1) / 2 + i, row = T - j; // texels from (i, j) to (i, j + 1)
        out->texel[0][k] = at + (1 - upright) * (row + 1);
        out->texel[1][k] = at + 1;
        out->texel[2][k] = at + row;
        out->weight[0][k] = up * (1 - u1 - u2) + down * (f - 1);
        out->weight[1][k] = up * u1 + down * (1 - fj);
        out->weight[2][k] = up * u2 + down * (1 - fi);
    }
}

// A texel and the float behind it.
typedef float quad __attribute__((vector_size(16)));

SHEEN_KERNEL_INLINE quad texel_at(const float *rgb, size_t texel)
{
    quad q;
    memcpy(&q, rgb + 3 * texel, sizeof q);
    return q;
}

// sample_cell where there is room for four floats.
SHEEN_KERNEL_INLINE float sample_quad(const sheen_texture *t, const size_t texel[3], const float weight[3],
                                      float *rgb)
{
    const uint8_t *views = t->n_views;
    if (!views[texel[0]] || !views[texel[1]] || !views[texel[2]])
        return mean_of_seen(t, texel, weight, rgb);
    const quad mean = weight[0] * texel_at(t->rgb, texel[0]) + weight[1] * texel_at(t->rgb, texel[1]) +
                      weight[2] * texel_at(t->rgb, texel[2]);
    memcpy(rgb, &mean, sizeof mean);
    return 1;
}

SHEEN_KERNEL_INLINE void samples(float *rgb, float *seen, const sheen_texture *t, const sheen_hit *hits,
                                 size_t n)
{
    const size_t per_triangle = sheen_texels_per_triangle(t->texels_per_edge), whole = n / LANES * LANES;
    for (size_t begin = 0; begin < whole; begin += LANES) {
        cells c;
        cells_at(&c, t->texels_per_edge, hits + begin);
        for (size_t k = 0; k < LANES; k++) {
            const size_t i = begin + k, first = hits[i].triangle * per_triangle;
            const size_t texel[3] = {first + (size_t)c.texel[0][k], first + (size_t)c.texel[1][k],
                                     first + (size_t)c.texel[2][k]};
            const float weight[3] = {c.weight[0][k], c.weight[1][k], c.weight[2][k]};
            seen[i] = i + 1 < n
                          ? sample_quad(t, texel, weight, rgb + 3 * i) // the next one overwrites the fourth
                          : sample_cell(t, texel, weight, rgb + 3 * i);
        }
    }
    for (size_t i = whole; i < n; i++)
        seen[i] = sheen_texture_sample(t, &hits[i], rgb + 3 * i);
}

// A cell's texels of one row, and that of the next, are neighbours. The places need not be exact.
void sheen_texture_ask(const sheen_texture *t, const sheen_hit *hits, size_t n)
{
    const int T = t->texels_per_edge;
    const size_t per_triangle = sheen_texels_per_triangle(T);
    for (size_t k = 0; k < n; k++) {
        const int i = (int)(hits[k].b1 * (float)(T - 1)), j = (int)(hits[k].b2 * (float)(T - 1));
        const size_t texel = hits[k].triangle * per_triangle + (size_t)(j * T - j * (j - 1) / 2 + i);
        __builtin_prefetch(t->rgb + 3 * texel);
        __builtin_prefetch(t->rgb + 3 * (texel + (size_t)(T - j)));
        __builtin_prefetch(t->n_views + texel);
    }
}

static void samples_baseline(float *rgb, float *seen, const sheen_texture *t, const sheen_hit *hits, size_t n)
{
    samples(rgb, seen, t, hits, n);
}

#if defined(__x86_64__)
SHEEN_TARGET_AVX2 static void samples_avx2(float *rgb, float *seen, const sheen_texture *t,
                                           const sheen_hit *hits, size_t n)
{
    samples(rgb, seen, t, hits, n);
}

SHEEN_TARGET_AVX512 static void samples_avx512(float *rgb, float *seen, const sheen_texture *t,
                                               const sheen_hit *hits, size_t n)
{
    samples(rgb, seen, t, hits, n);
}
#endif

void sheen_texture_samples_level(float *rgb, float *seen, const sheen_texture *t, const sheen_hit *hits,
                                 size_t n, int level)
{
#if defined(__x86_64__)
    if (level >= SHEEN_CPU_AVX512) {
        samples_avx512(rgb, seen, t, hits, n);
        return;
    }
    if (level == SHEEN_CPU_AVX2) {
        samples_avx2(rgb, seen, t, hits, n);
        return;
    }
#endif
    (void)level;
    samples_baseline(rgb, seen, t, hits, n);
}

void sheen_texture_samples(float *rgb, float *seen, const sheen_texture *t, const sheen_hit *hits, size_t n)
{
    sheen_texture_samples_level(rgb, seen, t, hits, n, sheen_cpu_level());
}

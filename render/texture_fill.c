// SPDX-License-Identifier: Apache-2.0
// texture_fill.c - colour for surface that no photograph saw, continued from what lies around it.
//
// Each vertex takes the mean of the seen texels at its corners of triangles; vertices without any take the mean
// of their neighbours that have one, ring by ring, until none is left that can be reached. An unseen texel is
// then interpolated between its triangle's vertices, so that the filling joins at the edges of what was seen.
#include <stdlib.h>
#include <string.h>

#include "render/texture.h"

typedef struct vertex_colours {
    float (*rgb)[4]; // sum of colours and of their weights; after normalising, weight 1 or 0
    float (*next)[4];
} vertex_colours;

// Texels of a corner: the nearest third of the patch, nearer ones counting more.
static void gather_corners(float (*rgb)[4], const sheen_texture *t, const sheen_mesh *mesh, size_t triangle)
{
    const int last = t->texels_per_edge - 1;
    const size_t first = triangle * sheen_texels_per_triangle(t->texels_per_edge);
    size_t texel = first;
    for (int j = 0; j <= last; j++)
        for (int i = 0; i + j <= last; i++, texel++) {
            const int away[3] = {i + j, last - i, last - j}; // lattice steps from each corner
            for (int c = 0; c < 3 && t->n_views[texel]; c++) {
                if (3 * away[c] > last)
                    continue;
                float *to = rgb[mesh->triangles[3 * triangle + (size_t)c]];
                const float weight = 1.0f / (float)(1 + away[c]);
                for (int k = 0; k < 3; k++)
                    to[k] += weight * t->rgb[3 * texel + (size_t)k];
                to[3] += weight;
            }
        }
}

static size_t normalise(float (*rgb)[4], size_t n)
{
    size_t n_known = 0;
    for (size_t v = 0; v < n; v++) {
        if (!(rgb[v][3] > 0))
            continue;
        for (int k = 0; k < 3; k++)
            rgb[v][k] /= rgb[v][3];
        rgb[v][3] = 1;
        n_known++;
    }
    return n_known;
}

// One ring: unknown vertices take the mean of known ones on their triangles. Returns how many are known then.
static size_t grow(vertex_colours *c, const sheen_mesh *mesh)
{
    const size_t n = mesh->n_vertices;
    memcpy(c->next, c->rgb, n * sizeof *c->next);
    for (size_t t = 0; t < mesh->n_triangles; t++)
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++) {
                const size_t to = mesh->triangles[3 * t + (size_t)a],
                             from = mesh->triangles[3 * t + (size_t)b];
                if (c->rgb[to][3] > 0 || !(c->rgb[from][3] > 0))
                    continue;
                for (int k = 0; k < 4; k++)
                    c->next[to][k] += c->rgb[from][k];
            }
    float(*swap)[4] = c->rgb;
    c->rgb = c->next;
    c->next = swap;
    return normalise(c->rgb, n);
}

static void fill_triangle(sheen_texture *t, const sheen_mesh *mesh, const vertex_colours *c, size_t triangle)
{
    const int last = t->texels_per_edge - 1;
    size_t texel = triangle * sheen_texels_per_triangle(t->texels_per_edge);
    for (int j = 0; j <= last; j++)
        for (int i = 0; i + j <= last; i++, texel++) {
            if (t->n_views[texel])
                continue;
            const float b[3] = {(float)(last - i - j) / (float)last, (float)i / (float)last,
                                (float)j / (float)last};
            float sum[4] = {0, 0, 0, 0};
            for (int corner = 0; corner < 3; corner++)
                for (int k = 0; k < 4; k++)
                    sum[k] += b[corner] * c->rgb[mesh->triangles[3 * triangle + (size_t)corner]][k];
            for (int k = 0; k < 3; k++)
                t->rgb[3 * texel + (size_t)k] = sum[3] > 0 ? sum[k] / sum[3] : 0;
            t->n_views[texel] = 1;
        }
}

sheen_status sheen_texture_fill(sheen_texture *t, const sheen_mesh *mesh, sheen_err *err)
{
    sheen_status s = SHEEN_OK;
    vertex_colours c = {.rgb = calloc(mesh->n_vertices, sizeof *c.rgb),
                        .next = calloc(mesh->n_vertices, sizeof *c.next)};
    if (!c.rgb || !c.next) {
        s = sheen_fail_memory(err, 32.0 * (double)mesh->n_vertices, "the colours of unseen surface");
        goto done;
    }
    for (size_t i = 0; i < mesh->n_triangles; i++)
        gather_corners(c.rgb, t, mesh, i);
    size_t n_known = normalise(c.rgb, mesh->n_vertices);
    for (size_t before = 0; n_known > before && n_known < mesh->n_vertices;) {
        before = n_known;
        n_known = grow(&c, mesh);
    }
    for (size_t i = 0; i < mesh->n_triangles; i++)
        fill_triangle(t, mesh, &c, i);

done:
    free(c.rgb);
    free(c.next);
    return s;
}

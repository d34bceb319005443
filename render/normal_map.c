// SPDX-License-Identifier: Apache-2.0
// normal_map.c - bends the mesh's normals by a texture of offsets.
#include "render/normal_map.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"
#include "render/gbuffer.h"

enum { MAX_TEXELS = SHEEN_TEXTURE_MAX_EDGE * (SHEEN_TEXTURE_MAX_EDGE + 1) / 2 };

sheen_status sheen_normal_map_init(sheen_texture *normals, size_t n_triangles, int texels_per_edge,
                                   sheen_err *err)
{
    const sheen_status s = sheen_texture_init(normals, n_triangles, texels_per_edge, err);
    if (!s) // an offset of 0 counts as any other does
        memset(normals->n_views, 1, n_triangles * sheen_texels_per_triangle(texels_per_edge));
    return s;
}

static void add_offset(float n_obj[3], const float d[3])
{
    for (int k = 0; k < 3; k++)
        n_obj[k] += d[k];
    sheen_normalizef(n_obj);
}

void sheen_normal_map_bend(float n_obj[3], const sheen_texture *normals, const sheen_hit *hit)
{
    float d[3];
    if (!normals || !normals->n_triangles)
        return;
    sheen_texture_sample(normals, hit, d);
    add_offset(n_obj, d);
}

void sheen_normal_map_lattice(const sheen_mesh *mesh, const sheen_texture *normals, size_t triangle,
                              int texels_per_edge, float *p_obj, float *n_obj)
{
    sheen_texture_lattice(mesh, triangle, texels_per_edge, p_obj, n_obj);
    if (!normals || !normals->n_triangles)
        return;
    const float last = (float)(texels_per_edge - 1);
    float *n = n_obj;
    for (int j = 0; j < texels_per_edge; j++)
        for (int i = 0; i + j < texels_per_edge; i++, n += 3) {
            const sheen_hit hit = {
                .triangle = (uint32_t)triangle, .b1 = (float)i / last, .b2 = (float)j / last};
            sheen_normal_map_bend(n, normals, &hit);
        }
}

void sheen_normal_map_surface(const sheen_mesh *mesh, const sheen_texture *normals, const sheen_hit *hit,
                              const double p_camera_obj[3], float p_obj[3], float n_obj[3], float v_obj[3])
{
    sheen_hit_surface(mesh, hit, p_camera_obj, p_obj, n_obj, v_obj);
    if (n_obj)
        sheen_normal_map_bend(n_obj, normals, hit);
}

static void convert(sheen_texture *normals, const sheen_mesh *mesh, int to_tangents)
{
    const int edge = normals->texels_per_edge;
    const size_t per_triangle = sheen_texels_per_triangle(edge);
    float p[3 * MAX_TEXELS], m[3 * MAX_TEXELS];
    for (size_t f = 0; f < normals->n_triangles; f++) {
        sheen_texture_lattice(mesh, f, edge, p, m);
        for (size_t k = 0; k < per_triangle; k++) {
            float a[3], b[3], *d = normals->rgb + 3 * (f * per_triangle + k);
            sheen_axes_aboutf(a, b, m + 3 * k);
            const float u = to_tangents ? sheen_dotf(d, a) : d[0], v = to_tangents ? sheen_dotf(d, b) : d[1];
            for (int c = 0; c < 3; c++)
                d[c] = u * a[c] + v * b[c];
            if (!to_tangents)
                continue;
            d[0] = u;
            d[1] = v;
            d[2] = 0;
        }
    }
}

void sheen_normal_map_to_tangents(sheen_texture *normals, const sheen_mesh *mesh)
{
    convert(normals, mesh, 1);
}

void sheen_normal_map_from_tangents(sheen_texture *normals, const sheen_mesh *mesh)
{
    convert(normals, mesh, 0);
}

// SPDX-License-Identifier: Apache-2.0
// gltf_surface.c - tangents, the normal map in tangent space, and both put together again.
//
// Tangents stand in the file (TANGENT), so that readers need not agree on how to make them: N and T are interpolated and
// normalised, B = w N x T, and a texel (x, y, z) is the normal x T + y B + z N, as glTF 2.0 and MikkTSpace have it. They follow the
// texture coordinates, so that a reader which makes its own finds nearly the same.
#include "render/gltf_surface.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "render/panorama.h"

enum { IRRADIANCE_HEIGHT_PX = 48 };

// The direction on the surface in which the picture's x, or its y, grows fastest along it: a sum over triangles by area.
static void add_directions(float *right, float *down, const sheen_surface_picture *p, size_t triangle)
{
    const uint32_t *chart = p->charts.triangles + 3 * triangle;
    const float *q0 = p->charts.q_px + 2 * (size_t)chart[0], *q1 = p->charts.q_px + 2 * (size_t)chart[1],
                *q2 = p->charts.q_px + 2 * (size_t)chart[2];
    const float *p0 = p->mesh.p_obj + 3 * (size_t)p->charts.vertex[chart[0]],
                *p1 = p->mesh.p_obj + 3 * (size_t)p->charts.vertex[chart[1]],
                *p2 = p->mesh.p_obj + 3 * (size_t)p->charts.vertex[chart[2]];
    const float u1 = q1[0] - q0[0], v1 = q1[1] - q0[1], u2 = q2[0] - q0[0], v2 = q2[1] - q0[1];
    const float turn = u1 * v2 - u2 * v1 < 0 ? -1.0f : 1.0f;
    float e1[3], e2[3];
    sheen_subf(e1, p1, p0);
    sheen_subf(e2, p2, p0);
    for (size_t corner = 0; corner < 3; corner++)
        for (size_t k = 0; k < 3; k++) {
            right[3 * (size_t)chart[corner] + k] += turn * (v2 * e1[k] - v1 * e2[k]);
            down[3 * (size_t)chart[corner] + k] += turn * (u1 * e2[k] - u2 * e1[k]);
        }
}

static void tangent_of(float tangent[4], const float n[3], const float right[3], const float down[3])
{
    float b[3];
    const float along = sheen_dotf(n, right);
    for (int k = 0; k < 3; k++)
        tangent[k] = right[k] - along * n[k];
    if (!(sheen_normalizef(tangent) > 0))
        sheen_axes_aboutf(tangent, b, n);
    sheen_crossf(b, n, tangent);
    tangent[3] = sheen_dotf(b, down) > 0 ? -1.0f : 1.0f;
}

sheen_status sheen_gltf_tangents(float **out, const sheen_surface_picture *p, sheen_err *err)
{
    const size_t n = p->charts.n_vertices;
    float *right = calloc(3 * n + 1, sizeof *right), *down = calloc(3 * n + 1, sizeof *down);
    *out = malloc((4 * n + 1) * sizeof **out);
    sheen_status s = SHEEN_OK;
    if (!right || !down || !*out)
        s = sheen_fail_memory(err, 40.0 * (double)n, "tangents");
    for (size_t i = 0; !s && i < p->charts.n_triangles; i++)
        add_directions(right, down, p, i);
    for (size_t i = 0; !s && i < n; i++)
        tangent_of(*out + 4 * i, p->mesh.n_obj + 3 * (size_t)p->charts.vertex[i], right + 3 * i,
                   down + 3 * i);
    free(right);
    free(down);
    if (s) {
        free(*out);
        *out = NULL;
    }
    return s;
}

// Interpolated normal and, where there are tangents, T and B.
static void frame_at(float n[3], float t[3], float b[3], const sheen_gltf *g, const sheen_chart_place *at)
{
    const sheen_surface_picture *p = &g->surface;
    const float weight[3] = {1 - at->b1 - at->b2, at->b1, at->b2};
    float side = 1;
    memset(n, 0, 3 * sizeof *n);
    memset(t, 0, 3 * sizeof *t);
    for (size_t corner = 0; corner < 3; corner++) {
        const size_t vertex = p->charts.triangles[3 * (size_t)at->triangle + corner];
        const float *n_obj = p->mesh.n_obj + 3 * (size_t)p->charts.vertex[vertex];
        for (size_t k = 0; k < 3; k++) {
            n[k] += weight[corner] * n_obj[k];
            t[k] += g->tangent ? weight[corner] * g->tangent[4 * vertex + k] : 0;
        }
        side = g->tangent ? g->tangent[4 * vertex + 3] : 1;
    }
    sheen_normalizef(n);
    sheen_normalizef(t);
    sheen_crossf(b, n, t);
    for (int k = 0; k < 3; k++)
        b[k] *= side;
}

void sheen_gltf_picture_at(float *out, const sheen_gltf *g, const sheen_image *picture,
                           const sheen_chart_place *at)
{
    const sheen_charts *charts = &g->surface.charts;
    const float weight[3] = {1 - at->b1 - at->b2, at->b1, at->b2};
    double x = 0, y = 0;
    for (size_t corner = 0; corner < 3; corner++) {
        const float *q = charts->q_px + 2 * (size_t)charts->triangles[3 * (size_t)at->triangle + corner];
        x += (double)(weight[corner] * q[0]);
        y += (double)(weight[corner] * q[1]);
    }
    const double scale = (double)picture->width_px / charts->side_px, last = picture->width_px - 1;
    sheen_image_bilinear(out, picture, fmin(last, fmax(0, x * scale - 0.5)),
                         fmin(last, fmax(0, y * scale - 0.5)));
}

void sheen_gltf_surface_at(float p_obj[3], float n_obj[3], const sheen_gltf *g, const sheen_chart_place *at)
{
    const sheen_surface_picture *p = &g->surface;
    const float weight[3] = {1 - at->b1 - at->b2, at->b1, at->b2};
    float t[3], b[3], n[3], code[3];
    memset(p_obj, 0, 3 * sizeof *p_obj);
    for (size_t corner = 0; corner < 3; corner++)
        for (size_t k = 0; k < 3; k++)
            p_obj[k] += weight[corner] *
                        p->mesh.p_obj[3 * (size_t)p->mesh.triangles[3 * (size_t)at->triangle + corner] + k];
    frame_at(n, t, b, g, at);
    memcpy(n_obj, n, sizeof n);
    if (!g->normals.data)
        return;
    sheen_gltf_picture_at(code, g, &g->normals, at);
    for (int k = 0; k < 3; k++)
        n_obj[k] = (2 * code[0] - 1) * t[k] + (2 * code[1] - 1) * b[k] + (2 * code[2] - 1) * n[k];
    sheen_normalizef(n_obj);
}

// Mean of a square of places, in tangent space; (0, 0, 1) where nothing is known.
static void code_normal(float code[3], const sheen_gltf *g, int x0, int y0, int step)
{
    const sheen_surface_picture *p = &g->surface;
    float sum[3] = {0, 0, 0};
    for (int y = y0; y < y0 + step; y++)
        for (int x = x0; x < x0 + step; x++) {
            const sheen_chart_place *at = &p->places[(size_t)y * (size_t)p->charts.side_px + (size_t)x];
            const float *normal = sheen_image_at(&p->n_obj, x, y);
            float t[3], b[3], n[3];
            if (at->triangle == SHEEN_CHART_EMPTY || !(sheen_dotf(normal, normal) > 0))
                continue;
            frame_at(n, t, b, g, at);
            sum[0] += sheen_dotf(normal, t);
            sum[1] += sheen_dotf(normal, b);
            sum[2] += sheen_dotf(normal, n);
        }
    if (!(sheen_normalizef(sum) > 0))
        sum[2] = 1;
    for (int k = 0; k < 3; k++)
        code[k] = 0.5f + 0.5f * sum[k];
}

// 1 in `known` where any of a square's places has a normal.
static uint8_t is_known(const sheen_surface_picture *p, int x0, int y0, int step)
{
    for (int y = y0; y < y0 + step; y++)
        for (int x = x0; x < x0 + step; x++) {
            const float *n = sheen_image_at(&p->n_obj, x, y);
            if (sheen_dotf(n, n) > 0)
                return 1;
        }
    return 0;
}

sheen_status sheen_gltf_normal_picture(sheen_image *out, const sheen_gltf *g, const sheen_model *model,
                                       sheen_err *err)
{
    const sheen_surface_picture *p = &g->surface;
    *out = (sheen_image){.data = NULL};
    if (!p->n_obj.data)
        return SHEEN_OK;
    const int step = 2 * (model->normals.texels_per_edge - 1) <= model->texture.texels_per_edge + 1 ? 2 : 1,
              side_px = p->charts.side_px / step;
    const size_t n = (size_t)side_px * (size_t)side_px;
    uint8_t *known = calloc(n, 1);
    sheen_status s = known ? sheen_image_init(out, side_px, side_px, 3, err)
                           : sheen_fail_memory(err, (double)n, "a normal map");
    for (int y = 0; !s && y < side_px; y++)
        for (int x = 0; x < side_px; x++) {
            code_normal(sheen_image_at(out, x, y), g, x * step, y * step, step);
            known[(size_t)y * (size_t)side_px + (size_t)x] = is_known(p, x * step, y * step, step);
        }
    if (!s)
        s = sheen_image_fill(out, known, err);
    free(known);
    if (s)
        sheen_image_release(out);
    // As its reader has it.
    for (size_t i = 0; !s && i < 3 * n; i++)
        out->data[i] = rintf(255 * fmaxf(0, fminf(1, out->data[i]))) / 255;
    return s;
}

sheen_status sheen_gltf_irradiance(sheen_image *out, const sheen_image *panorama, sheen_err *err)
{
    sheen_status s = sheen_image_init(out, 2 * IRRADIANCE_HEIGHT_PX, IRRADIANCE_HEIGHT_PX, 3, err);
    if (s)
        return s;
    const size_t n = (size_t)2 * IRRADIANCE_HEIGHT_PX * IRRADIANCE_HEIGHT_PX;
    float *n_env = malloc(3 * n * sizeof *n_env);
    if (!n_env)
        s = sheen_fail_memory(err, 12.0 * (double)n, "irradiance");
    for (int y = 0; !s && y < IRRADIANCE_HEIGHT_PX; y++)
        for (int x = 0; x < 2 * IRRADIANCE_HEIGHT_PX; x++)
            sheen_panorama_direction(n_env + 3 * (y * 2 * IRRADIANCE_HEIGHT_PX + x), out, x, y);
    if (!s)
        s = sheen_panorama_irradiance(out->data, n_env, n, panorama, err);
    free(n_env);
    if (s)
        sheen_image_release(out);
    return s;
}

void sheen_gltf_to_env(float v_env[3], const sheen_gltf *g, const float v_obj[3])
{
    for (int k = 0; k < 3; k++)
        v_env[k] = (float)(g->R_gltf_obj[k][0] * (double)v_obj[0] + g->R_gltf_obj[k][1] * (double)v_obj[1] +
                           g->R_gltf_obj[k][2] * (double)v_obj[2]);
}

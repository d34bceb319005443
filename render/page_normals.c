// SPDX-License-Identifier: Apache-2.0
// page_normals.c - octahedral vertex normals, and a normal map as two small numbers a texel.
//
// An offset is kept by its parts along two axes across the mesh's normal m there, in steps of an eighth of sigma (what a
// finer step would tell, the lobe blurs). The axes are m's alone and follow it smoothly, so that a reader whose m differs
// in the last digit has the same ones (Frisvad 2012, "Building an orthonormal basis from a 3D unit vector without
// normalization"): a = (1 - x^2 k, -x y k, -x), b = (-x y k, 1 - y^2 k, -y), k = 1 / (1 + z); at z = -1 a = (0, -1, 0),
// b = (-1, 0, 0).
#include "render/page_normals.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "base/vec.h"

enum { MAX_TEXELS = SHEEN_TEXTURE_MAX_EDGE * (SHEEN_TEXTURE_MAX_EDGE + 1) / 2, STEPS_A_SIGMA = 8 };

static float sign_of(float x)
{
    return x < 0 ? -1.0f : 1.0f;
}

void sheen_page_normal_code(uint16_t code[2], const float n[3])
{
    const float l1 = fabsf(n[0]) + fabsf(n[1]) + fabsf(n[2]);
    float u = l1 > 0 ? n[0] / l1 : 0, v = l1 > 0 ? n[1] / l1 : 0;
    if (n[2] < 0) {
        const float folded = (1 - fabsf(v)) * sign_of(u);
        v = (1 - fabsf(u)) * sign_of(v);
        u = folded;
    }
    code[0] = sheen_page_u16(0.5f * u + 0.5f);
    code[1] = sheen_page_u16(0.5f * v + 0.5f);
}

void sheen_page_normal_of(float n[3], const uint16_t code[2])
{
    const float u = (float)code[0] / 65535.0f * 2 - 1, v = (float)code[1] / 65535.0f * 2 - 1;
    n[2] = 1 - fabsf(u) - fabsf(v);
    const float below = fmaxf(-n[2], 0);
    n[0] = u + (u < 0 ? below : -below);
    n[1] = v + (v < 0 ? below : -below);
    sheen_normalizef(n);
}

double sheen_page_normals_step(double sigma_rad)
{
    return fmax(sigma_rad / STEPS_A_SIGMA, (double)SHEEN_NORMAL_MAP_MOST / INT16_MAX);
}

size_t sheen_page_normals_bytes(size_t n_triangles, int texels_per_edge)
{
    return 4 * n_triangles * sheen_texels_per_triangle(texels_per_edge);
}

static void axes_across(float a[3], float b[3], const float m[3])
{
    const bool pole = !(m[2] > -0.9999999f);
    const float k = pole ? 0 : 1 / (1 + m[2]), xy = pole ? 1 : m[0] * m[1] * k;
    a[0] = pole ? 0 : 1 - m[0] * m[0] * k;
    a[1] = -xy;
    a[2] = pole ? 0 : -m[0];
    b[0] = -xy;
    b[1] = pole ? 0 : 1 - m[1] * m[1] * k;
    b[2] = pole ? 0 : -m[1];
}

// A texel is told from the one before it in its row; the first of a row from the first of the row before, and the first of
// a triangle from that of the triangle before. code: of all three, per part.
typedef struct run {
    uint16_t code[3][2];
} run;

// The part of `run` that texel (i, j) is told from.
static size_t before_of(int i, int j)
{
    return i ? 0 : j ? 1 : 2;
}

static void remember(run *r, int i, int j, const uint16_t code[2])
{
    for (size_t which = 0; which <= before_of(i, j); which++)
        memcpy(r->code[which], code, sizeof r->code[which]);
}

void sheen_page_normals_put(uint8_t *to, const sheen_texture *normals, const sheen_mesh *mesh,
                            double step_rad)
{
    const int edge = normals->texels_per_edge;
    const size_t n = normals->n_triangles * sheen_texels_per_triangle(edge);
    float p[3 * MAX_TEXELS], m[3 * MAX_TEXELS], axis[2][3];
    run r = {{{0}}};
    size_t at = 0;
    for (size_t f = 0; f < normals->n_triangles; f++) {
        sheen_texture_lattice(mesh, f, edge, p, m);
        const float *m_at = m;
        for (int j = 0; j < edge; j++)
            for (int i = 0; i + j < edge; i++, at++, m_at += 3) {
                const uint16_t *before = r.code[before_of(i, j)];
                uint16_t code[2];
                axes_across(axis[0], axis[1], m_at);
                for (size_t k = 0; k < 2; k++) {
                    const double part = (double)sheen_dotf(normals->rgb + 3 * at, axis[k]) / step_rad;
                    code[k] = (uint16_t)lrint(fmax(-INT16_MAX, fmin(INT16_MAX, part)));
                    const uint16_t folded = sheen_page_fold((uint16_t)(code[k] - before[k]));
                    to[2 * k * n + at] = (uint8_t)folded;
                    to[(2 * k + 1) * n + at] = (uint8_t)(folded >> 8);
                }
                remember(&r, i, j, code);
            }
    }
}

void sheen_page_normals_get(sheen_texture *normals, const uint8_t *from, const sheen_mesh *mesh,
                            double step_rad)
{
    const int edge = normals->texels_per_edge;
    const size_t n = normals->n_triangles * sheen_texels_per_triangle(edge);
    float p[3 * MAX_TEXELS], m[3 * MAX_TEXELS], a[3], b[3];
    run r = {{{0}}};
    size_t at = 0;
    for (size_t f = 0; f < normals->n_triangles; f++) {
        sheen_texture_lattice(mesh, f, edge, p, m);
        const float *m_at = m;
        for (int j = 0; j < edge; j++)
            for (int i = 0; i + j < edge; i++, at++, m_at += 3) {
                const uint16_t *before = r.code[before_of(i, j)];
                uint16_t code[2];
                float part[2];
                for (size_t k = 0; k < 2; k++) {
                    const uint16_t folded = (uint16_t)(from[2 * k * n + at] | from[(2 * k + 1) * n + at]
                                                                                  << 8);
                    code[k] = (uint16_t)(before[k] + sheen_page_unfold(folded));
                    part[k] = fmaxf(-SHEEN_NORMAL_MAP_MOST,
                                    fminf(SHEEN_NORMAL_MAP_MOST, (float)(step_rad * (int16_t)code[k])));
                }
                remember(&r, i, j, code);
                axes_across(a, b, m_at);
                for (size_t c = 0; c < 3; c++)
                    normals->rgb[3 * at + c] = part[0] * a[c] + part[1] * b[c];
            }
    }
}

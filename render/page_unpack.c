// SPDX-License-Identifier: Apache-2.0
// page_unpack.c - what a page shows, read back from its bytes: to measure what packing lost, and to test it.
#include "render/page.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "render/pack_deflate.h"
#include "render/pack_webp.h"
#include "render/page_layout.h"

static const size_t most_bytes = (size_t)1 << 28;

typedef struct unpacking {
    const uint8_t *at; // what is read next; sizes were checked before
    uint32_t ints[SHEEN_PAGE_N_INTS];
    double reals[SHEEN_PAGE_N_REALS];
    size_t n_vertices, n_triangles, n_lights;
    int texels_per_edge;
} unpacking;

static uint32_t get_u32(unpacking *u)
{
    const uint8_t *b = u->at;
    u->at += 4;
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static double get_f64(unpacking *u)
{
    const uint64_t low = get_u32(u), high = get_u32(u), bits = low | high << 32;
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static sheen_status damaged(sheen_err *err)
{
    return sheen_fail(err, SHEEN_EFORMAT, "the packed model is damaged");
}

static sheen_status get_header(unpacking *u, size_t size_bytes, sheen_err *err)
{
    if (size_bytes < SHEEN_PAGE_HEADER_BYTES)
        return damaged(err);
    for (int i = 0; i < SHEEN_PAGE_N_INTS; i++)
        u->ints[i] = get_u32(u);
    for (int i = 0; i < SHEEN_PAGE_N_REALS; i++)
        if (!isfinite(u->reals[i] = get_f64(u)))
            return damaged(err);
    if (u->ints[0] != SHEEN_PAGE_MAGIC)
        return sheen_fail(err, SHEEN_EFORMAT, "this is no packed model, or one of another version");
    u->n_vertices = u->ints[1];
    u->n_triangles = u->ints[2];
    u->n_lights = u->ints[5];
    if (u->n_vertices > SHEEN_PAGE_MAX_VERTICES || !u->n_triangles ||
        u->n_triangles > SHEEN_PAGE_MAX_TRIANGLES || u->n_lights > SHEEN_PAGE_MAX_LIGHTS ||
        u->ints[3] < SHEEN_TEXTURE_MIN_EDGE || u->ints[3] > SHEEN_TEXTURE_MAX_EDGE || u->ints[6] > 1)
        return damaged(err);
    u->texels_per_edge = (int)u->ints[3];
    int columns, width_px, height_px;
    sheen_texture_atlas_size(u->n_triangles, u->texels_per_edge, &columns, &width_px, &height_px);
    if (u->ints[4] != (uint32_t)columns || !(u->reals[0] >= 0) || !(u->reals[1] > 0) || !(u->reals[17] > 0) ||
        size_bytes != sheen_page_bytes(u->n_vertices, u->n_triangles, u->texels_per_edge, u->n_lights))
        return damaged(err);
    return SHEEN_OK;
}

static void normal_of(float n[3], const uint16_t code[2])
{
    const float u = (float)code[0] / 65535.0f * 2 - 1, v = (float)code[1] / 65535.0f * 2 - 1;
    n[2] = 1 - fabsf(u) - fabsf(v);
    const float below = fmaxf(-n[2], 0);
    n[0] = u + (u < 0 ? below : -below);
    n[1] = v + (v < 0 ? below : -below);
    sheen_normalizef(n);
}

static void get_vertices(sheen_mesh *mesh, unpacking *u)
{
    const size_t n = u->n_vertices;
    uint16_t code[5] = {0};
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < 5; k++) {
            const uint32_t folded = u->at[2 * k * n + i] | (uint32_t)u->at[(2 * k + 1) * n + i] << 8;
            code[k] = (uint16_t)(code[k] + ((folded >> 1) ^ (folded & 1 ? 0xffffu : 0u)));
        }
        for (size_t k = 0; k < 3; k++) {
            const float low = (float)u->reals[18 + k], high = (float)u->reals[21 + k];
            mesh->p_obj[3 * i + k] = low + (high - low) * ((float)code[k] / 65535.0f);
        }
        normal_of(mesh->n_obj + 3 * i, code + 3);
    }
    u->at += SHEEN_PAGE_VERTEX_BYTES * n;
}

static sheen_status get_triangles(sheen_mesh *mesh, unpacking *u, sheen_err *err)
{
    const size_t n = 3 * u->n_triangles;
    uint32_t next = 0;
    for (size_t i = 0; i < n; i++) {
        const uint32_t back = u->at[i] | (uint32_t)u->at[n + i] << 8 | (uint32_t)u->at[2 * n + i] << 16;
        if (back > next || next - back >= u->n_vertices)
            return damaged(err);
        mesh->triangles[i] = next - back;
        next += back == 0;
    }
    u->at += SHEEN_PAGE_TRIANGLE_BYTES * u->n_triangles;
    return SHEEN_OK;
}

static sheen_status get_mesh(sheen_mesh *mesh, unpacking *u, sheen_err *err)
{
    mesh->p_obj = malloc(3 * (u->n_vertices + 1) * sizeof *mesh->p_obj);
    mesh->n_obj = malloc(3 * (u->n_vertices + 1) * sizeof *mesh->n_obj);
    mesh->triangles = malloc(3 * u->n_triangles * sizeof *mesh->triangles);
    if (!mesh->p_obj || !mesh->n_obj || !mesh->triangles)
        return sheen_fail_memory(err, 24.0 * (double)(u->n_vertices + u->n_triangles), "a page's mesh");
    mesh->n_vertices = u->n_vertices;
    mesh->n_triangles = u->n_triangles;
    get_vertices(mesh, u);
    return get_triangles(mesh, u, err);
}

static sheen_status get_lights(sheen_model *m, unpacking *u, sheen_err *err)
{
    const sheen_status s = sheen_model_set_lights(m, u->n_lights, err);
    if (s)
        return s;
    for (size_t i = 0; i < u->n_lights; i++) {
        float d[3], weight;
        for (int k = 0; k < 3; k++, u->at += 2) {
            const int code = u->at[0] | u->at[1] << 8;
            d[k] = (float)(code > 32767 ? code - 65536 : code);
        }
        const uint32_t bits = get_u32(u);
        memcpy(&weight, &bits, sizeof weight);
        if (!(sheen_normalizef(d) > 0) || !isfinite(weight) || weight < 0)
            return damaged(err);
        m->lights.dx[i] = d[0];
        m->lights.dy[i] = d[1];
        m->lights.dz[i] = d[2];
        m->lights.weight[i] = weight;
    }
    return SHEEN_OK;
}

static sheen_status get_texture(sheen_texture *t, unpacking *u, const sheen_page *page, sheen_err *err)
{
    int columns, width_px, height_px;
    uint8_t *rgb;
    sheen_image atlas = {0};
    sheen_texture_atlas_size(u->n_triangles, u->texels_per_edge, &columns, &width_px, &height_px);
    sheen_status s = sheen_webp_decode(&rgb, page->texture, page->texture_bytes, width_px, height_px, err);
    if (s)
        return s;
    s = sheen_image_init(&atlas, width_px, height_px, 4, err);
    for (size_t i = 0; !s && i < (size_t)width_px * (size_t)height_px; i++)
        for (size_t c = 0; c < 3; c++)
            atlas.data[4 * i + c] = sheen_transfer_decode(SHEEN_TRANSFER_SRGB,
                                                          (float)rgb[3 * i + c] / 255.0f);
    free(rgb);
    if (!s)
        s = sheen_texture_from_atlas(t, &atlas, u->n_triangles, u->texels_per_edge, err);
    sheen_image_release(&atlas);
    const size_t n = s ? 0 : u->n_triangles * sheen_texels_per_triangle(u->texels_per_edge);
    for (size_t i = 0; i < n; i++)
        t->n_views[i] = u->at[i / 8] >> (i % 8) & 1;
    return s;
}

static void get_numbers(sheen_model *m, sheen_page_view *view, const unpacking *u)
{
    const double *r = u->reals;
    m->k_s = r[0];
    m->sigma_rad = r[1];
    memcpy(m->light_rgb, r + 2, sizeof m->light_rgb);
    memcpy(m->rt_world_obj, r + 5, sizeof m->rt_world_obj);
    m->moving = u->ints[6] ? SHEEN_MOVING_OBJECT : SHEEN_MOVING_CAMERA;
    if (!view)
        return;
    memcpy(view->rt_board_obj, r + 11, sizeof view->rt_board_obj);
    view->focal_per_width = r[17];
}

sheen_status sheen_page_unpack(sheen_model *out, sheen_page_view *view, const sheen_page *page,
                               sheen_err *err)
{
    uint8_t *bytes;
    size_t size_bytes;
    sheen_model_init(out);
    sheen_status s = sheen_inflate(&bytes, &size_bytes, page->geometry, page->geometry_bytes, most_bytes,
                                   err);
    if (s)
        return s;
    unpacking u = {.at = bytes};
    s = get_header(&u, size_bytes, err);
    if (!s)
        s = get_mesh(&out->mesh, &u, err);
    if (!s)
        s = get_lights(out, &u, err);
    if (!s)
        s = get_texture(&out->texture, &u, page, err);
    if (!s)
        get_numbers(out, view, &u);
    free(bytes);
    if (s)
        sheen_model_release(out);
    return s;
}

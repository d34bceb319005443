// SPDX-License-Identifier: Apache-2.0
// page_pack.c - a model in as few bytes as a page should carry.
//
// Vertices are put in the order of their first use, so that a triangle's corner is coded by how far it lies behind
// the next vertex that was not used yet: mostly a small number. Coordinates are differences to the vertex before.
// All numbers are split into planes of bytes, which DEFLATE then finds much alike.
#include "render/page.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "render/pack_deflate.h"
#include "render/pack_webp.h"
#include "render/page_layout.h"

typedef struct packing {
    const sheen_model *model;
    uint8_t *bytes, *at;
    uint32_t *new_of,
        *old_of; // [n_vertices] vertex numbers by first use; those that no triangle uses come last
    float min_obj[3], max_obj[3];
} packing;

void sheen_page_release(sheen_page *page)
{
    free(page->geometry);
    free(page->texture);
    *page = (sheen_page){0};
}

static void put_u32(packing *p, uint32_t x)
{
    for (int k = 0; k < 4; k++)
        *p->at++ = (uint8_t)(x >> (8 * k));
}

static void put_f32(packing *p, float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    put_u32(p, bits);
}

static void put_f64(packing *p, const double *x, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        uint64_t bits;
        memcpy(&bits, &x[i], sizeof bits);
        put_u32(p, (uint32_t)bits);
        put_u32(p, (uint32_t)(bits >> 32));
    }
}

static void put_header(packing *p, const sheen_page_view *view)
{
    const sheen_model *m = p->model;
    int columns, width_px, height_px;
    sheen_texture_atlas_size(m->mesh.n_triangles, m->texture.texels_per_edge, &columns, &width_px,
                             &height_px);
    put_u32(p, SHEEN_PAGE_MAGIC);
    put_u32(p, (uint32_t)m->mesh.n_vertices);
    put_u32(p, (uint32_t)m->mesh.n_triangles);
    put_u32(p, (uint32_t)m->texture.texels_per_edge);
    put_u32(p, (uint32_t)columns);
    put_u32(p, (uint32_t)m->lights.count);
    put_u32(p, m->moving == SHEEN_MOVING_OBJECT);
    put_u32(p, 0);
    put_f64(p, &m->k_s, 1);
    put_f64(p, &m->sigma_rad, 1);
    put_f64(p, m->light_rgb, 3);
    put_f64(p, m->rt_world_obj, 6);
    put_f64(p, view->rt_board_obj, 6);
    put_f64(p, &view->focal_per_width, 1);
    for (int side = 0; side < 2; side++)
        for (int k = 0; k < 3; k++) {
            const double x = (double)(side ? p->max_obj : p->min_obj)[k];
            put_f64(p, &x, 1);
        }
}

static void order_vertices(packing *p)
{
    const sheen_mesh *mesh = &p->model->mesh;
    uint32_t next = 0;
    memset(p->new_of, 0xff, mesh->n_vertices * sizeof *p->new_of);
    for (size_t i = 0; i < 3 * mesh->n_triangles; i++)
        if (p->new_of[mesh->triangles[i]] == UINT32_MAX) {
            p->old_of[next] = mesh->triangles[i];
            p->new_of[mesh->triangles[i]] = next++;
        }
    for (uint32_t v = 0; v < mesh->n_vertices; v++)
        if (p->new_of[v] == UINT32_MAX) {
            p->old_of[next] = v;
            p->new_of[v] = next++;
        }
}

static float sign_of(float x)
{
    return x < 0 ? -1.0f : 1.0f;
}

static uint16_t to_u16(float x) // 0..1
{
    return (uint16_t)(fminf(fmaxf(x, 0), 1) * 65535.0f + 0.5f);
}

// The sphere onto a square by the octahedron.
static void normal_code(uint16_t code[2], const float n[3])
{
    const float l1 = fabsf(n[0]) + fabsf(n[1]) + fabsf(n[2]);
    float u = l1 > 0 ? n[0] / l1 : 0, v = l1 > 0 ? n[1] / l1 : 0;
    if (n[2] < 0) {
        const float folded = (1 - fabsf(v)) * sign_of(u);
        v = (1 - fabsf(u)) * sign_of(v);
        u = folded;
    }
    code[0] = to_u16(0.5f * u + 0.5f);
    code[1] = to_u16(0.5f * v + 0.5f);
}

static void vertex_code(uint16_t code[5], const packing *p, size_t vertex)
{
    const float *x = p->model->mesh.p_obj + 3 * vertex;
    for (int k = 0; k < 3; k++) {
        const float extent = p->max_obj[k] - p->min_obj[k];
        code[k] = extent > 0 ? to_u16((x[k] - p->min_obj[k]) / extent) : 0;
    }
    normal_code(code + 3, p->model->mesh.n_obj + 3 * vertex);
}

static void put_vertices(packing *p)
{
    const size_t n = p->model->mesh.n_vertices;
    uint16_t last[5] = {0};
    for (size_t i = 0; i < n; i++) {
        uint16_t code[5];
        vertex_code(code, p, p->old_of[i]);
        for (size_t k = 0; k < 5; k++) {
            const uint16_t difference = (uint16_t)(code[k] - last[k]);
            // Small differences of either sign become small numbers: 0 -1 1 -2 2 as 0 1 2 3 4.
            const uint16_t folded = (uint16_t)((uint16_t)(difference << 1) ^ (difference >> 15 ? 0xffff : 0));
            p->at[2 * k * n + i] = (uint8_t)folded;
            p->at[(2 * k + 1) * n + i] = (uint8_t)(folded >> 8);
        }
        memcpy(last, code, sizeof last);
    }
    p->at += SHEEN_PAGE_VERTEX_BYTES * n;
}

static void put_triangles(packing *p)
{
    const sheen_mesh *mesh = &p->model->mesh;
    const size_t n = 3 * mesh->n_triangles;
    uint32_t next = 0;
    for (size_t i = 0; i < n; i++) {
        const uint32_t vertex = p->new_of[mesh->triangles[i]], back = next - vertex; // 0: the next new one
        for (size_t k = 0; k < 3; k++)
            p->at[k * n + i] = (uint8_t)(back >> (8 * k));
        next += back == 0;
    }
    p->at += SHEEN_PAGE_TRIANGLE_BYTES * mesh->n_triangles;
}

static void put_lights(packing *p)
{
    const sheen_lights *l = &p->model->lights;
    for (size_t i = 0; i < l->count; i++) {
        const float d[3] = {l->dx[i], l->dy[i], l->dz[i]};
        for (int k = 0; k < 3; k++) {
            const int code = (int)lrintf(32767.0f * fminf(fmaxf(d[k], -1), 1));
            *p->at++ = (uint8_t)(code & 0xff);
            *p->at++ = (uint8_t)((code >> 8) & 0xff);
        }
        put_f32(p, l->weight[i]);
    }
}

static void put_seen(packing *p)
{
    const sheen_texture *t = &p->model->texture;
    const size_t n = t->n_triangles * sheen_texels_per_triangle(t->texels_per_edge),
                 size_bytes = sheen_page_seen_bytes(t->n_triangles, t->texels_per_edge);
    memset(p->at, 0, size_bytes);
    for (size_t i = 0; i < n; i++)
        if (t->n_views[i])
            p->at[i / 8] |= (uint8_t)(1u << (i % 8));
    p->at += size_bytes;
}

static sheen_status pack_geometry(sheen_page *out, const sheen_model *m, const sheen_page_view *view,
                                  sheen_err *err)
{
    packing p = {.model = m};
    const size_t size_bytes = sheen_page_bytes(m->mesh.n_vertices, m->mesh.n_triangles,
                                               m->texture.texels_per_edge, m->lights.count);
    sheen_status s = SHEEN_OK;
    p.at = p.bytes = malloc(size_bytes);
    p.new_of = malloc(m->mesh.n_vertices * sizeof *p.new_of);
    p.old_of = malloc(m->mesh.n_vertices * sizeof *p.old_of);
    if (!p.bytes || !p.new_of || !p.old_of) {
        s = sheen_fail_memory(err, (double)size_bytes, "a packed model");
    } else {
        sheen_mesh_bounds(&m->mesh, p.min_obj, p.max_obj);
        order_vertices(&p);
        put_header(&p, view);
        put_vertices(&p);
        put_triangles(&p);
        put_lights(&p);
        put_seen(&p);
        assert(p.at == p.bytes + size_bytes);
        s = sheen_deflate(&out->geometry, &out->geometry_bytes, p.bytes, size_bytes, err);
    }
    free(p.bytes);
    free(p.new_of);
    free(p.old_of);
    return s;
}

// Unseen texels get the colour of the seen one before them: they are not shown, and cost least so.
static sheen_status pack_texture(sheen_page *out, const sheen_texture *t, sheen_err *err)
{
    sheen_image atlas = {0};
    uint8_t *rgb = NULL;
    sheen_status s = sheen_texture_to_atlas(&atlas, t, err);
    if (s)
        return s;
    const size_t n = (size_t)atlas.width_px * (size_t)atlas.height_px;
    if (!(rgb = malloc(3 * n)))
        s = sheen_fail_memory(err, 3.0 * (double)n, "a page's texture");
    for (size_t i = 0; !s && i < n; i++)
        for (size_t c = 0; c < 3; c++) {
            const float code = sheen_transfer_encode(SHEEN_TRANSFER_SRGB,
                                                     fminf(fmaxf(atlas.data[4 * i + c], 0), 1));
            rgb[3 * i + c] = atlas.data[4 * i + 3] > 0 ? (uint8_t)lrintf(code * 255.0f)
                             : i                       ? rgb[3 * (i - 1) + c]
                                                       : 0;
        }
    if (!s)
        s = sheen_webp_encode(&out->texture, &out->texture_bytes, rgb, atlas.width_px, atlas.height_px, err);
    free(rgb);
    sheen_image_release(&atlas);
    return s;
}

static bool all_finite(const float *x, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (!isfinite(x[i]))
            return false;
    return true;
}

static sheen_status check(const sheen_model *m, const sheen_page_view *view, sheen_err *err)
{
    const sheen_mesh *mesh = &m->mesh;
    if (!mesh->n_triangles || m->texture.n_triangles != mesh->n_triangles)
        return sheen_fail(err, SHEEN_EARG, "a page wants a mesh of triangles with a texture for each");
    if (mesh->n_vertices > SHEEN_PAGE_MAX_VERTICES || mesh->n_triangles > SHEEN_PAGE_MAX_TRIANGLES)
        return sheen_fail(err, SHEEN_EARG,
                          "%zu triangles are too many for a page (at most %d); fit with a mesh of fewer",
                          mesh->n_triangles, SHEEN_PAGE_MAX_TRIANGLES);
    if (m->lights.count > SHEEN_PAGE_MAX_LIGHTS)
        return sheen_fail(err, SHEEN_EARG, "%zu lights are too many for a page (at most %d)", m->lights.count,
                          SHEEN_PAGE_MAX_LIGHTS);
    bool good = isfinite(m->k_s) && m->k_s >= 0 && isfinite(m->sigma_rad) && m->sigma_rad > 0 &&
                isfinite(view->focal_per_width) && view->focal_per_width > 0 &&
                all_finite(mesh->p_obj, 3 * mesh->n_vertices) &&
                all_finite(mesh->n_obj, 3 * mesh->n_vertices) && all_finite(m->lights.dx, m->lights.count) &&
                all_finite(m->lights.dy, m->lights.count) && all_finite(m->lights.dz, m->lights.count) &&
                all_finite(m->lights.weight, m->lights.count);
    for (int k = 0; k < 6; k++)
        good = good && isfinite(m->rt_world_obj[k]) && isfinite(view->rt_board_obj[k]);
    for (int c = 0; c < 3; c++)
        good = good && isfinite(m->light_rgb[c]);
    return good ? SHEEN_OK : sheen_fail(err, SHEEN_EARG, "the model holds numbers that are not usable");
}

sheen_status sheen_page_pack(sheen_page *out, const sheen_model *model, const sheen_page_view *view,
                             sheen_err *err)
{
    *out = (sheen_page){0};
    sheen_status s = check(model, view, err);
    if (!s)
        s = pack_geometry(out, model, view, err);
    if (!s)
        s = pack_texture(out, &model->texture, err);
    if (s)
        sheen_page_release(out);
    return s;
}

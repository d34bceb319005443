// SPDX-License-Identifier: Apache-2.0
// page_pack.c - a model in as few bytes as a page should carry.
//
// Vertices are put in the order of their first use, so that a triangle's corner is coded by how far it lies behind
// the next vertex that was not used yet: mostly a small number. Coordinates are differences to the vertex before.
// All numbers are split into planes of bytes, which DEFLATE then finds much alike.
#include "render/page.h"

#include <assert.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "render/model_private.h"
#include "render/pack_avif.h"
#include "render/pack_deflate.h"
#include "render/page_layout.h"
#include "render/page_normals.h"

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
    free(page->board);
    *page = (sheen_page){0};
}

static void put_u32(packing *p, uint32_t x)
{
    for (int k = 0; k < 4; k++)
        *p->at++ = (uint8_t)(x >> (8 * k));
}

static float brightest(const sheen_image *board)
{
    float most = 0;
    const size_t n = 3 * (size_t)board->width_px * (size_t)board->height_px;
    for (size_t i = 0; i < n; i++)
        most = fmaxf(most, board->data[i]);
    return most > 0 ? most : 1;
}

// Whether texels that no photograph saw have a colour all the same.
static bool is_filled(const sheen_texture *t)
{
    const size_t n = t->n_triangles * sheen_texels_per_triangle(t->texels_per_edge);
    for (size_t i = 0; i < n; i++)
        if (!t->n_views[i] && (t->rgb[3 * i] > 0 || t->rgb[3 * i + 1] > 0 || t->rgb[3 * i + 2] > 0))
            return true;
    return false;
}

static void put_numbers(sheen_json_writer *w, const packing *p, const sheen_page_view *view)
{
    const sheen_model *m = p->model;
    const sheen_image *board = &m->surroundings.board;
    int columns, width_px, height_px;
    sheen_texture_atlas_size(m->mesh.n_triangles, m->texture.texels_per_edge, &columns, &width_px,
                             &height_px);
    sheen_json_open(w, NULL, '{');
    sheen_json_put_string(w, "schema", SHEEN_PAGE_SCHEMA "/2");
    sheen_json_put_int(w, "n_vertices", (long long)m->mesh.n_vertices);
    sheen_json_put_int(w, "n_triangles", (long long)m->mesh.n_triangles);
    sheen_json_put_int(w, "texels_per_edge", m->texture.texels_per_edge);
    if (is_filled(&m->texture))
        sheen_json_put_bool(w, "filled", true);
    sheen_json_put_int(w, "columns", columns);
    if (m->normals.n_triangles) {
        sheen_json_put_int(w, "normals_texels_per_edge", m->normals.texels_per_edge);
        sheen_json_put_number(w, "normals_step_rad", sheen_page_normals_step(m->sigma_rad));
    }
    sheen_json_put_numbers(w, "rt_board_obj", view->rt_board_obj, 6);
    sheen_json_put_number(w, "focal_per_width", view->focal_per_width);
    for (int side = 0; side < 2; side++) {
        const float *corner = side ? p->max_obj : p->min_obj;
        const double x[3] = {(double)corner[0], (double)corner[1], (double)corner[2]};
        sheen_json_put_numbers(w, side ? "max_obj" : "min_obj", x, 3);
    }
    if (board->data) {
        const double size_px[2] = {board->width_px, board->height_px};
        sheen_json_put_numbers(w, "board_size_px", size_px, 2);
        sheen_json_put_number(w, "board_white", (double)brightest(board));
    }
    sheen_json_open(w, "model", '{');
    sheen_model_put_numbers(w, m);
    sheen_json_close(w);
    sheen_json_close(w);
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

static void vertex_code(uint16_t code[5], const packing *p, size_t vertex)
{
    const float *x = p->model->mesh.p_obj + 3 * vertex;
    for (int k = 0; k < 3; k++) {
        const float extent = p->max_obj[k] - p->min_obj[k];
        code[k] = extent > 0 ? sheen_page_u16((x[k] - p->min_obj[k]) / extent) : 0;
    }
    sheen_page_normal_code(code + 3, p->model->mesh.n_obj + 3 * vertex);
}

static void put_vertices(packing *p)
{
    const size_t n = p->model->mesh.n_vertices;
    uint16_t last[5] = {0};
    for (size_t i = 0; i < n; i++) {
        uint16_t code[5];
        vertex_code(code, p, p->old_of[i]);
        for (size_t k = 0; k < 5; k++) {
            const uint16_t folded = sheen_page_fold((uint16_t)(code[k] - last[k]));
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

// Against the vertex normals as the reader will have them.
static sheen_status put_normals(packing *p, sheen_err *err)
{
    const sheen_texture *normals = &p->model->normals;
    sheen_mesh mesh = p->model->mesh;
    if (!normals->n_triangles)
        return SHEEN_OK;
    const size_t n_bytes = (3 * mesh.n_vertices + 1) * sizeof *mesh.n_obj;
    if (!(mesh.n_obj = malloc(n_bytes)))
        return sheen_fail_memory(err, (double)n_bytes, "normals");
    for (size_t i = 0; i < mesh.n_vertices; i++) {
        uint16_t code[2];
        sheen_page_normal_code(code, p->model->mesh.n_obj + 3 * i);
        sheen_page_normal_of(mesh.n_obj + 3 * i, code);
    }
    sheen_page_normals_put(p->at, normals, &mesh, sheen_page_normals_step(p->model->sigma_rad));
    p->at += sheen_page_normals_bytes(mesh.n_triangles, normals->texels_per_edge);
    free(mesh.n_obj);
    return SHEEN_OK;
}

static sheen_status pack_surface(sheen_page *out, packing *p, const char *json, sheen_err *err)
{
    const sheen_mesh *mesh = &p->model->mesh;
    const size_t json_bytes = strlen(json),
                 size_bytes = SHEEN_PAGE_HEADER_BYTES + json_bytes +
                              sheen_page_surface_bytes(mesh->n_vertices, mesh->n_triangles,
                                                       p->model->texture.texels_per_edge,
                                                       p->model->normals.texels_per_edge);
    p->at = p->bytes = malloc(size_bytes);
    if (!p->bytes || json_bytes > UINT32_MAX)
        return sheen_fail_memory(err, (double)size_bytes, "a packed model");
    put_u32(p, SHEEN_PAGE_MAGIC);
    put_u32(p, (uint32_t)json_bytes);
    memcpy(p->at, json, json_bytes);
    p->at += json_bytes;
    put_vertices(p);
    put_triangles(p);
    put_seen(p);
    const sheen_status s = put_normals(p, err);
    assert(s || p->at == p->bytes + size_bytes);
    return s ? s : sheen_deflate(&out->geometry, &out->geometry_bytes, p->bytes, size_bytes, err);
}

static sheen_status pack_geometry(sheen_page *out, const sheen_model *m, const sheen_page_view *view,
                                  sheen_err *err)
{
    packing p = {.model = m};
    sheen_json_writer w = {0};
    sheen_status s;
    p.new_of = malloc(m->mesh.n_vertices * sizeof *p.new_of);
    p.old_of = malloc(m->mesh.n_vertices * sizeof *p.old_of);
    sheen_mesh_bounds(&m->mesh, p.min_obj, p.max_obj);
    put_numbers(&w, &p, view);
    const char *json = sheen_json_text(&w);
    if (!json || !p.new_of || !p.old_of) {
        s = sheen_fail_memory(err, 8.0 * (double)m->mesh.n_vertices, "a packed model");
    } else {
        order_vertices(&p);
        s = pack_surface(out, &p, json, err);
    }
    sheen_json_writer_release(&w);
    free(p.bytes);
    free(p.new_of);
    free(p.old_of);
    return s;
}

static uint8_t code_of(float light)
{
    return (uint8_t)lrintf(sheen_transfer_encode(SHEEN_TRANSFER_SRGB, fminf(fmaxf(light, 0), 1)) * 255.0f);
}

// Unseen texels without a colour get that of the one before them: they are not shown, and cost least so.
static sheen_status pack_texture(sheen_page *out, const sheen_texture *t, const sheen_page_options *o,
                                 sheen_err *err)
{
    sheen_image atlas = {0};
    uint8_t *rgb = NULL;
    sheen_status s = sheen_texture_to_atlas(&atlas, t, err);
    if (s)
        return s;
    const size_t n = (size_t)atlas.width_px * (size_t)atlas.height_px;
    const bool filled = is_filled(t);
    if (!(rgb = malloc(3 * n)))
        s = sheen_fail_memory(err, 3.0 * (double)n, "a page's texture");
    for (size_t i = 0; !s && i < n; i++)
        for (size_t c = 0; c < 3; c++)
            rgb[3 * i + c] = filled || atlas.data[4 * i + 3] > 0 ? code_of(atlas.data[4 * i + c])
                             : i                                 ? rgb[3 * (i - 1) + c]
                                                                 : 0;
    if (!s)
        s = sheen_avif_encode(&out->texture, &out->texture_bytes, rgb, atlas.width_px, atlas.height_px,
                              o->quantizer, o->n_threads, err);
    free(rgb);
    sheen_image_release(&atlas);
    return s;
}

// A surface mirrors some twentieth of the board: a coarser code than the texture's does.
static sheen_status pack_board(sheen_page *out, const sheen_image *board, int n_threads, sheen_err *err)
{
    enum { BOARD_QUANTIZER = 12 };
    if (!board->data)
        return SHEEN_OK;
    const float white = brightest(board);
    const size_t n = 3 * (size_t)board->width_px * (size_t)board->height_px;
    uint8_t *rgb = malloc(n);
    if (!rgb)
        return sheen_fail_memory(err, (double)n, "a page's board");
    for (size_t i = 0; i < n; i++)
        rgb[i] = code_of(board->data[i] / white);
    const sheen_status s = sheen_avif_encode(&out->board, &out->board_bytes, rgb, board->width_px,
                                             board->height_px, BOARD_QUANTIZER, n_threads, err);
    free(rgb);
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
    if (m->normals.n_triangles && m->normals.n_triangles != mesh->n_triangles)
        return sheen_fail(err, SHEEN_EARG, "the normal map has %zu triangles, the mesh %zu",
                          m->normals.n_triangles, mesh->n_triangles);
    if (mesh->n_vertices > SHEEN_PAGE_MAX_VERTICES || mesh->n_triangles > SHEEN_PAGE_MAX_TRIANGLES)
        return sheen_fail(err, SHEEN_EARG,
                          "%zu triangles are too many for a page (at most %d); fit with a mesh of fewer",
                          mesh->n_triangles, SHEEN_PAGE_MAX_TRIANGLES);
    if (m->surroundings.board.data && (m->surroundings.board.width_px > SHEEN_PAGE_MAX_BOARD_SIDE_PX ||
                                       m->surroundings.board.height_px > SHEEN_PAGE_MAX_BOARD_SIDE_PX))
        return sheen_fail(err, SHEEN_EARG, "a board of %d x %d px is too large for a page",
                          m->surroundings.board.width_px, m->surroundings.board.height_px);
    bool good = isfinite(view->focal_per_width) && view->focal_per_width > 0 &&
                all_finite(mesh->p_obj, 3 * mesh->n_vertices) &&
                all_finite(mesh->n_obj, 3 * mesh->n_vertices);
    for (int k = 0; k < 6; k++)
        good = good && isfinite(view->rt_board_obj[k]);
    return good ? SHEEN_OK : sheen_fail(err, SHEEN_EARG, "the model holds numbers that are not usable");
}

sheen_status sheen_page_pack(sheen_page *out, const sheen_model *model, const sheen_page_view *view,
                             const sheen_page_options *options, sheen_err *err)
{
    *out = (sheen_page){0};
    sheen_status s = check(model, view, err);
    if (!s)
        s = sheen_model_check(model, SHEEN_EARG, err);
    if (!s)
        s = pack_geometry(out, model, view, err);
    if (!s)
        s = pack_texture(out, &model->texture, options, err);
    if (!s)
        s = pack_board(out, &model->surroundings.board, options->n_threads, err);
    if (s)
        sheen_page_release(out);
    return s;
}

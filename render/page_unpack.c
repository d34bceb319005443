// SPDX-License-Identifier: Apache-2.0
// page_unpack.c - what a page shows, read back from its bytes: to measure what packing lost, and to test it.
#include "render/page.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "render/pack_avif.h"
#include "render/pack_deflate.h"
#include "render/page_layout.h"

static const size_t most_bytes = (size_t)1 << 28;

typedef struct unpacking {
    const uint8_t *at; // what is read next; sizes were checked before
    double min_obj[3], max_obj[3], board_white;
    size_t n_vertices, n_triangles;
    bool filled;                                          // unseen texels have a colour
    int texels_per_edge, board_width_px, board_height_px; // 0 x 0: no board
    int normals_texels_per_edge;                          // 0: no normal map
    double normals_step_rad;
} unpacking;

static sheen_status damaged(sheen_err *err)
{
    return sheen_fail(err, SHEEN_EFORMAT, "the packed model is damaged");
}

static uint32_t get_u32(unpacking *u)
{
    const uint8_t *b = u->at;
    u->at += 4;
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static sheen_status get_sizes(unpacking *u, const sheen_json *root, sheen_err *err)
{
    int n_vertices, n_triangles, columns, want_columns, width_px, height_px;
    double board_size_px[2];
    sheen_status s;
    if ((s = sheen_json_int(root, "n_vertices", 1, SHEEN_PAGE_MAX_VERTICES, &n_vertices, err)) ||
        (s = sheen_json_int(root, "n_triangles", 1, SHEEN_PAGE_MAX_TRIANGLES, &n_triangles, err)) ||
        (s = sheen_json_int(root, "texels_per_edge", SHEEN_TEXTURE_MIN_EDGE, SHEEN_TEXTURE_MAX_EDGE,
                            &u->texels_per_edge, err)) ||
        (s = sheen_json_int(root, "columns", 1, SHEEN_IMAGE_MAX_SIDE_PX, &columns, err)) ||
        (s = sheen_json_numbers(root, "min_obj", u->min_obj, 3, err)) ||
        (s = sheen_json_numbers(root, "max_obj", u->max_obj, 3, err)))
        return s;
    u->n_vertices = (size_t)n_vertices;
    u->n_triangles = (size_t)n_triangles;
    u->filled = sheen_json_get(root, "filled") != NULL;
    sheen_texture_atlas_size(u->n_triangles, u->texels_per_edge, &want_columns, &width_px, &height_px);
    if (columns != want_columns)
        return damaged(err);
    if (sheen_json_get(root, "normals_texels_per_edge") &&
        ((s = sheen_json_int(root, "normals_texels_per_edge", SHEEN_TEXTURE_MIN_EDGE, SHEEN_TEXTURE_MAX_EDGE,
                             &u->normals_texels_per_edge, err)) ||
         (s = sheen_json_number(root, "normals_step_rad", &u->normals_step_rad, err))))
        return s;
    if (!(u->normals_step_rad >= 0 && u->normals_step_rad <= 1))
        return damaged(err);
    if (!sheen_json_get(root, "board_size_px"))
        return SHEEN_OK;
    if ((s = sheen_json_numbers(root, "board_size_px", board_size_px, 2, err)) ||
        (s = sheen_json_number(root, "board_white", &u->board_white, err)))
        return s;
    for (int k = 0; k < 2; k++)
        if (!(board_size_px[k] >= 1 && board_size_px[k] <= SHEEN_PAGE_MAX_BOARD_SIDE_PX))
            return damaged(err);
    u->board_width_px = (int)board_size_px[0];
    u->board_height_px = (int)board_size_px[1];
    return u->board_white > 0 ? SHEEN_OK : damaged(err);
}

static sheen_status get_numbers(sheen_model *m, sheen_page_view *view, unpacking *u, const sheen_json *root,
                                sheen_err *err)
{
    int version;
    sheen_page_view ignored = {.focal_per_width = 0}, *v = view ? view : &ignored;
    sheen_status s;
    if ((s = sheen_json_schema(root, SHEEN_PAGE_SCHEMA, SHEEN_PAGE_VERSION, &version, err)) ||
        (s = get_sizes(u, root, err)) ||
        (s = sheen_json_numbers(root, "rt_board_obj", v->rt_board_obj, 6, err)) ||
        (s = sheen_json_number(root, "focal_per_width", &v->focal_per_width, err)))
        return s;
    if (!(v->focal_per_width > 0))
        return damaged(err);
    return sheen_model_get_numbers(m, sheen_json_get(root, "model"), err);
}

// The JSON text before the surface, and whether the rest has the size that it says.
static sheen_status get_header(sheen_model *m, sheen_page_view *view, unpacking *u, size_t size_bytes,
                               sheen_err *err)
{
    sheen_json *root = NULL;
    if (size_bytes < SHEEN_PAGE_HEADER_BYTES)
        return damaged(err);
    if (get_u32(u) != SHEEN_PAGE_MAGIC)
        return sheen_fail(err, SHEEN_EFORMAT, "this is no packed model, or one of another version");
    const size_t json_bytes = get_u32(u), rest_bytes = size_bytes - SHEEN_PAGE_HEADER_BYTES;
    if (json_bytes > rest_bytes)
        return damaged(err);
    sheen_status s = sheen_json_parse(&root, u->at, json_bytes, err);
    if (!s)
        s = get_numbers(m, view, u, root, err);
    sheen_json_free(&root);
    u->at += json_bytes;
    if (!s &&
        rest_bytes - json_bytes != sheen_page_surface_bytes(u->n_vertices, u->n_triangles, u->texels_per_edge,
                                                            u->normals_texels_per_edge))
        s = damaged(err);
    return s;
}

static void get_vertices(sheen_mesh *mesh, unpacking *u)
{
    const size_t n = u->n_vertices;
    uint16_t code[5] = {0};
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < 5; k++) {
            const uint16_t folded = (uint16_t)(u->at[2 * k * n + i] | u->at[(2 * k + 1) * n + i] << 8);
            code[k] = (uint16_t)(code[k] + sheen_page_unfold(folded));
        }
        for (size_t k = 0; k < 3; k++) {
            const float low = (float)u->min_obj[k], high = (float)u->max_obj[k];
            mesh->p_obj[3 * i + k] = low + (high - low) * ((float)code[k] / 65535.0f);
        }
        sheen_page_normal_of(mesh->n_obj + 3 * i, code + 3);
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

static sheen_status get_texture(sheen_texture *t, unpacking *u, const sheen_page *page, sheen_err *err)
{
    int columns, width_px, height_px;
    uint8_t *rgb;
    sheen_image atlas = {0};
    sheen_texture_atlas_size(u->n_triangles, u->texels_per_edge, &columns, &width_px, &height_px);
    sheen_status s = sheen_avif_decode(&rgb, page->texture, page->texture_bytes, width_px, height_px, err);
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
    for (size_t i = 0; i < n; i++) {
        t->n_views[i] = u->at[i / 8] >> (i % 8) & 1;
        if (!t->n_views[i] && !u->filled) // its colour served the coding only
            memset(t->rgb + 3 * i, 0, 3 * sizeof *t->rgb);
    }
    u->at += sheen_page_seen_bytes(u->n_triangles, u->texels_per_edge);
    return s;
}

static sheen_status get_normals(sheen_model *m, unpacking *u, sheen_err *err)
{
    if (!u->normals_texels_per_edge)
        return SHEEN_OK;
    const sheen_status s = sheen_normal_map_init(&m->normals, u->n_triangles, u->normals_texels_per_edge,
                                                 err);
    if (!s)
        sheen_page_normals_get(&m->normals, u->at, &m->mesh, u->normals_step_rad);
    return s;
}

static sheen_status get_board(sheen_image *board, const unpacking *u, const sheen_page *page, sheen_err *err)
{
    uint8_t *rgb;
    if (!u->board_width_px)
        return SHEEN_OK;
    sheen_status s = sheen_avif_decode(&rgb, page->board, page->board_bytes, u->board_width_px,
                                       u->board_height_px, err);
    if (s)
        return s;
    s = sheen_image_init(board, u->board_width_px, u->board_height_px, 3, err);
    const size_t n = s ? 0 : 3 * (size_t)u->board_width_px * (size_t)u->board_height_px;
    for (size_t i = 0; i < n; i++)
        board->data[i] = (float)u->board_white *
                         sheen_transfer_decode(SHEEN_TRANSFER_SRGB, (float)rgb[i] / 255.0f);
    free(rgb);
    return s;
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
    s = get_header(out, view, &u, size_bytes, err);
    if (!s)
        s = get_mesh(&out->mesh, &u, err);
    if (!s)
        s = get_texture(&out->texture, &u, page, err);
    if (!s)
        s = get_normals(out, &u, err);
    if (!s)
        s = get_board(&out->surroundings.board, &u, page, err);
    free(bytes);
    if (s)
        sheen_model_release(out);
    return s;
}

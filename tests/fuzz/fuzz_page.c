// SPDX-License-Identifier: Apache-2.0
// fuzz_page.c - any bytes as a packed model: what is accepted can be drawn. The input is the length of the geometry
// (2 bytes, little-endian), the geometry before it was deflated, and a picture, taken for both texture and board.
#include <math.h>
#include <stdlib.h>

#include "render/pack_deflate.h"
#include "render/page.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    sheen_err err;
    sheen_model m;
    sheen_page page = {0};
    if (size_bytes < 2)
        return 0;
    size_t geometry_bytes = data[0] | (size_t)data[1] << 8;
    geometry_bytes = geometry_bytes > size_bytes - 2 ? size_bytes - 2 : geometry_bytes;
    const uint8_t *texture = data + 2 + geometry_bytes;
    page.texture_bytes = page.board_bytes = size_bytes - 2 - geometry_bytes;
    page.texture = malloc(page.texture_bytes + 1);
    page.board = malloc(page.board_bytes + 1);
    for (size_t i = 0; page.texture && page.board && i < page.texture_bytes; i++)
        page.texture[i] = page.board[i] = texture[i];
    if (page.texture && page.board &&
        !sheen_deflate(&page.geometry, &page.geometry_bytes, data + 2, geometry_bytes, &err) &&
        !sheen_page_unpack(&m, NULL, &page, &err)) {
        for (size_t i = 0; i < 3 * m.mesh.n_triangles; i++)
            if (m.mesh.triangles[i] >= m.mesh.n_vertices)
                abort();
        for (size_t i = 0; i < m.lights.count; i++)
            if (!isfinite(m.lights.weight[i]) || !(m.lights.weight[i] >= 0))
                abort();
        const size_t n = m.normals.n_triangles * sheen_texels_per_triangle(m.normals.texels_per_edge);
        for (size_t i = 0; i < 3 * n; i++)
            if (!(fabsf(m.normals.rgb[i]) <= 2 * SHEEN_NORMAL_MAP_MOST))
                abort();
        sheen_model_release(&m);
    }
    sheen_page_release(&page);
    return 0;
}

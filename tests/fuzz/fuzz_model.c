// SPDX-License-Identifier: Apache-2.0
// fuzz_model.c - any bytes as a model.json: what is accepted is in range and can be drawn with.
#include <math.h>
#include <stdlib.h>

#include "render/model.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    sheen_err err;
    sheen_model m;
    size_t n_triangles;
    int texels_per_edge;
    if (sheen_model_parse(&m, data, size_bytes, &n_triangles, &texels_per_edge, &err))
        return 0;
    if (!n_triangles || texels_per_edge < SHEEN_TEXTURE_MIN_EDGE || texels_per_edge > SHEEN_TEXTURE_MAX_EDGE)
        abort();
    if (!(m.sigma_rad > 0) || m.lights.count > m.n_hemisphere || !m.method[0])
        abort();
    for (size_t i = 0; i < m.lights.count; i++)
        if (m.node[i] >= m.n_hemisphere || !isfinite(m.lights.weight[i]) || !(m.lights.weight[i] >= 0))
            abort();
    const float up[3] = {0, 0, 1};
    sheen_light_cells *cells;
    if (!sheen_light_cells_new(&cells, &m.lights, (float)m.sigma_rad, &err)) {
        if (isnan(sheen_light_cells_sum(cells, up, up)))
            abort();
        sheen_light_cells_free(&cells);
    }
    sheen_model_release(&m);
    return 0;
}

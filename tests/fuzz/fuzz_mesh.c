// SPDX-License-Identifier: Apache-2.0
// fuzz_mesh.c - any bytes as a mesh in a file of name MESH_NAME: what is read holds what mesh.h promises.
#include <math.h>
#include <stdlib.h>

#include "base/mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    sheen_err err;
    sheen_mesh mesh;
    if (sheen_mesh_parse(&mesh, data, size_bytes, MESH_NAME, &err))
        return 0;
    for (size_t i = 0; i < 3 * mesh.n_triangles; i++)
        if (mesh.triangles[i] >= mesh.n_vertices)
            abort();
    for (size_t i = 0; i < mesh.n_vertices; i++) {
        const float *n = mesh.n_obj + 3 * i;
        if (!(fabsf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1) < 1e-4f))
            abort();
    }
    float centre_obj[3], radius_m;
    sheen_mesh_sphere(&mesh, centre_obj, &radius_m);
    if (!isfinite(radius_m) || !(radius_m > 0))
        abort();
    sheen_mesh_release(&mesh);
    return 0;
}

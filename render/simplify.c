// SPDX-License-Identifier: Apache-2.0
// simplify.c - the one door to meshoptimizer.
#include "render/simplify.h"

#include <meshoptimizer.h>
#include <stdlib.h>
#include <string.h>

static sheen_status take_used(sheen_mesh *out, const sheen_mesh *mesh, const uint32_t *indices, size_t n,
                              sheen_err *err)
{
    uint32_t *number = malloc(mesh->n_vertices * sizeof *number);
    *out = (sheen_mesh){.n_triangles = n / 3};
    out->triangles = malloc((n + 1) * sizeof *out->triangles);
    out->p_obj = malloc(3 * mesh->n_vertices * sizeof *out->p_obj);
    out->n_obj = malloc(3 * mesh->n_vertices * sizeof *out->n_obj);
    if (!number || !out->triangles || !out->p_obj || !out->n_obj) {
        free(number);
        sheen_mesh_release(out);
        return sheen_fail_memory(err, 28.0 * (double)mesh->n_vertices, "a simpler mesh");
    }
    memset(number, 0xff, mesh->n_vertices * sizeof *number);
    for (size_t i = 0; i < n; i++) {
        const uint32_t v = indices[i];
        if (number[v] == UINT32_MAX) {
            number[v] = (uint32_t)out->n_vertices;
            memcpy(out->p_obj + 3 * out->n_vertices, mesh->p_obj + 3 * (size_t)v, 3 * sizeof(float));
            memcpy(out->n_obj + 3 * out->n_vertices, mesh->n_obj + 3 * (size_t)v, 3 * sizeof(float));
            out->n_vertices++;
        }
        out->triangles[i] = number[v];
    }
    free(number);
    return SHEEN_OK;
}

sheen_status sheen_mesh_simplify(sheen_mesh *out, const sheen_mesh *mesh, size_t max_triangles,
                                 double *error_m, sheen_err *err)
{
    const size_t n = 3 * mesh->n_triangles;
    uint32_t *indices = malloc(n * sizeof *indices);
    *out = (sheen_mesh){0};
    *error_m = 0;
    if (!indices)
        return sheen_fail_memory(err, (double)(n * sizeof *indices), "a simpler mesh");
    size_t n_left = n;
    if (mesh->n_triangles > max_triangles) {
        float error = 0, low[3], high[3], extent_m = 0;
        n_left = meshopt_simplify(indices, mesh->triangles, n, mesh->p_obj, mesh->n_vertices,
                                  3 * sizeof(float), 3 * max_triangles, 1, 0, &error);
        sheen_mesh_bounds(mesh, low, high);
        for (int k = 0; k < 3; k++)
            extent_m = high[k] - low[k] > extent_m ? high[k] - low[k] : extent_m;
        *error_m = (double)(error * extent_m); // meshoptimizer states it as a share of the largest extent
    } else {
        memcpy(indices, mesh->triangles, n * sizeof *indices);
    }
    const sheen_status s = take_used(out, mesh, indices, n_left, err);
    free(indices);
    return s;
}

// SPDX-License-Identifier: Apache-2.0
// mesh.c - triangle meshes in memory: normals, bounds.
#include "base/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"

void sheen_mesh_release(sheen_mesh *mesh)
{
    free(mesh->p_obj);
    free(mesh->n_obj);
    free(mesh->triangles);
    *mesh = (sheen_mesh){0};
}

// The cross product of two edges is the normal times twice the area: sums weigh by area.
void sheen_mesh_compute_normals(sheen_mesh *mesh)
{
    memset(mesh->n_obj, 0, 3 * mesh->n_vertices * sizeof *mesh->n_obj);
    for (size_t i = 0; i < mesh->n_triangles; i++) {
        const uint32_t *t = mesh->triangles + 3 * i;
        const float *p0 = mesh->p_obj + 3 * (size_t)t[0];
        float e1[3], e2[3], n[3];
        sheen_subf(e1, mesh->p_obj + 3 * (size_t)t[1], p0);
        sheen_subf(e2, mesh->p_obj + 3 * (size_t)t[2], p0);
        sheen_crossf(n, e1, e2);
        for (int k = 0; k < 3; k++)
            for (int c = 0; c < 3; c++)
                mesh->n_obj[3 * (size_t)t[k] + (size_t)c] += n[c];
    }
    for (size_t i = 0; i < mesh->n_vertices; i++) {
        float *n = mesh->n_obj + 3 * i;
        double wide[3] = {(double)n[0], (double)n[1], (double)n[2]}; // squares of tiny areas vanish in float
        const double length = sheen_normalize(wide);
        for (int c = 0; c < 3; c++)
            n[c] = length > 0 ? (float)wide[c] : c == 2 ? 1.0f : 0.0f;
    }
}

void sheen_mesh_bounds(const sheen_mesh *mesh, float min_obj[3], float max_obj[3])
{
    for (int c = 0; c < 3; c++)
        min_obj[c] = max_obj[c] = mesh->n_vertices ? mesh->p_obj[c] : 0;
    for (size_t i = 0; i < mesh->n_vertices; i++)
        for (int c = 0; c < 3; c++) {
            min_obj[c] = fminf(min_obj[c], mesh->p_obj[3 * i + (size_t)c]);
            max_obj[c] = fmaxf(max_obj[c], mesh->p_obj[3 * i + (size_t)c]);
        }
}

void sheen_mesh_sphere(const sheen_mesh *mesh, float centre_obj[3], float *radius_m)
{
    float min_obj[3], max_obj[3];
    sheen_mesh_bounds(mesh, min_obj, max_obj);
    for (int c = 0; c < 3; c++)
        centre_obj[c] = 0.5f * (min_obj[c] + max_obj[c]);
    double r2 = 0;
    for (size_t i = 0; i < mesh->n_vertices; i++) {
        double d[3];
        for (int c = 0; c < 3; c++)
            d[c] = (double)mesh->p_obj[3 * i + (size_t)c] - (double)centre_obj[c];
        r2 = fmax(r2, sheen_dot(d, d));
    }
    *radius_m = (float)(sqrt(r2) * (1 + 1e-6)); // rounding must not leave a vertex outside
}

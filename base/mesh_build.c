// SPDX-License-Identifier: Apache-2.0
// mesh_build.c - gathers vertices and triangles from a file, checks each, and completes them to a mesh.
#include "base/mesh_build.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"

static const double max_extent_m = 1e9; // its square still fits a float with room to spare

// realloc by doubling; the array stays as it was where that fails.
static bool grow(void **array, size_t *capacity, size_t wanted, size_t item_bytes)
{
    if (wanted <= *capacity)
        return true;
    const size_t grown = wanted > 2 * *capacity ? wanted : 2 * *capacity;
    void *p = realloc(*array, grown * item_bytes);
    if (!p)
        return false;
    *array = p;
    *capacity = grown;
    return true;
}

static bool grow_vertices(sheen_mesh_build *b, size_t wanted)
{
    size_t capacity = b->vertex_capacity;
    void *p = b->mesh.p_obj, *n = b->mesh.n_obj;
    bool ok = grow(&p, &capacity, wanted, 3 * sizeof(float));
    b->mesh.p_obj = p;
    capacity = b->vertex_capacity;
    ok = ok && grow(&n, &capacity, wanted, 3 * sizeof(float));
    b->mesh.n_obj = n;
    if (ok)
        b->vertex_capacity = capacity;
    return ok;
}

static bool grow_triangles(sheen_mesh_build *b, size_t wanted)
{
    void *t = b->mesh.triangles;
    const bool ok = grow(&t, &b->triangle_capacity, wanted, 3 * sizeof(uint32_t));
    b->mesh.triangles = t;
    return ok;
}

sheen_status sheen_mesh_build_reserve(sheen_mesh_build *b, size_t n_vertices, size_t n_triangles,
                                      sheen_err *err)
{
    if (n_vertices > SHEEN_MESH_MAX_VERTICES - b->mesh.n_vertices)
        return sheen_fail(err, SHEEN_EFORMAT, "more than %d vertices: simplify the mesh first",
                          SHEEN_MESH_MAX_VERTICES);
    if (n_triangles > SHEEN_MESH_MAX_TRIANGLES - b->mesh.n_triangles)
        return sheen_fail(err, SHEEN_EFORMAT, "more than %d triangles: simplify the mesh first",
                          SHEEN_MESH_MAX_TRIANGLES);
    if (!grow_vertices(b, b->mesh.n_vertices + n_vertices) ||
        !grow_triangles(b, b->mesh.n_triangles + n_triangles))
        return sheen_fail_memory(err, 24.0 * (double)n_vertices + 12.0 * (double)n_triangles, "a mesh");
    return SHEEN_OK;
}

// Normals in files are often not finite where a triangle is degenerate: zero here, found from the triangles later.
void sheen_mesh_build_normal(sheen_mesh_build *b, size_t i, const double n_obj[3])
{
    const double length = sheen_norm(n_obj);
    const bool usable = isfinite(length) && length > 1e-12;
    for (int k = 0; k < 3; k++)
        b->mesh.n_obj[3 * i + (size_t)k] = usable ? (float)(n_obj[k] / length) : 0;
}

sheen_status sheen_mesh_build_vertex(sheen_mesh_build *b, const double p_obj[3], const double *n_obj,
                                     sheen_err *err)
{
    const size_t i = b->mesh.n_vertices;
    for (int k = 0; k < 3; k++) {
        if (!isfinite(p_obj[k]))
            return sheen_fail(err, SHEEN_EFORMAT, "vertex %zu is not finite", i);
        if (fabs(p_obj[k]) > max_extent_m)
            return sheen_fail(err, SHEEN_EFORMAT, "vertex %zu lies %g m out, further than any object", i,
                              fabs(p_obj[k]));
    }
    if (i == b->vertex_capacity) {
        const sheen_status s = sheen_mesh_build_reserve(b, 1, 0, err);
        if (s)
            return s;
    }
    for (int k = 0; k < 3; k++)
        b->mesh.p_obj[3 * i + (size_t)k] = (float)p_obj[k];
    const double none[3] = {0};
    sheen_mesh_build_normal(b, i, n_obj ? n_obj : none);
    b->mesh.n_vertices++;
    return SHEEN_OK;
}

sheen_status sheen_mesh_build_triangle(sheen_mesh_build *b, int64_t i0, int64_t i1, int64_t i2,
                                       size_t n_vertices, sheen_err *err)
{
    const int64_t i[3] = {i0, i1, i2};
    for (int k = 0; k < 3; k++)
        if (i[k] < 0 || (uint64_t)i[k] >= n_vertices)
            return sheen_fail(err, SHEEN_EFORMAT, "a polygon names vertex %lld of %zu", (long long)i[k],
                              n_vertices);
    if (i0 == i1 || i1 == i2 || i2 == i0)
        return SHEEN_OK;
    if (b->mesh.n_triangles == b->triangle_capacity) {
        const sheen_status s = sheen_mesh_build_reserve(b, 0, 1, err);
        if (s)
            return s;
    }
    uint32_t *t = b->mesh.triangles + 3 * b->mesh.n_triangles++;
    for (int k = 0; k < 3; k++)
        t[k] = (uint32_t)i[k];
    return SHEEN_OK;
}

// An area that rounding could have made counts as none.
static bool has_area(const sheen_mesh *mesh, const uint32_t t[3])
{
    double e1[3], e2[3], cross[3];
    for (int k = 0; k < 3; k++) {
        const double p0 = (double)mesh->p_obj[3 * (size_t)t[0] + (size_t)k];
        e1[k] = (double)mesh->p_obj[3 * (size_t)t[1] + (size_t)k] - p0;
        e2[k] = (double)mesh->p_obj[3 * (size_t)t[2] + (size_t)k] - p0;
    }
    sheen_cross(cross, e1, e2);
    return sheen_norm(cross) > 1e-12 * (sheen_dot(e1, e1) + sheen_dot(e2, e2));
}

static sheen_status complete_normals(sheen_mesh *mesh, sheen_err *err)
{
    bool complete = true;
    for (size_t i = 0; i < mesh->n_vertices && complete; i++)
        complete = sheen_dotf(mesh->n_obj + 3 * i, mesh->n_obj + 3 * i) > 0;
    if (complete)
        return SHEEN_OK;
    sheen_mesh found = *mesh;
    const size_t size_bytes = 3 * mesh->n_vertices * sizeof(float);
    found.n_obj = malloc(size_bytes);
    if (!found.n_obj)
        return sheen_fail_memory(err, (double)size_bytes, "normals");
    sheen_mesh_compute_normals(&found);
    for (size_t i = 0; i < mesh->n_vertices; i++)
        if (!(sheen_dotf(mesh->n_obj + 3 * i, mesh->n_obj + 3 * i) > 0))
            memcpy(mesh->n_obj + 3 * i, found.n_obj + 3 * i, 3 * sizeof(float));
    free(found.n_obj);
    return SHEEN_OK;
}

sheen_status sheen_mesh_build_finish(sheen_mesh_build *b, sheen_mesh *mesh, sheen_err *err)
{
    sheen_mesh *m = &b->mesh;
    size_t n_kept = 0;
    for (size_t i = 0; i < m->n_triangles; i++)
        if (has_area(m, m->triangles + 3 * i))
            memmove(m->triangles + 3 * n_kept++, m->triangles + 3 * i, 3 * sizeof(uint32_t));
    m->n_triangles = n_kept;
    if (!n_kept)
        return sheen_fail(err, SHEEN_EDATA, "it holds no triangle with an area");
    const sheen_status s = complete_normals(m, err);
    if (s)
        return s;
    *mesh = *m;
    *b = (sheen_mesh_build){0};
    return SHEEN_OK;
}

void sheen_mesh_build_release(sheen_mesh_build *b)
{
    sheen_mesh_release(&b->mesh);
    *b = (sheen_mesh_build){0};
}

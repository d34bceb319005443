// SPDX-License-Identifier: Apache-2.0
// mesh.c - triangle meshes: telling the formats apart, normals, bounds, and writing PLY.
#include "base/mesh.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/file.h"
#include "base/mesh_build.h"
#include "base/mesh_repair.h"
#include "base/vec.h"

enum { MAX_FILE_BYTES = 1 << 30 };

void sheen_mesh_release(sheen_mesh *mesh)
{
    free(mesh->p_obj);
    free(mesh->n_obj);
    free(mesh->triangles);
    *mesh = (sheen_mesh){0};
}

sheen_status sheen_mesh_parse(sheen_mesh *mesh, const void *data, size_t size_bytes, const char *name_hint,
                              sheen_err *err)
{
    *mesh = (sheen_mesh){0};
    const char *extension = name_hint ? sheen_path_extension(name_hint) : "";
    if (!size_bytes)
        return sheen_fail(err, SHEEN_EFORMAT, "the file is empty");
    if (size_bytes >= 4 && !memcmp(data, "ply", 3) && strchr("\r\n", ((const char *)data)[3]))
        return sheen_ply_parse(mesh, data, size_bytes, err);
    if (size_bytes >= 4 && !memcmp(data, "glTF", 4))
        return sheen_glb_parse(mesh, data, size_bytes, err);
    if (!strcasecmp(extension, "obj"))
        return sheen_obj_parse(mesh, data, size_bytes, err);
    if (!strcasecmp(extension, "gltf"))
        return sheen_fail(err, SHEEN_EUNSUP, "glTF as text is not supported: save it as .glb");
    return sheen_fail(err, SHEEN_EFORMAT,
                      "not a mesh that is read here: neither PLY, OBJ (*.obj) nor glTF binary");
}

sheen_status sheen_mesh_load(sheen_mesh *mesh, const char *path, sheen_err *err)
{
    *mesh = (sheen_mesh){0};
    uint8_t *data;
    size_t size_bytes;
    sheen_status s = sheen_file_read(&data, &size_bytes, path, MAX_FILE_BYTES, err);
    if (s)
        return s;
    s = sheen_mesh_parse(mesh, data, size_bytes, path, err);
    free(data);
    sheen_mesh_repairs repairs;
    if (!s && (s = sheen_mesh_repair(&repairs, mesh, err)))
        sheen_mesh_release(mesh);
    return s ? sheen_wrap(err, s, "cannot read '%s'", path) : SHEEN_OK;
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

// PLY's numbers are little-endian here whatever the machine.
static uint8_t *put_u32(uint8_t *out, uint32_t x)
{
    for (int i = 0; i < 4; i++)
        *out++ = (uint8_t)(x >> (8 * i));
    return out;
}

static uint8_t *put_vector(uint8_t *out, const float v[3])
{
    for (int c = 0; c < 3; c++) {
        uint32_t bits;
        memcpy(&bits, v + c, sizeof bits);
        out = put_u32(out, bits);
    }
    return out;
}

sheen_status sheen_mesh_save_ply(const sheen_mesh *mesh, const char *path, sheen_err *err)
{
    char header[400];
    const int n = snprintf(header, sizeof header,
                           "ply\nformat binary_little_endian 1.0\ncomment metres\nelement vertex %zu\n"
                           "property float x\nproperty float y\nproperty float z\n"
                           "property float nx\nproperty float ny\nproperty float nz\n"
                           "element face %zu\nproperty list uchar int vertex_indices\nend_header\n",
                           mesh->n_vertices, mesh->n_triangles);
    const size_t size_bytes = (size_t)n + 24 * mesh->n_vertices + 13 * mesh->n_triangles;
    uint8_t *file = malloc(size_bytes), *out = file;
    if (!file)
        return sheen_fail_memory(err, (double)size_bytes, path);
    memcpy(out, header, (size_t)n);
    out += n;
    for (size_t i = 0; i < mesh->n_vertices; i++) {
        out = put_vector(out, mesh->p_obj + 3 * i);
        out = put_vector(out, mesh->n_obj + 3 * i);
    }
    for (size_t i = 0; i < mesh->n_triangles; i++) {
        *out++ = 3;
        for (int k = 0; k < 3; k++)
            out = put_u32(out, mesh->triangles[3 * i + (size_t)k]);
    }
    const sheen_status s = sheen_file_write(path, file, size_bytes, err);
    free(file);
    return s;
}

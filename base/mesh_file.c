// SPDX-License-Identifier: Apache-2.0
// mesh_file.c - mesh files: telling the formats apart, and writing PLY.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/file.h"
#include "base/mesh_build.h"
#include "base/mesh_repair.h"

enum { MAX_FILE_BYTES = 1 << 30 };

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

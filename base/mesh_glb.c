// SPDX-License-Identifier: Apache-2.0
// mesh_glb.c - glTF 2.0 binary: the triangles of every primitive that the scene shows, in the scene's frame.
//
// Nodes are walked from the scene's roots; each mesh is placed by the product of its nodes' transforms, normals by
// the matrix of cofactors, and a mirroring transform turns triangles round (glTF 2.0, 3.7.4). Positions may be
// quantized. Sparse accessors, compressed geometry, skins and outside files are refused, not guessed at.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "base/mesh_build.h"
#include "base/vec.h"

enum { CHUNK_JSON = 0x4e4f534a, CHUNK_BIN = 0x004e4942 };
enum { COMPONENT_I8 = 5120, COMPONENT_U8, COMPONENT_I16, COMPONENT_U16, COMPONENT_U32 = 5125, COMPONENT_F32 };
enum { MODE_TRIANGLES = 4, MODE_STRIP, MODE_FAN };

typedef struct reader {
    const uint8_t *bin;
    size_t bin_bytes;
    sheen_json *root;
    const sheen_json *nodes;
    uint8_t *visited; // by node: reached before
    int *stack;       // nodes still to be entered, each at most once
    size_t n_stack;
    double (*stack_T)[12]; // transform of the parent of each
    sheen_mesh_build build;
    sheen_err *err;
} reader;

// count elements of n components each, stride_bytes apart.
typedef struct accessor {
    const uint8_t *data;
    size_t count, stride_bytes;
    int n_components, component;
    bool normalized;
} accessor;

static uint32_t u32_at(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static sheen_status read_chunks(reader *r, const uint8_t *data, size_t size_bytes)
{
    if (size_bytes < 20)
        return sheen_fail(r->err, SHEEN_EFORMAT, "glTF binary is cut short");
    if (u32_at(data + 4) != 2)
        return sheen_fail(r->err, SHEEN_EUNSUP, "glTF of version %lu is not supported: version 2 is",
                          (unsigned long)u32_at(data + 4));
    if (u32_at(data + 8) > size_bytes)
        return sheen_fail(r->err, SHEEN_EFORMAT, "glTF binary is cut short: %zu of %lu bytes", size_bytes,
                          (unsigned long)u32_at(data + 8));
    const size_t json_bytes = u32_at(data + 12);
    if (u32_at(data + 16) != CHUNK_JSON || json_bytes > size_bytes - 20)
        return sheen_fail(r->err, SHEEN_EFORMAT, "glTF binary does not begin with its JSON");
    const sheen_status s = sheen_json_parse(&r->root, data + 20, json_bytes, r->err);
    if (s)
        return s;
    const size_t at = 20 + json_bytes;
    if (size_bytes - at < 8 || u32_at(data + at + 4) != CHUNK_BIN)
        return SHEEN_OK; // no binary chunk: accessors will say so
    r->bin_bytes = u32_at(data + at);
    r->bin = data + at + 8;
    if (r->bin_bytes > size_bytes - at - 8)
        return sheen_fail(r->err, SHEEN_EFORMAT, "glTF binary is cut short within its data");
    return SHEEN_OK;
}

// A whole number that may be absent.
static sheen_status optional_int(const reader *r, const sheen_json *object, const char *key, int fallback,
                                 int *out)
{
    *out = fallback;
    return sheen_json_get(object, key) ? sheen_json_int(object, key, 0, INT32_MAX, out, r->err) : SHEEN_OK;
}

static const sheen_json *item(const reader *r, const char *list, int index)
{
    return index < 0 ? NULL : sheen_json_at(sheen_json_get(r->root, list), (size_t)index);
}

static int component_bytes(int component)
{
    switch (component) {
    case COMPONENT_I8:
    case COMPONENT_U8:
        return 1;
    case COMPONENT_I16:
    case COMPONENT_U16:
        return 2;
    case COMPONENT_U32:
    case COMPONENT_F32:
        return 4;
    default:
        return 0;
    }
}

// The bytes of a buffer view; only the file's own binary chunk has any.
static sheen_status read_view(const reader *r, int index, const uint8_t **data, size_t *size_bytes,
                              int *stride_bytes)
{
    const sheen_json *view = item(r, "bufferViews", index);
    if (!view)
        return sheen_fail(r->err, SHEEN_EFORMAT, "glTF has no buffer view %d", index);
    const sheen_json *extensions = sheen_json_get(view, "extensions");
    if (sheen_json_get(extensions, "EXT_meshopt_compression") ||
        sheen_json_get(extensions, "KHR_meshopt_compression"))
        return sheen_fail(r->err, SHEEN_EUNSUP,
                          "glTF with meshopt compression is not supported: save it without");
    int buffer = 0, offset = 0, length = 0;
    sheen_status s = sheen_json_int(view, "buffer", 0, INT32_MAX, &buffer, r->err);
    if (!s)
        s = optional_int(r, view, "byteOffset", 0, &offset);
    if (!s)
        s = sheen_json_int(view, "byteLength", 1, INT32_MAX, &length, r->err);
    if (!s)
        s = optional_int(r, view, "byteStride", 0, stride_bytes);
    if (s)
        return s;
    if (buffer != 0 || sheen_json_get(item(r, "buffers", 0), "uri"))
        return sheen_fail(r->err, SHEEN_EUNSUP,
                          "glTF with data outside the file is not supported: save one .glb");
    if ((size_t)offset > r->bin_bytes || (size_t)length > r->bin_bytes - (size_t)offset)
        return sheen_fail(r->err, SHEEN_EFORMAT, "glTF buffer view %d lies outside the file's data", index);
    *data = r->bin + offset;
    *size_bytes = (size_t)length;
    return SHEEN_OK;
}

static sheen_status read_accessor(const reader *r, int index, const char *type, int n_components,
                                  accessor *out)
{
    const sheen_json *a = item(r, "accessors", index);
    if (!a)
        return sheen_fail(r->err, SHEEN_EFORMAT, "glTF has no accessor %d", index);
    if (sheen_json_get(a, "sparse") || !sheen_json_get(a, "bufferView"))
        return sheen_fail(r->err, SHEEN_EUNSUP, "glTF with sparse or empty accessors is not supported");
    if (strcmp(sheen_json_value_string(sheen_json_get(a, "type"), ""), type) != 0)
        return sheen_fail(r->err, SHEEN_EFORMAT, "glTF accessor %d is not of type %s", index, type);
    int view = 0, offset = 0, component = 0, count = 0, stride_bytes = 0;
    sheen_status s = sheen_json_int(a, "bufferView", 0, INT32_MAX, &view, r->err);
    if (!s)
        s = optional_int(r, a, "byteOffset", 0, &offset);
    if (!s)
        s = sheen_json_int(a, "componentType", 0, INT32_MAX, &component, r->err);
    if (!s)
        s = sheen_json_int(a, "count", 1, INT32_MAX, &count, r->err);
    size_t view_bytes = 0;
    if (!s)
        s = read_view(r, view, &out->data, &view_bytes, &stride_bytes);
    if (s)
        return s;
    const size_t element_bytes = (size_t)n_components * (size_t)component_bytes(component);
    out->stride_bytes = stride_bytes ? (size_t)stride_bytes : element_bytes;
    if (!element_bytes || out->stride_bytes < element_bytes)
        return sheen_fail(r->err, SHEEN_EFORMAT,
                          "glTF accessor %d has a component type or stride that is none", index);
    const size_t needed = (size_t)offset + out->stride_bytes * ((size_t)count - 1) + element_bytes;
    if (needed > view_bytes) // no overflow: each factor is below 2^31
        return sheen_fail(r->err, SHEEN_EFORMAT, "glTF accessor %d lies outside its buffer view", index);
    out->data += offset;
    out->count = (size_t)count;
    out->n_components = n_components;
    out->component = component;
    if (sheen_json_get(a, "normalized"))
        return sheen_json_bool(a, "normalized", &out->normalized, r->err);
    out->normalized = false;
    return SHEEN_OK;
}

static double component_at(const accessor *a, size_t i, int c)
{
    const uint8_t *p = a->data + i * a->stride_bytes + (size_t)c * (size_t)component_bytes(a->component);
    uint32_t bits;
    float f;
    switch (a->component) {
    case COMPONENT_I8:
        return a->normalized ? fmax((int8_t)p[0] / 127.0, -1) : (int8_t)p[0];
    case COMPONENT_U8:
        return a->normalized ? p[0] / 255.0 : p[0];
    case COMPONENT_I16:
        bits = (uint32_t)(p[0] | p[1] << 8);
        return a->normalized ? fmax((int16_t)(uint16_t)bits / 32767.0, -1) : (int16_t)(uint16_t)bits;
    case COMPONENT_U16:
        bits = (uint32_t)(p[0] | p[1] << 8);
        return a->normalized ? bits / 65535.0 : bits;
    case COMPONENT_U32:
        return u32_at(p);
    default:
        bits = u32_at(p);
        memcpy(&f, &bits, sizeof f);
        return (double)f;
    }
}

// T is 3x4, row-major: R and t of x' = R x + t.
static void apply(double out[3], const double T[12], const double v[3], double w)
{
    for (size_t i = 0; i < 3; i++)
        out[i] = sheen_dot(T + 4 * i, v) + w * T[4 * i + 3];
}

static void multiply(double out[12], const double A[12], const double B[12])
{
    for (size_t j = 0; j < 4; j++) {
        const double column[3] = {B[j], B[4 + j], B[8 + j]};
        double product[3];
        apply(product, A, column, j == 3);
        for (size_t i = 0; i < 3; i++)
            out[4 * i + j] = product[i];
    }
}

// Rows are cofactors of T's 3x3: R^-T times its determinant, which is returned.
static double cofactors(double C[3][3], const double T[12])
{
    for (size_t i = 0; i < 3; i++)
        sheen_cross(C[i], T + 4 * ((i + 1) % 3), T + 4 * ((i + 2) % 3));
    return sheen_dot(T, C[0]);
}

static void trs_transform(double T[12], const double t[3], const double q[4], const double s[3])
{
    const double n = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    const double x = q[0] / n, y = q[1] / n, z = q[2] / n, w = q[3] / n;
    const double R[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                            {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                            {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            T[4 * i + j] = R[i][j] * s[j];
        T[4 * i + 3] = t[i];
    }
}

static sheen_status node_transform(const reader *r, const sheen_json *node, double T[12])
{
    double m[16] = {0}, t[3] = {0}, q[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1};
    sheen_status s = SHEEN_OK;
    if (sheen_json_get(node, "matrix")) {
        s = sheen_json_numbers(node, "matrix", m, 16, r->err);
        for (int i = 0; i < 12 && !s; i++)
            T[i] = m[4 * (i % 4) + i / 4]; // stored by columns
        return s;
    }
    if (sheen_json_get(node, "translation"))
        s = sheen_json_numbers(node, "translation", t, 3, r->err);
    if (!s && sheen_json_get(node, "rotation"))
        s = sheen_json_numbers(node, "rotation", q, 4, r->err);
    if (!s && sheen_json_get(node, "scale"))
        s = sheen_json_numbers(node, "scale", scale, 3, r->err);
    if (!s && !(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] > 1e-12))
        s = sheen_fail(r->err, SHEEN_EFORMAT, "a glTF node's rotation is zero");
    if (!s)
        trs_transform(T, t, q, scale);
    return s;
}

static sheen_status add_vertices(reader *r, const accessor *positions, const accessor *normals,
                                 const double T[12], const double C[3][3], double sign)
{
    sheen_status s = sheen_mesh_build_reserve(&r->build, positions->count, 0, r->err);
    for (size_t i = 0; i < positions->count && !s; i++) {
        double p[3], n[3], p_obj[3], n_obj[3];
        for (int c = 0; c < 3; c++) {
            p[c] = component_at(positions, i, c);
            n[c] = normals ? component_at(normals, i, c) : 0;
        }
        apply(p_obj, T, p, 1);
        for (int c = 0; c < 3; c++)
            n_obj[c] = sign * sheen_dot(C[c], n);
        sheen_normalize(n_obj);
        s = sheen_mesh_build_vertex(&r->build, p_obj, n_obj, r->err);
    }
    return s;
}

// Corner k of the primitive, as an index into the mesh.
static int64_t corner_at(const accessor *indices, size_t first_vertex, size_t k)
{
    return (int64_t)first_vertex + (indices ? (int64_t)component_at(indices, k, 0) : (int64_t)k);
}

static sheen_status add_triangles(reader *r, const accessor *indices, size_t n_corners, size_t first_vertex,
                                  int mode, bool mirrored)
{
    const size_t n = mode == MODE_TRIANGLES ? n_corners / 3 : n_corners < 3 ? 0 : n_corners - 2;
    sheen_status s = sheen_mesh_build_reserve(&r->build, 0, n, r->err);
    for (size_t i = 0; i < n && !s; i++) {
        size_t k[3] = {3 * i, 3 * i + 1, 3 * i + 2};
        if (mode == MODE_STRIP) {
            k[0] = i;
            k[1] = i + 1 + i % 2;
            k[2] = i + 2 - i % 2;
        } else if (mode == MODE_FAN) {
            k[0] = i + 1;
            k[1] = i + 2;
            k[2] = 0;
        }
        const int64_t a = corner_at(indices, first_vertex, k[0]), b = corner_at(indices, first_vertex, k[1]);
        const int64_t c = corner_at(indices, first_vertex, k[2]);
        s = sheen_mesh_build_triangle(&r->build, a, mirrored ? c : b, mirrored ? b : c,
                                      r->build.mesh.n_vertices, r->err);
    }
    return s;
}

static sheen_status add_primitive(reader *r, const sheen_json *primitive, const double T[12])
{
    int mode = 0, i_position = -1, i_normal = -1, i_indices = -1;
    sheen_status s = optional_int(r, primitive, "mode", MODE_TRIANGLES, &mode);
    if (s || mode < MODE_TRIANGLES || mode > MODE_FAN) // points and lines have no surface
        return s;
    if (sheen_json_get(sheen_json_get(primitive, "extensions"), "KHR_draco_mesh_compression"))
        return sheen_fail(r->err, SHEEN_EUNSUP,
                          "glTF with Draco compression is not supported: save it without");
    const sheen_json *attributes = sheen_json_get(primitive, "attributes");
    s = sheen_json_int(attributes, "POSITION", 0, INT32_MAX, &i_position, r->err);
    if (!s)
        s = optional_int(r, attributes, "NORMAL", -1, &i_normal);
    if (!s)
        s = optional_int(r, primitive, "indices", -1, &i_indices);
    accessor positions = {0}, normals = {0}, indices = {0};
    if (!s)
        s = read_accessor(r, i_position, "VEC3", 3, &positions);
    if (!s && i_normal >= 0)
        s = read_accessor(r, i_normal, "VEC3", 3, &normals);
    if (!s && i_indices >= 0)
        s = read_accessor(r, i_indices, "SCALAR", 1, &indices);
    if (s)
        return s;
    if (i_normal >= 0 && normals.count != positions.count)
        return sheen_fail(r->err, SHEEN_EFORMAT, "a glTF primitive has %zu normals for %zu positions",
                          normals.count, positions.count);
    if (i_indices >= 0 && indices.component != COMPONENT_U8 && indices.component != COMPONENT_U16 &&
        indices.component != COMPONENT_U32)
        return sheen_fail(r->err, SHEEN_EFORMAT, "glTF indices of component type %d", indices.component);
    double C[3][3];
    const double det = cofactors(C, T);
    const size_t first_vertex = r->build.mesh.n_vertices;
    s = add_vertices(r, &positions, i_normal < 0 ? NULL : &normals, T, (const double(*)[3])C,
                     det < 0 ? -1 : 1);
    if (s)
        return s;
    return add_triangles(r, i_indices < 0 ? NULL : &indices, i_indices < 0 ? positions.count : indices.count,
                         first_vertex, mode, det < 0);
}

static sheen_status add_mesh(reader *r, int index, const double T[12])
{
    const sheen_json *primitives, *mesh = item(r, "meshes", index);
    if (!mesh)
        return sheen_fail(r->err, SHEEN_EFORMAT, "glTF has no mesh %d", index);
    sheen_status s = sheen_json_array(mesh, "primitives", &primitives, r->err);
    for (size_t i = 0; i < sheen_json_count(primitives) && !s; i++)
        s = add_primitive(r, sheen_json_at(primitives, i), T);
    return s;
}

// glTF's nodes are trees: a second way to a node is an error, which also ends every cycle.
static sheen_status push_nodes(reader *r, const sheen_json *list, const double T[12])
{
    const size_t n_nodes = sheen_json_count(r->nodes);
    for (size_t i = 0; i < sheen_json_count(list); i++) {
        const double index = sheen_json_value_number(sheen_json_at(list, i), -1);
        if (!(index >= 0 && index < (double)n_nodes) || index != floor(index))
            return sheen_fail(r->err, SHEEN_EFORMAT, "glTF has no node %g", index);
        const size_t at = (size_t)index;
        if (r->visited[at])
            return sheen_fail(r->err, SHEEN_EFORMAT, "glTF node %zu is reached in two ways", at);
        r->visited[at] = 1;
        memcpy(r->stack_T[r->n_stack], T, 12 * sizeof *T);
        r->stack[r->n_stack++] = (int)at;
    }
    return SHEEN_OK;
}

static sheen_status enter_node(reader *r, int index, const double T_parent[12])
{
    const sheen_json *node = sheen_json_at(r->nodes, (size_t)index);
    double own[12] = {0}, T[12];
    int mesh = -1;
    sheen_status s = node_transform(r, node, own);
    if (s)
        return s;
    multiply(T, T_parent, own);
    s = optional_int(r, node, "mesh", -1, &mesh);
    if (!s && mesh >= 0 && sheen_json_get(node, "skin"))
        s = sheen_fail(r->err, SHEEN_EUNSUP, "glTF with a skeleton is not supported: apply its pose first");
    if (!s && mesh >= 0)
        s = add_mesh(r, mesh, T);
    return s ? s : push_nodes(r, sheen_json_get(node, "children"), T);
}

static sheen_status walk_scene(reader *r)
{
    static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    int index;
    sheen_status s = optional_int(r, r->root, "scene", 0, &index);
    if (s)
        return s;
    const sheen_json *scene = item(r, "scenes", index);
    const size_t n_nodes = sheen_json_count(r->nodes);
    if (!scene || !n_nodes) { // a file without scenes is a library of meshes
        for (size_t i = 0; i < sheen_json_count(sheen_json_get(r->root, "meshes")) && !s; i++)
            s = add_mesh(r, (int)i, identity);
        return s;
    }
    r->visited = calloc(n_nodes, 1);
    r->stack = calloc(n_nodes, sizeof *r->stack);
    r->stack_T = calloc(n_nodes, sizeof *r->stack_T);
    if (!r->visited || !r->stack || !r->stack_T)
        return sheen_fail_memory(r->err, (double)n_nodes * sizeof *r->stack_T, "glTF nodes");
    s = push_nodes(r, sheen_json_get(scene, "nodes"), identity);
    while (r->n_stack && !s) {
        double T_parent[12];
        memcpy(T_parent, r->stack_T[--r->n_stack], sizeof T_parent);
        s = enter_node(r, r->stack[r->n_stack], T_parent);
    }
    return s;
}

sheen_status sheen_glb_parse(sheen_mesh *mesh, const void *data, size_t size_bytes, sheen_err *err)
{
    *mesh = (sheen_mesh){0};
    reader r = {.err = err};
    sheen_status s = read_chunks(&r, data, size_bytes);
    if (!s) {
        r.nodes = sheen_json_get(r.root, "nodes");
        s = walk_scene(&r);
    }
    if (!s)
        s = sheen_mesh_build_finish(&r.build, mesh, err);
    sheen_mesh_build_release(&r.build);
    free(r.visited);
    free(r.stack);
    free(r.stack_T);
    sheen_json_free(&r.root);
    return s;
}

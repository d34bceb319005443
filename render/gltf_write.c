// SPDX-License-Identifier: Apache-2.0
// gltf_write.c - glTF 2.0 binary: a JSON chunk, then a chunk of positions, normals, texture coordinates, tangents, corners, pictures.
#include "render/gltf_write.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/json_write.h"
#include "base/vec.h"

enum {
    MAGIC = 0x46546c67,
    JSON_CHUNK = 0x4e4f534a,
    BIN_CHUNK = 0x004e4942,
    HEADER_BYTES = 12,
    CHUNK_BYTES = 8
};
enum { ARRAY_BUFFER = 34962, ELEMENT_BUFFER = 34963, FLOATS = 5126, WORDS = 5125, TRIANGLES = 4 };
enum { LINEAR = 9729, LINEAR_MIPMAPS = 9987, CLAMP = 33071 };
// What a file holds, in this order, as far as there is something.
enum { POSITION, NORMAL, PLACE, TANGENT, CORNERS, COLOURS, NORMALS, SPECULAR, N_VIEWS };

typedef struct writing {
    const sheen_gltf_parts *parts;
    size_t at[N_VIEWS + 1]; // where each buffer view begins; the last: the end
    int number
        [N_VIEWS]; // of the buffer view, among those that there are; of attributes and corners the accessor's, too
    float low[3], high[3];
} writing;

static void position_of(float p_gltf[3], const sheen_gltf_parts *g, size_t i)
{
    const float *p = g->mesh->p_obj + 3 * (size_t)g->charts->vertex[i];
    for (int k = 0; k < 3; k++)
        p_gltf[k] = (float)(g->R_gltf_obj[k][0] * (double)p[0] + g->R_gltf_obj[k][1] * (double)p[1] +
                            g->R_gltf_obj[k][2] * (double)p[2] + g->t_gltf_obj[k]);
}

static void turned(float v_gltf[3], const sheen_gltf_parts *g, const float v_obj[3])
{
    for (int k = 0; k < 3; k++)
        v_gltf[k] = (float)(g->R_gltf_obj[k][0] * (double)v_obj[0] + g->R_gltf_obj[k][1] * (double)v_obj[1] +
                            g->R_gltf_obj[k][2] * (double)v_obj[2]);
    if (!(sheen_normalizef(v_gltf) > 0))
        v_gltf[1] = 1;
}

static void lay_out(writing *w)
{
    const sheen_gltf_parts *g = w->parts;
    const size_t n = g->charts->n_vertices;
    const size_t sizes[N_VIEWS] = {12 * n,
                                   12 * n,
                                   8 * n,
                                   g->tangent ? 16 * n : 0,
                                   12 * g->charts->n_triangles,
                                   g->jpeg_bytes,
                                   g->normals ? g->normals_bytes : 0,
                                   g->specular ? g->specular_bytes : 0};
    int number = 0;
    for (int i = 0; i < N_VIEWS; i++) {
        w->number[i] = number;
        number += sizes[i] > 0;
        w->at[i + 1] = w->at[i] + sizes[i];
    }
    for (int k = 0; k < 3; k++) {
        w->low[k] = INFINITY;
        w->high[k] = -INFINITY;
    }
    for (size_t i = 0; i < n; i++) {
        float p[3];
        position_of(p, g, i);
        for (int k = 0; k < 3; k++) {
            w->low[k] = fminf(w->low[k], p[k]);
            w->high[k] = fmaxf(w->high[k], p[k]);
        }
    }
}

// ---- JSON

static void put_accessor(sheen_json_writer *j, int view, int component, size_t count, const char *type,
                         const writing *bounds)
{
    sheen_json_open(j, NULL, '{');
    sheen_json_put_int(j, "bufferView", view);
    sheen_json_put_int(j, "componentType", component);
    sheen_json_put_int(j, "count", (long long)count);
    sheen_json_put_string(j, "type", type);
    for (int side = 0; bounds && side < 2; side++) {
        const float *x = side ? bounds->high : bounds->low;
        const double corner[3] = {(double)x[0], (double)x[1], (double)x[2]};
        sheen_json_put_numbers(j, side ? "max" : "min", corner, 3);
    }
    sheen_json_close(j);
}

static void put_buffers(sheen_json_writer *j, const writing *w)
{
    const size_t n = w->parts->charts->n_vertices;
    sheen_json_open(j, "accessors", '[');
    put_accessor(j, w->number[POSITION], FLOATS, n, "VEC3", w);
    put_accessor(j, w->number[NORMAL], FLOATS, n, "VEC3", NULL);
    put_accessor(j, w->number[PLACE], FLOATS, n, "VEC2", NULL);
    if (w->parts->tangent)
        put_accessor(j, w->number[TANGENT], FLOATS, n, "VEC4", NULL);
    put_accessor(j, w->number[CORNERS], WORDS, 3 * w->parts->charts->n_triangles, "SCALAR", NULL);
    sheen_json_close(j);
    sheen_json_open(j, "bufferViews", '[');
    for (int i = 0; i < N_VIEWS; i++) {
        if (w->at[i + 1] == w->at[i])
            continue;
        sheen_json_open(j, NULL, '{');
        sheen_json_put_int(j, "buffer", 0);
        sheen_json_put_int(j, "byteOffset", (long long)w->at[i]);
        sheen_json_put_int(j, "byteLength", (long long)(w->at[i + 1] - w->at[i]));
        if (i <= CORNERS)
            sheen_json_put_int(j, "target", i == CORNERS ? ELEMENT_BUFFER : ARRAY_BUFFER);
        sheen_json_close(j);
    }
    sheen_json_close(j);
    sheen_json_open(j, "buffers", '[');
    sheen_json_open(j, NULL, '{');
    const size_t bin_bytes = (w->at[N_VIEWS] + 3) / 4 * 4;
    sheen_json_put_int(j, "byteLength", (long long)bin_bytes);
    sheen_json_close(j);
    sheen_json_close(j);
}

static void put_texture(sheen_json_writer *j, const char *name, int index)
{
    sheen_json_open(j, name, '{');
    sheen_json_put_int(j, "index", index);
    sheen_json_close(j);
}

static void put_images(sheen_json_writer *j, const writing *w)
{
    sheen_json_open(j, "textures", '[');
    for (int i = COLOURS; i < N_VIEWS; i++) {
        if (w->at[i + 1] == w->at[i])
            continue;
        sheen_json_open(j, NULL, '{');
        sheen_json_put_int(j, "sampler", 0);
        sheen_json_put_int(j, "source", w->number[i] - w->number[COLOURS]);
        sheen_json_close(j);
    }
    sheen_json_close(j);
    sheen_json_open(j, "images", '[');
    for (int i = COLOURS; i < N_VIEWS; i++) {
        if (w->at[i + 1] == w->at[i])
            continue;
        sheen_json_open(j, NULL, '{');
        sheen_json_put_int(j, "bufferView", w->number[i]);
        sheen_json_put_string(j, "mimeType", i == COLOURS ? "image/jpeg" : "image/png");
        sheen_json_close(j);
    }
    sheen_json_close(j);
}

static void put_material(sheen_json_writer *j, const writing *w)
{
    const sheen_gltf_parts *g = w->parts;
    const double colour[3] = {g->specular_colour, g->specular_colour, g->specular_colour};
    sheen_json_open(j, "materials", '[');
    sheen_json_open(j, NULL, '{');
    sheen_json_put_string(j, "name", g->title);
    sheen_json_open(j, "pbrMetallicRoughness", '{');
    put_texture(j, "baseColorTexture", 0);
    sheen_json_put_number(j, "metallicFactor", 0);
    sheen_json_put_number(j, "roughnessFactor", g->roughness);
    sheen_json_close(j);
    if (g->normals)
        put_texture(j, "normalTexture", w->number[NORMALS] - w->number[COLOURS]);
    sheen_json_open(j, "extensions", '{');
    sheen_json_open(j, "KHR_materials_specular", '{');
    sheen_json_put_number(j, "specularFactor", g->specular_factor);
    if (g->specular)
        put_texture(j, "specularTexture", w->number[SPECULAR] - w->number[COLOURS]);
    sheen_json_put_numbers(j, "specularColorFactor", colour, 3);
    if (g->specular)
        put_texture(j, "specularColorTexture", w->number[SPECULAR] - w->number[COLOURS]);
    sheen_json_close(j);
    sheen_json_close(j);
    sheen_json_close(j);
    sheen_json_close(j);
    sheen_json_open(j, "samplers", '[');
    sheen_json_open(j, NULL, '{');
    sheen_json_put_int(j, "magFilter", LINEAR);
    sheen_json_put_int(j, "minFilter", LINEAR_MIPMAPS);
    sheen_json_put_int(j, "wrapS", CLAMP);
    sheen_json_put_int(j, "wrapT", CLAMP);
    sheen_json_close(j);
    sheen_json_close(j);
    put_images(j, w);
}

static void put_mesh(sheen_json_writer *j, const writing *w)
{
    const sheen_gltf_parts *g = w->parts;
    sheen_json_open(j, "meshes", '[');
    sheen_json_open(j, NULL, '{');
    sheen_json_put_string(j, "name", g->title);
    sheen_json_open(j, "primitives", '[');
    sheen_json_open(j, NULL, '{');
    sheen_json_open(j, "attributes", '{');
    sheen_json_put_int(j, "POSITION", w->number[POSITION]);
    sheen_json_put_int(j, "NORMAL", w->number[NORMAL]);
    sheen_json_put_int(j, "TEXCOORD_0", w->number[PLACE]);
    if (g->tangent)
        sheen_json_put_int(j, "TANGENT", w->number[TANGENT]);
    sheen_json_close(j);
    sheen_json_put_int(j, "indices", w->number[CORNERS]);
    sheen_json_put_int(j, "material", 0);
    sheen_json_put_int(j, "mode", TRIANGLES);
    sheen_json_close(j);
    sheen_json_close(j);
    sheen_json_close(j);
    sheen_json_close(j);
}

// A directional light shines along its node's -z: the rotation that takes -z to where the light goes.
static void put_light_node(sheen_json_writer *j, const sheen_gltf_light *l, int i)
{
    const double to[3] = {-l->direction[0], -l->direction[1],
                          -l->direction[2]}; // cross(-z, to) = (to_y, -to_x, 0)
    double q[4] = {to[1], -to[0], 0, 1 - to[2]};
    const double norm = sqrt(q[0] * q[0] + q[1] * q[1] + q[3] * q[3]);
    if (norm > 1e-6)
        for (int k = 0; k < 4; k++)
            q[k] /= norm;
    else
        memcpy(q, (const double[4]){1, 0, 0, 0}, sizeof q); // straight back
    sheen_json_open(j, NULL, '{');
    if (l->near)
        sheen_json_put_numbers(j, "translation", l->position, 3);
    else
        sheen_json_put_numbers(j, "rotation", q, 4);
    sheen_json_open(j, "extensions", '{');
    sheen_json_open(j, "KHR_lights_punctual", '{');
    sheen_json_put_int(j, "light", i);
    sheen_json_close(j);
    sheen_json_close(j);
    sheen_json_close(j);
}

static void put_scene(sheen_json_writer *j, const sheen_gltf_parts *g)
{
    sheen_json_put_int(j, "scene", 0);
    sheen_json_open(j, "scenes", '[');
    sheen_json_open(j, NULL, '{');
    sheen_json_open(j, "nodes", '[');
    for (size_t i = 0; i <= g->n_lights; i++)
        sheen_json_put_int(j, NULL, (long long)i);
    sheen_json_close(j);
    sheen_json_close(j);
    sheen_json_close(j);
    sheen_json_open(j, "nodes", '[');
    sheen_json_open(j, NULL, '{');
    sheen_json_put_string(j, "name", g->title);
    sheen_json_put_int(j, "mesh", 0);
    sheen_json_close(j);
    for (size_t i = 0; i < g->n_lights; i++)
        put_light_node(j, &g->lights[i], (int)i);
    sheen_json_close(j);
}

static void put_lights(sheen_json_writer *j, const sheen_gltf_parts *g)
{
    if (!g->n_lights)
        return;
    sheen_json_open(j, "extensions", '{');
    sheen_json_open(j, "KHR_lights_punctual", '{');
    sheen_json_open(j, "lights", '[');
    for (size_t i = 0; i < g->n_lights; i++) {
        sheen_json_open(j, NULL, '{');
        sheen_json_put_string(j, "type", g->lights[i].near ? "point" : "directional");
        sheen_json_put_numbers(j, "color", g->lights[i].rgb, 3);
        sheen_json_put_number(j, "intensity", g->lights[i].intensity);
        sheen_json_close(j);
    }
    sheen_json_close(j);
    sheen_json_close(j);
    sheen_json_close(j);
}

static void put_json(sheen_json_writer *j, const writing *w)
{
    const sheen_gltf_parts *g = w->parts;
    sheen_json_open(j, NULL, '{');
    sheen_json_open(j, "asset", '{');
    sheen_json_put_string(j, "version", "2.0");
    sheen_json_put_string(j, "generator", "sheen");
    sheen_json_close(j);
    sheen_json_open(j, "extensionsUsed", '[');
    sheen_json_put_string(j, NULL, "KHR_materials_specular");
    if (g->n_lights)
        sheen_json_put_string(j, NULL, "KHR_lights_punctual");
    sheen_json_close(j);
    put_scene(j, g);
    put_mesh(j, w);
    put_material(j, w);
    put_buffers(j, w);
    put_lights(j, g);
    sheen_json_close(j);
}

// ---- bytes

static void put_u32(uint8_t *to, size_t x)
{
    for (int k = 0; k < 4; k++)
        to[k] = (uint8_t)(x >> (8 * k));
}

static void put_floats(uint8_t *to, const float *x, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        uint32_t bits;
        memcpy(&bits, &x[i], sizeof bits);
        put_u32(to + 4 * i, bits);
    }
}

static void put_bin(uint8_t *to, const writing *w)
{
    const sheen_gltf_parts *g = w->parts;
    const float side_px = (float)g->charts->side_px;
    for (size_t i = 0; i < g->charts->n_vertices; i++) {
        float p[3], n[3];
        const float uv[2] = {g->charts->q_px[2 * i] / side_px, g->charts->q_px[2 * i + 1] / side_px};
        position_of(p, g, i);
        turned(n, g, g->mesh->n_obj + 3 * (size_t)g->charts->vertex[i]);
        put_floats(to + w->at[POSITION] + 12 * i, p, 3);
        put_floats(to + w->at[NORMAL] + 12 * i, n, 3);
        put_floats(to + w->at[PLACE] + 8 * i, uv, 2);
        if (g->tangent) {
            float tangent[4];
            turned(tangent, g, g->tangent + 4 * i);
            tangent[3] = g->tangent[4 * i + 3];
            put_floats(to + w->at[TANGENT] + 16 * i, tangent, 4);
        }
    }
    for (size_t i = 0; i < 3 * g->charts->n_triangles; i++)
        put_u32(to + w->at[CORNERS] + 4 * i, g->charts->triangles[i]);
    memcpy(to + w->at[COLOURS], g->jpeg, g->jpeg_bytes);
    if (g->normals)
        memcpy(to + w->at[NORMALS], g->normals, g->normals_bytes);
    if (g->specular)
        memcpy(to + w->at[SPECULAR], g->specular, g->specular_bytes);
}

sheen_status sheen_gltf_write(uint8_t **glb, size_t *glb_bytes, const sheen_gltf_parts *parts, sheen_err *err)
{
    writing w = {.parts = parts};
    sheen_json_writer j = {0};
    *glb = NULL;
    lay_out(&w);
    put_json(&j, &w);
    const char *json = sheen_json_text(&j);
    const size_t json_bytes = json ? strlen(json) : 0, json_room = (json_bytes + 3) / 4 * 4,
                 bin_room = (w.at[N_VIEWS] + 3) / 4 * 4,
                 size_bytes = HEADER_BYTES + 2 * CHUNK_BYTES + json_room + bin_room;
    sheen_status s = SHEEN_OK;
    if (size_bytes > UINT32_MAX)
        s = sheen_fail(err, SHEEN_EARG, "%zu triangles are too many for one glTF file",
                       parts->charts->n_triangles);
    else if (!json || !(*glb = malloc(size_bytes)))
        s = sheen_fail_memory(err, (double)size_bytes, "a glTF file");
    if (!s && json) {
        uint8_t *to = *glb, *bin = to + HEADER_BYTES + CHUNK_BYTES + json_room;
        *glb_bytes = size_bytes;
        put_u32(to, MAGIC);
        put_u32(to + 4, 2);
        put_u32(to + 8, size_bytes);
        put_u32(to + 12, json_room);
        put_u32(to + 16, JSON_CHUNK);
        memset(to + HEADER_BYTES + CHUNK_BYTES, ' ', json_room);
        for (size_t i = 0; i < json_bytes; i++)
            to[HEADER_BYTES + CHUNK_BYTES + i] = (uint8_t)json[i];
        put_u32(bin, bin_room);
        put_u32(bin + 4, BIN_CHUNK);
        memset(bin + CHUNK_BYTES, 0, bin_room);
        put_bin(bin + CHUNK_BYTES, &w);
    }
    sheen_json_writer_release(&j);
    return s;
}

// SPDX-License-Identifier: Apache-2.0
// mesh_obj.c - Wavefront OBJ: v, vn, f (polygons, negative indices); all else is stepped over.
//
// OBJ gives each corner its own normal. A vertex whose corners have different ones (a hard edge) is repeated,
// once for each; texture coordinates are not read and split nothing.
#include <stdlib.h>
#include <string.h>

#include "base/mesh_build.h"
#include "base/scan.h"

// A vertex and the normal (-1: none) with which it has been used, and where it is in the mesh.
typedef struct use {
    bool taken;
    int64_t i_vertex, i_normal;
    uint32_t i_mesh;
} use;

typedef struct reader {
    sheen_mesh_build build; // the v lines' vertices in their order, then the repeated ones
    double *normals;        // [n_vn][3]
    size_t n_v, n_vn, vn_capacity;
    size_t v_seen, vn_seen; // lines so far on the second pass: negative indices count back from there
    use *uses;              // hash table, open addresses
    size_t n_uses, use_capacity;
    sheen_err *err;
} reader;

static sheen_status fail_line(const reader *r, const sheen_scan *line, const char *what)
{
    return sheen_fail(r->err, SHEEN_EFORMAT, "OBJ, line %zu: %s", line->line, what);
}

static bool read_vector(sheen_scan *line, double out[3])
{
    return sheen_scan_number(line, out) && sheen_scan_number(line, out + 1) &&
           sheen_scan_number(line, out + 2);
}

static sheen_status read_vertex(reader *r, sheen_scan *line)
{
    double p_obj[3];
    if (!read_vector(line, p_obj))
        return fail_line(r, line, "a vertex wants three finite numbers");
    const sheen_status s = sheen_mesh_build_vertex(&r->build, p_obj, NULL, r->err);
    r->n_v = r->build.mesh.n_vertices;
    return s;
}

static sheen_status read_normal(reader *r, sheen_scan *line)
{
    double n[3] = {0};
    if (!read_vector(line, n))
        memset(n, 0, sizeof n); // exporters write nan for degenerate ones: found anew from the triangles
    if (r->n_vn == r->vn_capacity) {
        const size_t grown = 2 * r->vn_capacity + 64;
        double *normals = realloc(r->normals, grown * 3 * sizeof *normals);
        if (!normals)
            return sheen_fail_memory(r->err, (double)(grown * 3 * sizeof *normals), "normals");
        r->normals = normals;
        r->vn_capacity = grown;
    }
    memcpy(r->normals + 3 * r->n_vn++, n, sizeof n);
    return SHEEN_OK;
}

static size_t hash(int64_t i_vertex, int64_t i_normal)
{
    uint64_t x = (uint64_t)i_vertex * UINT64_C(0x9e3779b97f4a7c15) ^
                 (uint64_t)i_normal * UINT64_C(0xc2b2ae3d27d4eb4f);
    x ^= x >> 29;
    return (size_t)(x * UINT64_C(0xbf58476d1ce4e5b9) >> 20);
}

// The slot of a (vertex, normal), free or in use. The table is never full.
static use *find_use(use *uses, size_t capacity, int64_t i_vertex, int64_t i_normal)
{
    size_t at = hash(i_vertex, i_normal) & (capacity - 1);
    while (uses[at].taken && (uses[at].i_vertex != i_vertex || uses[at].i_normal != i_normal))
        at = (at + 1) & (capacity - 1);
    return &uses[at];
}

static sheen_status grow_uses(reader *r)
{
    if (2 * r->n_uses < r->use_capacity)
        return SHEEN_OK;
    const size_t capacity = r->use_capacity ? 2 * r->use_capacity : 1024;
    use *uses = calloc(capacity, sizeof *uses);
    if (!uses)
        return sheen_fail_memory(r->err, (double)(capacity * sizeof *uses), "a table of vertices");
    for (size_t i = 0; i < r->use_capacity; i++)
        if (r->uses[i].taken)
            *find_use(uses, capacity, r->uses[i].i_vertex, r->uses[i].i_normal) = r->uses[i];
    free(r->uses);
    r->uses = uses;
    r->use_capacity = capacity;
    return SHEEN_OK;
}

// One corner "v", "v/vt", "v//vn" or "v/vt/vn" as zero-based indices; -1 for no normal.
static bool read_corner(const reader *r, const sheen_word *word, int64_t *i_vertex, int64_t *i_normal)
{
    long long i[3] = {0};
    const char *at = word->text, *end = at + word->length;
    for (int part = 0; part < 3; part++) {
        const char *slash = at < end ? memchr(at, '/', (size_t)(end - at)) : NULL;
        const sheen_word number = {at, (size_t)((slash ? slash : end) - at)};
        if ((number.length || part == 0) && !sheen_word_integer(&number, -INT32_MAX, INT32_MAX, &i[part]))
            return false;
        if (!slash)
            break;
        if (part == 2)
            return false;
        at = slash + 1;
    }
    *i_vertex = i[0] < 0 ? (int64_t)r->v_seen + i[0] : i[0] - 1;
    *i_normal = i[2] < 0 ? (int64_t)r->vn_seen + i[2] : i[2] - 1;
    return i[0] != 0 && *i_vertex >= 0 && (i[2] == 0 || *i_normal >= 0);
}

// A vertex that already has a normal is repeated with the new one.
static sheen_status add_use(reader *r, int64_t i_vertex, int64_t i_normal, int64_t *out)
{
    const double *n = r->normals + 3 * i_normal;
    use *plain = find_use(r->uses, r->use_capacity, i_vertex, -1); // in use: the vertex has its normal
    *out = i_vertex;
    if (!plain->taken) {
        sheen_mesh_build_normal(&r->build, (size_t)i_vertex, n);
        *plain = (use){true, i_vertex, -1, (uint32_t)i_vertex};
        r->n_uses++;
    } else {
        double p_obj[3];
        for (int k = 0; k < 3; k++)
            p_obj[k] = (double)r->build.mesh.p_obj[3 * i_vertex + k];
        *out = (int64_t)r->build.mesh.n_vertices;
        const sheen_status s = sheen_mesh_build_vertex(&r->build, p_obj, n, r->err);
        if (s)
            return s;
    }
    *find_use(r->uses, r->use_capacity, i_vertex, i_normal) = (use){true, i_vertex, i_normal, (uint32_t)*out};
    r->n_uses++;
    return SHEEN_OK;
}

// Where the corner's vertex with the corner's normal is in the mesh.
static sheen_status mesh_index(reader *r, int64_t i_vertex, int64_t i_normal, int64_t *out)
{
    if (i_vertex >= (int64_t)r->n_v)
        return sheen_fail(r->err, SHEEN_EFORMAT, "a polygon names vertex %lld of %zu",
                          (long long)i_vertex + 1, r->n_v);
    if (i_normal >= (int64_t)r->n_vn)
        return sheen_fail(r->err, SHEEN_EFORMAT, "a polygon names normal %lld of %zu",
                          (long long)i_normal + 1, r->n_vn);
    *out = i_vertex;
    if (i_normal < 0)
        return SHEEN_OK;
    const sheen_status s = grow_uses(r);
    if (s)
        return s;
    const use *u = find_use(r->uses, r->use_capacity, i_vertex, i_normal);
    if (!u->taken)
        return add_use(r, i_vertex, i_normal, out);
    *out = u->i_mesh;
    return SHEEN_OK;
}

static sheen_status read_polygon(reader *r, sheen_scan *line)
{
    sheen_word word;
    int64_t first = 0, last = 0;
    for (size_t k = 0; sheen_scan_word(line, &word) && word.text[0] != '#'; k++) {
        int64_t i_vertex = -1, i_normal = -1, at = 0;
        if (!read_corner(r, &word, &i_vertex, &i_normal))
            return fail_line(r, line, "a polygon's corner is not an index that counts from 1");
        sheen_status s = mesh_index(r, i_vertex, i_normal, &at);
        if (!s && k >= 2)
            s = sheen_mesh_build_triangle(&r->build, first, last, at, r->build.mesh.n_vertices, r->err);
        if (s)
            return s;
        first = k ? first : at;
        last = at;
    }
    return SHEEN_OK;
}

// The first pass gathers vertices and normals, the second polygons, which may name those of later lines.
static sheen_status read_line(reader *r, sheen_scan *line, bool second_pass)
{
    sheen_word word;
    if (!sheen_scan_word(line, &word))
        return SHEEN_OK;
    if (sheen_word_is(&word, "f"))
        return second_pass ? read_polygon(r, line) : SHEEN_OK;
    const bool is_v = sheen_word_is(&word, "v"), is_vn = sheen_word_is(&word, "vn");
    r->v_seen += is_v;
    r->vn_seen += is_vn;
    if (second_pass)
        return SHEEN_OK;
    return is_v ? read_vertex(r, line) : is_vn ? read_normal(r, line) : SHEEN_OK;
}

sheen_status sheen_obj_parse(sheen_mesh *mesh, const void *data, size_t size_bytes, sheen_err *err)
{
    *mesh = (sheen_mesh){0};
    reader r = {.err = err};
    sheen_status s = SHEEN_OK;
    for (int pass = 0; pass < 2 && !s; pass++) {
        sheen_scan text = {data, (const char *)data + size_bytes, 0}, line;
        r.v_seen = r.vn_seen = 0;
        while (!s && sheen_scan_line(&text, &line))
            s = read_line(&r, &line, pass == 1);
        if (!s && !r.n_v)
            s = sheen_fail(err, SHEEN_EFORMAT, "OBJ has no vertices");
    }
    if (!s)
        s = sheen_mesh_build_finish(&r.build, mesh, err);
    sheen_mesh_build_release(&r.build);
    free(r.normals);
    free(r.uses);
    return s;
}

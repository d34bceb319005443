// SPDX-License-Identifier: Apache-2.0
// mesh_ply.c - Stanford PLY: ASCII and binary of either byte order, any number types, polygons; elements and
// properties that are not needed are stepped over.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/mesh_build.h"
#include "base/scan.h"

enum { MAX_ELEMENTS = 16, MAX_PROPERTIES = 64, MAX_CORNERS = 65536 };

typedef enum type { I8, U8, I16, U16, I32, U32, F32, F64, N_TYPES } type;

static const size_t type_bytes[N_TYPES] = {1, 1, 2, 2, 4, 4, 4, 8};

typedef enum role { ROLE_NONE, ROLE_X, ROLE_Y, ROLE_Z, ROLE_NX, ROLE_NY, ROLE_NZ, ROLE_CORNERS } role;

typedef struct property {
    bool is_list;
    type count_type, value_type;
    role role;
} property;

typedef struct element {
    bool is_vertex, is_face;
    size_t count;
    int n_properties;
    property properties[MAX_PROPERTIES];
} element;

typedef struct reader {
    sheen_scan text; // what follows the header: words, or the numbers' bytes
    bool is_ascii, is_big_endian;
    int n_elements;
    element elements[MAX_ELEMENTS];
    sheen_mesh_build build;
    size_t n_vertices; // as the header says
    sheen_err *err;
} reader;

static bool type_from_word(const sheen_word *word, type *out)
{
    static const char *const names[][2] = {{"char", "int8"},     {"uchar", "uint8"},   {"short", "int16"},
                                           {"ushort", "uint16"}, {"int", "int32"},     {"uint", "uint32"},
                                           {"float", "float32"}, {"double", "float64"}};
    for (int i = 0; i < N_TYPES; i++)
        if (sheen_word_is(word, names[i][0]) || sheen_word_is(word, names[i][1])) {
            *out = (type)i;
            return true;
        }
    return false;
}

static role role_from_word(const sheen_word *word, const element *e, bool is_list)
{
    static const char *const names[] = {"x", "y", "z", "nx", "ny", "nz"};
    if (e->is_face && is_list &&
        (sheen_word_is(word, "vertex_indices") || sheen_word_is(word, "vertex_index")))
        return ROLE_CORNERS;
    for (int i = 0; i < 6 && e->is_vertex && !is_list; i++)
        if (sheen_word_is(word, names[i]))
            return (role)(ROLE_X + i);
    return ROLE_NONE;
}

static sheen_status read_element(reader *r, sheen_scan *line)
{
    sheen_word name, count;
    long long n = 0;
    if (!sheen_scan_word(line, &name) || !sheen_scan_word(line, &count) ||
        !sheen_word_integer(&count, 0, UINT32_MAX, &n))
        return sheen_fail(r->err, SHEEN_EFORMAT, "PLY header, line %zu: an element wants a name and a count",
                          line->line);
    if (r->n_elements == MAX_ELEMENTS)
        return sheen_fail(r->err, SHEEN_EFORMAT, "PLY header has more than %d elements", MAX_ELEMENTS);
    element *e = &r->elements[r->n_elements++];
    *e = (element){.count = (size_t)n};
    e->is_vertex = sheen_word_is(&name, "vertex");
    e->is_face = sheen_word_is(&name, "face");
    for (int i = 0; i < r->n_elements - 1; i++)
        if ((e->is_vertex && r->elements[i].is_vertex) || (e->is_face && r->elements[i].is_face))
            return sheen_fail(r->err, SHEEN_EFORMAT, "PLY header names '%s' twice",
                              e->is_vertex ? "vertex" : "face");
    if (e->is_vertex)
        r->n_vertices = e->count;
    return SHEEN_OK;
}

static sheen_status read_property(reader *r, sheen_scan *line)
{
    sheen_word word;
    property p = {0};
    element *e = r->n_elements ? &r->elements[r->n_elements - 1] : NULL;
    bool ok = e && sheen_scan_word(line, &word);
    p.is_list = ok && sheen_word_is(&word, "list");
    if (p.is_list)
        ok = sheen_scan_word(line, &word) && type_from_word(&word, &p.count_type) && p.count_type < F32 &&
             sheen_scan_word(line, &word);
    ok = ok && type_from_word(&word, &p.value_type) && sheen_scan_word(line, &word);
    if (!ok)
        return sheen_fail(r->err, SHEEN_EFORMAT, "PLY header, line %zu: not a property", line->line);
    if (e->n_properties == MAX_PROPERTIES)
        return sheen_fail(r->err, SHEEN_EFORMAT, "PLY header has more than %d properties in an element",
                          MAX_PROPERTIES);
    p.role = role_from_word(&word, e, p.is_list);
    e->properties[e->n_properties++] = p;
    return SHEEN_OK;
}

static sheen_status read_format(reader *r, sheen_scan *line)
{
    sheen_word word;
    const bool some = sheen_scan_word(line, &word);
    r->is_ascii = some && sheen_word_is(&word, "ascii");
    r->is_big_endian = some && sheen_word_is(&word, "binary_big_endian");
    if (r->is_ascii || r->is_big_endian || (some && sheen_word_is(&word, "binary_little_endian")))
        return SHEEN_OK;
    return sheen_fail(r->err, SHEEN_EFORMAT, "PLY of unknown format: it should be ascii or binary");
}

static sheen_status read_header(reader *r)
{
    sheen_scan line;
    bool has_format = false;
    sheen_scan_line(&r->text, &line); // "ply"
    while (sheen_scan_line(&r->text, &line)) {
        sheen_word word;
        sheen_status s = SHEEN_OK;
        if (!sheen_scan_word(&line, &word) || sheen_word_is(&word, "comment") ||
            sheen_word_is(&word, "obj_info"))
            continue;
        if (sheen_word_is(&word, "end_header"))
            return has_format ? SHEEN_OK : sheen_fail(r->err, SHEEN_EFORMAT, "PLY header has no format");
        if (sheen_word_is(&word, "format")) {
            s = read_format(r, &line);
            has_format = true;
        } else if (sheen_word_is(&word, "element")) {
            s = read_element(r, &line);
        } else if (sheen_word_is(&word, "property")) {
            s = read_property(r, &line);
        } else {
            s = sheen_fail(r->err, SHEEN_EFORMAT, "PLY header, line %zu: unknown word '%.*s'", line.line,
                           word.length < 40 ? (int)word.length : 40, word.text);
        }
        if (s)
            return s;
    }
    return sheen_fail(r->err, SHEEN_EFORMAT, "PLY header has no end: the file is cut short");
}

// The fewest bytes that one record can take: lists may be empty, numbers in ASCII are a digit and a blank.
static size_t least_record_bytes(const reader *r, const element *e)
{
    size_t n = 0;
    for (int i = 0; i < e->n_properties; i++) {
        const property *p = &e->properties[i];
        n += r->is_ascii ? 2 : type_bytes[p->is_list ? p->count_type : p->value_type];
    }
    return n;
}

static bool read_binary(reader *r, type t, double *out)
{
    const size_t n = type_bytes[t];
    if ((size_t)(r->text.end - r->text.at) < n)
        return false;
    uint64_t bits = 0;
    for (size_t i = 0; i < n; i++)
        bits |= (uint64_t)(uint8_t)r->text.at[r->is_big_endian ? n - 1 - i : i] << (8 * i);
    r->text.at += n;
    const uint32_t low = (uint32_t)bits;
    float f;
    switch (t) {
    case I8:
        *out = (int8_t)(uint8_t)low;
        return true;
    case I16:
        *out = (int16_t)(uint16_t)low;
        return true;
    case I32:
        *out = (int32_t)low;
        return true;
    case F32:
        memcpy(&f, &low, sizeof f);
        *out = (double)f;
        return true;
    case F64:
        memcpy(out, &bits, sizeof *out);
        return true;
    default:
        *out = low;
        return true;
    }
}

// ASCII: a word that is no finite number ("nan") reads as NaN, which the checks refuse where it matters.
static bool read_value(reader *r, type t, double *out)
{
    if (!r->is_ascii)
        return read_binary(r, t, out);
    sheen_word word;
    if (!sheen_scan_word(&r->text, &word))
        return false;
    if (!sheen_word_number(&word, out))
        *out = (double)NAN;
    return true;
}

static sheen_status fail_cut(const reader *r, const element *e, size_t i)
{
    return sheen_fail(r->err, SHEEN_EFORMAT, "PLY is cut short: %s %zu of %zu is missing",
                      e->is_vertex ? "vertex"
                      : e->is_face ? "face"
                                   : "element",
                      i, e->count);
}

// A polygon as a fan about its first corner.
static sheen_status read_corners(reader *r, const element *e, const property *p, size_t n, size_t i_face)
{
    int64_t first = 0, last = 0;
    for (size_t k = 0; k < n; k++) {
        double x;
        if (!read_value(r, p->value_type, &x))
            return fail_cut(r, e, i_face);
        const int64_t at = x >= 0 && x <= UINT32_MAX && x == floor(x) ? (int64_t)x : -1;
        if (k >= 2) {
            const sheen_status s = sheen_mesh_build_triangle(&r->build, first, last, at, r->n_vertices,
                                                             r->err);
            if (s)
                return s;
        }
        first = k ? first : at;
        last = at;
    }
    return SHEEN_OK;
}

static sheen_status read_list(reader *r, const element *e, const property *p, size_t i)
{
    double n = 0;
    if (!read_value(r, p->count_type, &n))
        return fail_cut(r, e, i);
    if (!(n >= 0 && n <= MAX_CORNERS) || n != floor(n))
        return sheen_fail(r->err, SHEEN_EFORMAT, "a list of %g values in PLY is out of range", n);
    if (p->role == ROLE_CORNERS)
        return read_corners(r, e, p, (size_t)n, i);
    for (size_t k = 0; k < (size_t)n; k++) {
        double ignored;
        if (!read_value(r, p->value_type, &ignored))
            return fail_cut(r, e, i);
    }
    return SHEEN_OK;
}

static sheen_status read_record(reader *r, const element *e, size_t i)
{
    double v[ROLE_NZ + 1] = {0};
    for (int k = 0; k < e->n_properties; k++) {
        const property *p = &e->properties[k];
        if (p->is_list) {
            const sheen_status s = read_list(r, e, p, i);
            if (s)
                return s;
        } else if (!read_value(r, p->value_type, &v[p->role])) {
            return fail_cut(r, e, i);
        }
    }
    return e->is_vertex ? sheen_mesh_build_vertex(&r->build, v + ROLE_X, v + ROLE_NX, r->err) : SHEEN_OK;
}

static sheen_status read_records(reader *r, const element *e)
{
    const size_t least = least_record_bytes(r, e), left = (size_t)(r->text.end - r->text.at);
    if (!least)
        return SHEEN_OK; // no properties: nothing is in the file
    // the last number of an ASCII file needs no blank behind it
    if (e->count > (left + 1) / least)
        return sheen_fail(r->err, SHEEN_EFORMAT,
                          "PLY is cut short: its header claims %zu records, %zu bytes follow", e->count,
                          left);
    sheen_status s = SHEEN_OK;
    if (e->is_vertex)
        s = sheen_mesh_build_reserve(&r->build, e->count, 0, r->err);
    else if (e->is_face)
        s = sheen_mesh_build_reserve(&r->build, 0, e->count, r->err);
    for (size_t i = 0; i < e->count && !s; i++)
        s = read_record(r, e, i);
    return s;
}

static sheen_status check_elements(const reader *r)
{
    unsigned roles = 0;
    for (int i = 0; i < r->n_elements; i++)
        for (int k = 0; k < r->elements[i].n_properties; k++)
            roles |= 1u << r->elements[i].properties[k].role;
    if (~roles & (1u << ROLE_X | 1u << ROLE_Y | 1u << ROLE_Z))
        return sheen_fail(r->err, SHEEN_EFORMAT, "PLY has no vertices with x, y and z");
    if (~roles & 1u << ROLE_CORNERS)
        return sheen_fail(r->err, SHEEN_EDATA, "PLY has no faces: a point cloud is not a mesh");
    return SHEEN_OK;
}

sheen_status sheen_ply_parse(sheen_mesh *mesh, const void *data, size_t size_bytes, sheen_err *err)
{
    *mesh = (sheen_mesh){0};
    reader *r = calloc(1, sizeof *r);
    if (!r)
        return sheen_fail_memory(err, sizeof *r, "a PLY header");
    r->text = (sheen_scan){data, (const char *)data + size_bytes, 0};
    r->err = err;
    sheen_status s = read_header(r);
    if (!s)
        s = check_elements(r);
    for (int i = 0; i < r->n_elements && !s; i++)
        s = read_records(r, &r->elements[i]);
    if (!s)
        s = sheen_mesh_build_finish(&r->build, mesh, err);
    sheen_mesh_build_release(&r->build);
    free(r);
    return s;
}

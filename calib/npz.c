// SPDX-License-Identifier: Apache-2.0
// npz.c - NEP 1's .npy 1.0 arrays in a zip of stored entries (APPNOTE 4.3), little endian.
#include "calib/npz.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HEADER_MAX = 256, TEXT_MAX = 127 };

// CRC-32 of zip, bit by bit: archives here are small.
static uint32_t crc32_of(const uint8_t *data, size_t n)
{
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < n; i++) {
        crc ^= data[i];
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

static void put(sheen_npz *z, sheen_bytes *to, const void *data, size_t n)
{
    if (!z->failed && !sheen_bytes_put(to, to->size_bytes, data, n))
        z->failed = true;
}

static void put_int(sheen_npz *z, sheen_bytes *to, uint32_t value, int n_bytes)
{
    uint8_t bytes[4];
    for (int i = 0; i < n_bytes; i++)
        bytes[i] = (uint8_t)(value >> 8 * i & 0xff);
    put(z, to, bytes, (size_t)n_bytes);
}

// What a local header and the directory say of an entry alike, from "version needed" on.
static void put_entry(sheen_npz *z, sheen_bytes *to, const sheen_bytes *content, const char *name)
{
    const uint32_t size = (uint32_t)content->size_bytes;
    put_int(z, to, 20, 2); // version
    put_int(z, to, 0, 2);  // flags
    put_int(z, to, 0, 2);  // stored
    put_int(z, to, 0, 2);  // time: midnight
    put_int(z, to, 33, 2); // date: 1 January 1980, so that equal arrays give equal files
    put_int(z, to, crc32_of(content->data, content->size_bytes), 4);
    put_int(z, to, size, 4);
    put_int(z, to, size, 4);
    put_int(z, to, (uint32_t)strlen(name) + 4, 2);
    put_int(z, to, 0, 2); // no extra field
}

static void add_entry(sheen_npz *z, const char *name, const sheen_bytes *content)
{
    const size_t at = z->file.size_bytes;
    if (z->failed || at + content->size_bytes > UINT32_MAX / 2) {
        z->failed = true;
        return;
    }
    put(z, &z->file, "PK\3\4", 4);
    put_entry(z, &z->file, content, name);
    put(z, &z->file, name, strlen(name));
    put(z, &z->file, ".npy", 4);
    put(z, &z->file, content->data, content->size_bytes);

    put(z, &z->directory, "PK\1\2", 4);
    put_int(z, &z->directory, 20, 2); // made by
    put_entry(z, &z->directory, content, name);
    put_int(z, &z->directory, 0, 2); // comment
    put_int(z, &z->directory, 0, 2); // disk
    put_int(z, &z->directory, 0, 2); // internal attributes
    put_int(z, &z->directory, 0, 4); // external attributes
    put_int(z, &z->directory, (uint32_t)at, 4);
    put(z, &z->directory, name, strlen(name));
    put(z, &z->directory, ".npy", 4);
    z->n_entries++;
}

// An array of items of item_bytes whose type numpy calls `type`.
static void add_array(sheen_npz *z, const char *name, const char *type, const void *data, size_t item_bytes,
                      int n_dimensions, const size_t *shape)
{
    char text[HEADER_MAX], dims[96] = "";
    size_t n = 1, used = 0;
    for (int i = 0; i < n_dimensions && i < SHEEN_NPZ_MAX_DIMENSIONS; i++) {
        used += (size_t)snprintf(dims + used, sizeof dims - used, "%zu, ", shape[i]);
        n *= shape[i];
    }
    const int length = snprintf(text, sizeof text, "{'descr': '%s', 'fortran_order': False, 'shape': (%s), }",
                                type, dims);
    const size_t padded = ((size_t)length + 1 + 10 + 63) / 64 * 64 - 10;
    sheen_bytes content = {0};
    put(z, &content, "\x93NUMPY\1\0", 8);
    put_int(z, &content, (uint32_t)padded, 2);
    put(z, &content, text, (size_t)length);
    for (size_t i = (size_t)length; i < padded; i++)
        put(z, &content, i + 1 == padded ? "\n" : " ", 1);
    put(z, &content, data, n * item_bytes);
    add_entry(z, name, &content);
    free(content.data);
}

void sheen_npz_numbers(sheen_npz *z, const char *name, const double *x, int n_dimensions, const size_t *shape)
{
    add_array(z, name, "<f8", x, sizeof *x, n_dimensions, shape);
}

void sheen_npz_integers(sheen_npz *z, const char *name, const int32_t *x, int n_dimensions,
                        const size_t *shape)
{
    add_array(z, name, "<i4", x, sizeof *x, n_dimensions, shape);
}

void sheen_npz_bool(sheen_npz *z, const char *name, bool x)
{
    const uint8_t byte = x;
    add_array(z, name, "|b1", &byte, 1, 0, NULL);
}

// numpy's texts are 32 bits a character, padded with zeros to one length.
static uint32_t *widen(const char *const *texts, size_t n, size_t length)
{
    uint32_t *wide = calloc(n * length + 1, sizeof *wide);
    for (size_t i = 0; wide && i < n; i++)
        for (size_t k = 0; k < length && texts[i][k]; k++)
            wide[i * length + k] = (uint8_t)texts[i][k];
    return wide;
}

static void add_texts(sheen_npz *z, const char *name, const char *const *texts, size_t n, int n_dimensions)
{
    char type[16];
    size_t length = 1;
    for (size_t i = 0; i < n; i++) {
        const size_t this_length = strlen(texts[i]);
        length = this_length > length ? this_length : length;
    }
    length = length > TEXT_MAX ? TEXT_MAX : length;
    uint32_t *wide = widen(texts, n, length);
    if (!wide) {
        z->failed = true;
        return;
    }
    snprintf(type, sizeof type, "<U%zu", length);
    add_array(z, name, type, wide, length * sizeof *wide, n_dimensions, &n);
    free(wide);
}

void sheen_npz_text(sheen_npz *z, const char *name, const char *text)
{
    add_texts(z, name, &text, 1, 0);
}

void sheen_npz_texts(sheen_npz *z, const char *name, const char *const *texts, size_t n)
{
    add_texts(z, name, texts, n, 1);
}

const sheen_bytes *sheen_npz_finish(sheen_npz *z)
{
    const uint32_t at = (uint32_t)z->file.size_bytes, size = (uint32_t)z->directory.size_bytes;
    put(z, &z->file, z->directory.data, z->directory.size_bytes);
    put(z, &z->file, "PK\5\6\0\0\0\0", 8);
    put_int(z, &z->file, (uint32_t)z->n_entries, 2);
    put_int(z, &z->file, (uint32_t)z->n_entries, 2);
    put_int(z, &z->file, size, 4);
    put_int(z, &z->file, at, 4);
    put_int(z, &z->file, 0, 2);
    return z->failed ? NULL : &z->file;
}

void sheen_npz_release(sheen_npz *z)
{
    free(z->file.data);
    free(z->directory.data);
    *z = (sheen_npz){0};
}

char *sheen_base85(const uint8_t *data, size_t size_bytes)
{
    static const char digits[] =
        "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz!#$%&()*+-;<=>?@^_`{|}~";
    char *text = malloc(size_bytes / 4 * 5 + 8), *to = text;
    for (size_t i = 0; text && i < size_bytes; i += 4) {
        const size_t n = size_bytes - i < 4 ? size_bytes - i : 4;
        char five[5];
        uint32_t word = 0;
        for (size_t k = 0; k < 4; k++)
            word = word << 8 | (k < n ? data[i + k] : 0);
        for (int k = 4; k >= 0; k--, word /= 85)
            five[k] = digits[word % 85];
        memcpy(to, five, n + 1);
        to += n + 1;
    }
    if (text)
        *to = 0;
    return text;
}

// SPDX-License-Identifier: Apache-2.0
// pack_deflate.c - the one door to zlib.
#define ZLIB_CONST
#include "render/pack_deflate.h"

#include <stdlib.h>
#include <zlib.h>

enum { RAW_WINDOW = -15, LEVEL = 9, MEMORY = 9 };
static const size_t most_bytes = (size_t)1 << 30;
static const size_t first_room_bytes = (size_t)1 << 16;

sheen_status sheen_deflate(uint8_t **out, size_t *out_size_bytes, const void *data, size_t size_bytes,
                           sheen_err *err)
{
    z_stream z = {0};
    *out = NULL;
    *out_size_bytes = 0;
    if (size_bytes > most_bytes)
        return sheen_fail(err, SHEEN_EARG, "%zu bytes are too many to deflate at once", size_bytes);
    if (deflateInit2(&z, LEVEL, Z_DEFLATED, RAW_WINDOW, MEMORY, Z_DEFAULT_STRATEGY) != Z_OK)
        return sheen_fail_memory(err, 3e5, "deflating");
    const size_t room_bytes = deflateBound(&z, (uLong)size_bytes);
    uint8_t *room = malloc(room_bytes);
    if (!room) {
        deflateEnd(&z);
        return sheen_fail_memory(err, (double)room_bytes, "deflating");
    }
    z.next_in = data;
    z.avail_in = (uInt)size_bytes;
    z.next_out = room;
    z.avail_out = (uInt)room_bytes;
    const int code = deflate(&z, Z_FINISH); // the room is enough by deflateBound
    *out_size_bytes = z.total_out;
    deflateEnd(&z);
    if (code != Z_STREAM_END) {
        free(room);
        return sheen_fail(err, SHEEN_EUNSUP, "zlib cannot deflate (its error %d)", code);
    }
    *out = room;
    return SHEEN_OK;
}

sheen_status sheen_inflate(uint8_t **out, size_t *out_size_bytes, const void *data, size_t size_bytes,
                           size_t max_bytes, sheen_err *err)
{
    z_stream z = {.next_in = data, .avail_in = (uInt)size_bytes};
    uint8_t *room = NULL;
    size_t room_bytes = 0;
    int code = Z_OK;
    sheen_status s = SHEEN_OK;
    *out = NULL;
    *out_size_bytes = 0;
    if (size_bytes > most_bytes || max_bytes > most_bytes)
        return sheen_fail(err, SHEEN_EFORMAT, "the packed model is too large");
    if (inflateInit2(&z, RAW_WINDOW) != Z_OK)
        return sheen_fail_memory(err, 5e4, "inflating");
    while (code != Z_STREAM_END && !s) {
        if (z.total_out == room_bytes) {
            const size_t wanted = room_bytes ? 2 * room_bytes : first_room_bytes;
            uint8_t *larger = room_bytes > max_bytes ? NULL : realloc(room, wanted);
            if (!larger) {
                s = room_bytes > max_bytes
                        ? sheen_fail(err, SHEEN_EFORMAT, "the packed model is larger than it may be")
                        : sheen_fail_memory(err, (double)wanted, "inflating");
                break;
            }
            room = larger;
            room_bytes = wanted;
        }
        z.next_out = room + z.total_out;
        z.avail_out = (uInt)(room_bytes - z.total_out);
        code = inflate(&z, Z_NO_FLUSH);
        if (code != Z_OK && code != Z_STREAM_END)
            s = sheen_fail(err, SHEEN_EFORMAT, "the packed model is damaged or cut short");
    }
    *out_size_bytes = z.total_out;
    inflateEnd(&z);
    if (!s && *out_size_bytes > max_bytes)
        s = sheen_fail(err, SHEEN_EFORMAT, "the packed model is larger than it may be");
    if (s)
        free(room);
    else
        *out = room;
    return s;
}

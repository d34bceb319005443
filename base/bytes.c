// SPDX-License-Identifier: Apache-2.0
// bytes.c - grows by doubling.
#include "base/bytes.h"

#include <stdlib.h>
#include <string.h>

int sheen_bytes_put(sheen_bytes *b, size_t offset, const void *from, size_t n_bytes)
{
    if (!n_bytes)
        return 1;
    if (offset > SIZE_MAX / 8 || n_bytes > SIZE_MAX / 8)
        return 0;
    const size_t end = offset + n_bytes;
    if (end > b->capacity_bytes) {
        const size_t capacity = 2 * end + 4096;
        uint8_t *grown = realloc(b->data, capacity);
        if (!grown)
            return 0;
        b->data = grown;
        b->capacity_bytes = capacity;
    }
    if (offset > b->size_bytes)
        memset(b->data + b->size_bytes, 0, offset - b->size_bytes);
    memcpy(b->data + offset, from, n_bytes);
    if (end > b->size_bytes)
        b->size_bytes = end;
    return 1;
}

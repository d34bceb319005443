// SPDX-License-Identifier: Apache-2.0
// bytes.h - a file that is being written to memory, of a length that nobody knows beforehand.
#ifndef SHEEN_BASE_BYTES_H
#define SHEEN_BASE_BYTES_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

// Zero to begin with; the owner frees `data`.
typedef struct sheen_bytes {
    uint8_t *data;
    size_t size_bytes, capacity_bytes;
} sheen_bytes;

// Writes n bytes at an offset; what lies between the old end and it becomes zero. False where there is no memory.
int sheen_bytes_put(sheen_bytes *b, size_t offset, const void *from, size_t n_bytes);

#ifdef __cplusplus
}
#endif
#endif

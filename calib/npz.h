// SPDX-License-Identifier: Apache-2.0
// npz.h - writes numpy's archive of named arrays (.npz: a zip of .npy files, here uncompressed), into memory.
//
//     sheen_npz z = {0};
//     sheen_npz_numbers(&z, "poses", rt, 2, (const size_t[]){n, 6});
//     sheen_npz_text(&z, "lensmodel", "LENSMODEL_OPENCV8");
//     bytes = sheen_npz_finish(&z);       // lent until sheen_npz_release; NULL where memory ran out
#ifndef SHEEN_CALIB_NPZ_H
#define SHEEN_CALIB_NPZ_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/bytes.h"

typedef struct sheen_npz {
    sheen_bytes file, directory;
    int n_entries;
    bool failed; // out of memory, or too large for a zip
} sheen_npz;

enum { SHEEN_NPZ_MAX_DIMENSIONS = 4 };

// n_dimensions 0: a single value. Numbers are doubles, integers 32-bit, in C order.
void sheen_npz_numbers(sheen_npz *z, const char *name, const double *x, int n_dimensions,
                       const size_t *shape);
void sheen_npz_integers(sheen_npz *z, const char *name, const int32_t *x, int n_dimensions,
                        const size_t *shape);
void sheen_npz_bool(sheen_npz *z, const char *name, bool x);
// ASCII; "" stands for None in mrcal's files.
void sheen_npz_text(sheen_npz *z, const char *name, const char *text);
// A list of n ASCII texts, each up to 127 characters.
void sheen_npz_texts(sheen_npz *z, const char *name, const char *const *texts, size_t n);
const sheen_bytes *sheen_npz_finish(sheen_npz *z);
void sheen_npz_release(sheen_npz *z);

// Base 85 with RFC 1924's digits, as Python's base64.b85encode writes it; a NUL follows. NULL: no memory.
char *sheen_base85(const uint8_t *data, size_t size_bytes);

#endif

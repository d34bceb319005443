// SPDX-License-Identifier: Apache-2.0
// text.h - a text file that is being written to memory, piece by piece.
//
//     sheen_text t = {0};
//     sheen_text_put(&t, "%d %.17g\n", i, x);
//     s = sheen_text_save(&t, path, err);         // releases it
//
// Running out of memory is remembered, and reported once, at the end.
#ifndef SHEEN_BASE_TEXT_H
#define SHEEN_BASE_TEXT_H

#include <stdarg.h>
#include <stdbool.h>

#include "base/bytes.h"
#include "base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_text {
    sheen_bytes bytes;
    bool failed; // out of memory: what follows is dropped
} sheen_text;

void sheen_text_put(sheen_text *t, const char *fmt, ...) SHEEN_PRINTF(2, 3);
void sheen_text_put_args(sheen_text *t, const char *fmt, va_list args) SHEEN_PRINTF(2, 0);
void sheen_text_append(sheen_text *t, const char *from, size_t n_bytes);
// What was written so far, with a NUL behind it; NULL where memory ran out. Valid until the next call.
const char *sheen_text_string(sheen_text *t);
// Writes the file as a whole (atomic) and releases the text, also where that fails. ENOMEM, EIO.
sheen_status sheen_text_save(sheen_text *t, const char *path, sheen_err *err);
void sheen_text_release(sheen_text *t);

#ifdef __cplusplus
}
#endif
#endif

// SPDX-License-Identifier: Apache-2.0
// text.c - a text in growing memory.
#include "base/text.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/file.h"

enum { SHORT_BYTES = 512 }; // what is formatted without asking for memory

void sheen_text_append(sheen_text *t, const char *from, size_t n_bytes)
{
    if (!t->failed && !sheen_bytes_put(&t->bytes, t->bytes.size_bytes, from, n_bytes))
        t->failed = true;
}

void sheen_text_put_args(sheen_text *t, const char *fmt, va_list args)
{
    char brief[SHORT_BYTES];
    va_list again;
    va_copy(again, args);
    const int n = vsnprintf(brief, sizeof brief, fmt, args);
    if (n >= 0 && (size_t)n < sizeof brief) {
        sheen_text_append(t, brief, (size_t)n);
    } else {
        char *whole = n < 0 ? NULL : malloc((size_t)n + 1);
        if (whole) {
            vsnprintf(whole, (size_t)n + 1, fmt, again);
            sheen_text_append(t, whole, (size_t)n);
        } else {
            t->failed = true;
        }
        free(whole);
    }
    va_end(again);
}

void sheen_text_put(sheen_text *t, const char *fmt, ...)
{
    va_list args;
    va_start(args, fmt);
    sheen_text_put_args(t, fmt, args);
    va_end(args);
}

const char *sheen_text_string(sheen_text *t)
{
    sheen_text_append(t, "", 1);
    if (t->failed)
        return NULL;
    t->bytes.size_bytes--;
    return (const char *)t->bytes.data;
}

sheen_status sheen_text_save(sheen_text *t, const char *path, sheen_err *err)
{
    const sheen_status s = t->failed ? sheen_fail(err, SHEEN_ENOMEM, "out of memory while writing '%s'", path)
                                     : sheen_file_write(path, t->bytes.data, t->bytes.size_bytes, err);
    sheen_text_release(t);
    return s;
}

void sheen_text_release(sheen_text *t)
{
    free(t->bytes.data);
    *t = (sheen_text){0};
}

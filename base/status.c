// SPDX-License-Identifier: Apache-2.0
// status.c - error codes and their sentences.
#include "base/status.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

const char *sheen_status_text(sheen_status s)
{
    static const char *const texts[] = {
#define X(code, text) text,
        SHEEN_STATUS_LIST(X)
#undef X
    };
    const size_t i = (size_t)s;
    return i < sizeof texts / sizeof *texts ? texts[i] : "unknown status";
}

sheen_status sheen_fail(sheen_err *err, sheen_status code, const char *fmt, ...)
{
    if (!err)
        return code;
    va_list args;
    va_start(args, fmt);
    err->code = code;
    vsnprintf(err->msg, sizeof err->msg, fmt, args);
    va_end(args);
    return code;
}

sheen_status sheen_wrap(sheen_err *err, sheen_status code, const char *fmt, ...)
{
    if (!err)
        return code;
    char whole[sizeof err->msg];
    va_list args;
    va_start(args, fmt);
    const int n = vsnprintf(whole, sizeof whole, fmt, args);
    va_end(args);
    if (n > 0 && (size_t)n + 2 < sizeof whole) {
        const size_t used = (size_t)n, room = sizeof whole - used - 3;
        snprintf(whole + used, sizeof whole - used, ": %.*s", (int)room, err->msg);
    }
    err->code = code;
    memcpy(err->msg, whole, sizeof whole);
    return code;
}

sheen_status sheen_fail_memory(sheen_err *err, double size_bytes, const char *what)
{
    return sheen_fail(err, SHEEN_ENOMEM, "out of memory: %.0f MB for %s", size_bytes / 1e6, what);
}

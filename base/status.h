// SPDX-License-Identifier: Apache-2.0
// status.h - how every function that can fail says so.
//
// Such a function returns sheen_status and takes `sheen_err *err` last. On
// success err is untouched. On failure it holds the code and one sentence for
// a person: lower case, no full stop, what failed first, the subject in single
// quotes, and, where there is one, what to do about it:
//
//     cannot open 'x.json': No such file or directory
//
// err may be NULL. Nothing below cli prints or exits; bugs are assert().
#ifndef SHEEN_BASE_STATUS_H
#define SHEEN_BASE_STATUS_H

#ifdef __cplusplus
extern "C" {
#endif

// One code per thing that a caller would do differently. X(code, short text)
#define SHEEN_STATUS_LIST(X)                                                                                 \
    X(OK, "success")                                                                                         \
    X(EARG, "bad argument or configuration")                                                                 \
    X(EIO, "input or output failed")                                                                         \
    X(EFORMAT, "file is malformed or of an unknown version")                                                 \
    X(ENODEV, "no such device, or it went away")                                                             \
    X(EACCESS, "permission denied")                                                                          \
    X(ETIMEOUT, "timed out")                                                                                 \
    X(EEND, "no more data")                                                                                  \
    X(ENOMEM, "out of memory")                                                                               \
    X(EUNSUP, "not supported by this device or build")                                                       \
    X(EDATA, "the data do not determine an answer")                                                          \
    X(ECANCEL, "cancelled")

typedef enum sheen_status {
#define X(code, text) SHEEN_##code,
    SHEEN_STATUS_LIST(X)
#undef X
} sheen_status;

typedef struct sheen_err {
    sheen_status code;
    char msg[512];
} sheen_err;

#define SHEEN_PRINTF(f, a) __attribute__((format(printf, f, a)))

// The short fixed text of a code; never NULL.
const char *sheen_status_text(sheen_status s);

// Fills err (if not NULL) and returns `code`, so that an error path is one line.
sheen_status sheen_fail(sheen_err *err, sheen_status code, const char *fmt, ...) SHEEN_PRINTF(3, 4);

// Puts "<fmt>: " before the sentence already in err; returns `code` unchanged.
// For the place that knows the subject: `return sheen_wrap(err, s, "cannot read '%s'", path)`.
sheen_status sheen_wrap(sheen_err *err, sheen_status code, const char *fmt, ...) SHEEN_PRINTF(3, 4);

// sheen_fail with ENOMEM and the size that could not be had.
sheen_status sheen_fail_memory(sheen_err *err, double size_bytes, const char *what);

#ifdef __cplusplus
}
#endif
#endif

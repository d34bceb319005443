// SPDX-License-Identifier: Apache-2.0
// libcamera_source.h - libcamera's cameras by name, beside their being a source ("libcamera:", source_backend.h).
#ifndef SHEEN_CAPTURE_LIBCAMERA_SOURCE_H
#define SHEEN_CAPTURE_LIBCAMERA_SOURCE_H

#include "base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_libcamera_name {
    char id[128];    // what stays: "libcamera:<id>"
    char model[128]; // as the camera calls itself
} sheen_libcamera_name;

// The cameras that libcamera knows, at most max_names, in its order: the first is libcamera:0. *n_out: how many there
// are. EIO (libcamera does not start), ENOMEM.
sheen_status sheen_libcamera_list(sheen_libcamera_name *names, int max_names, int *n_out, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

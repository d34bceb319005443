// SPDX-License-Identifier: Apache-2.0
// fuzz_sidecar.c - any bytes as a frame's description: what is read is in range and its strings end.
#include <stdlib.h>
#include <string.h>

#include "base/session.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    sheen_frame_info f = {.name = "frame"};
    sheen_err err;
    if (sheen_frame_info_parse(&f, data, size_bytes, &err))
        return 0;
    if (strcmp(f.name, "frame") != 0 || strchr(f.file, '/') || strlen(f.payload_digest) != 32)
        abort();
    if (f.width_px < 1 || f.height_px < 1 || f.stride_bytes < 0 || f.role >= SHEEN_ROLE_COUNT ||
        f.transfer >= SHEEN_TRANSFER_COUNT)
        abort();
    if (f.n_controls < 0 || f.n_controls > SHEEN_FRAME_MAX_CONTROLS || f.lock > SHEEN_LOCK_HELD ||
        memchr(f.device, 0, sizeof f.device) == NULL)
        abort();
    if (memchr(f.source, 0, sizeof f.source) == NULL || memchr(f.file, 0, sizeof f.file) == NULL)
        abort();
    return 0;
}

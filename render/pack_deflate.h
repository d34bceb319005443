// SPDX-License-Identifier: Apache-2.0
// pack_deflate.h - raw DEFLATE (RFC 1951, no header): what a browser's DecompressionStream("deflate-raw") reads.
#ifndef SHEEN_RENDER_PACK_DEFLATE_H
#define SHEEN_RENDER_PACK_DEFLATE_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

// At most 1 GB; the caller frees *out. EARG, ENOMEM.
sheen_status sheen_deflate(uint8_t **out, size_t *out_size_bytes, const void *data, size_t size_bytes,
                           sheen_err *err);
// At most max_bytes come out; memory grows with what does come out, so a small input cannot ask for much. The caller
// frees *out. EFORMAT, ENOMEM.
sheen_status sheen_inflate(uint8_t **out, size_t *out_size_bytes, const void *data, size_t size_bytes,
                           size_t max_bytes, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

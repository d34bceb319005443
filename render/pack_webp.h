// SPDX-License-Identifier: Apache-2.0
// pack_webp.h - lossless WebP pictures of 8-bit RGB, in memory.
#ifndef SHEEN_RENDER_PACK_WEBP_H
#define SHEEN_RENDER_PACK_WEBP_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SHEEN_WEBP_MAX_SIDE_PX = 16383 };

// rgb: [height_px][width_px][3]. Lossless. The caller frees *out. EARG: a side out of range; ENOMEM.
sheen_status sheen_webp_encode(uint8_t **out, size_t *size_bytes, const uint8_t *rgb, int width_px,
                               int height_px, sheen_err *err);
// A picture of exactly this size; the caller frees *rgb. EFORMAT, ENOMEM.
sheen_status sheen_webp_decode(uint8_t **rgb, const void *data, size_t size_bytes, int width_px,
                               int height_px, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

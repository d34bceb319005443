// SPDX-License-Identifier: Apache-2.0
// pack_avif.h - 8-bit sRGB pictures as AVIF with full colour resolution, which every browser of 2023 decodes.
#ifndef SHEEN_RENDER_PACK_AVIF_H
#define SHEEN_RENDER_PACK_AVIF_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

// Of AV1's quantiser: 0 is (nearly) exact, 63 the smallest.
enum { SHEEN_AVIF_MAX_SIDE_PX = 32768, SHEEN_AVIF_FINEST = 0, SHEEN_AVIF_COARSEST = 63 };

// rgb: [height_px][width_px][3]. The result does not depend on n_threads (0: one a processor). The caller frees *out.
// EARG: a size out of range; ENOMEM; EUNSUP: no encoder here.
sheen_status sheen_avif_encode(uint8_t **out, size_t *size_bytes, const uint8_t *rgb, int width_px,
                               int height_px, int quantizer, int n_threads, sheen_err *err);
// A picture of the size that is known beforehand, as [height_px][width_px][3]; the caller frees *rgb. EFORMAT, ENOMEM.
sheen_status sheen_avif_decode(uint8_t **rgb, const void *data, size_t size_bytes, int width_px,
                               int height_px, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

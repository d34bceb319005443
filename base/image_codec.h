// SPDX-License-Identifier: Apache-2.0
// image_codec.h - what the image formats share among themselves: size checks, and probing by format.
//
// Only image_*.c include this; everyone else wants image_file.h.
#ifndef SHEEN_BASE_IMAGE_CODEC_H
#define SHEEN_BASE_IMAGE_CODEC_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/bytes.h"
#include "base/image.h"

#ifdef __cplusplus
extern "C" {
#endif

// EFORMAT where a side is not in 1..SHEEN_IMAGE_MAX_SIDE_PX.
sheen_status sheen_image_check_sides(uint32_t width_px, uint32_t height_px, sheen_err *err);

// A header may claim any size: before memory is asked for, `decoded_bytes` (as the format packs its samples)
// are set against the size of the file. EFORMAT where they are more than `max_ratio` times the file and
// more than `free_bytes`.
sheen_status sheen_image_check_claim(double decoded_bytes, size_t size_bytes, double max_ratio,
                                     double free_bytes, sheen_err *err);

// Width and height from the header alone.
sheen_status sheen_png_probe(int *width_px, int *height_px, const void *data, size_t size_bytes,
                             sheen_err *err);
sheen_status sheen_jpeg_probe(int *width_px, int *height_px, const void *data, size_t size_bytes,
                              sheen_err *err);
sheen_status sheen_tiff_probe(int *width_px, int *height_px, const void *data, size_t size_bytes,
                              sheen_err *err);
sheen_status sheen_exr_probe(int *width_px, int *height_px, const void *data, size_t size_bytes,
                             sheen_err *err);
sheen_status sheen_hdr_probe(int *width_px, int *height_px, const void *data, size_t size_bytes,
                             sheen_err *err);

// One row of 16-bit samples in big-endian order, as PNG wants it, is the swap of a little-endian machine's.
static inline int sheen_is_little_endian(void)
{
    const uint16_t one = 1;
    uint8_t first;
    memcpy(&first, &one, 1);
    return first;
}

#ifdef __cplusplus
}
#endif
#endif

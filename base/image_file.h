// SPDX-License-Identifier: Apache-2.0
// image_file.h - image files: PNG (8, 16 bit), JPEG, TIFF (8, 16, float), OpenEXR (half, float).
//
// Parsers take memory and trust nothing: sizes are checked before anything is allocated.
// One source file a library; a file that is cut short is EFORMAT, never half a picture.
#ifndef SHEEN_BASE_IMAGE_FILE_H
#define SHEEN_BASE_IMAGE_FILE_H

#include <stdbool.h>
#include <stddef.h>

#include "base/image.h"

#ifdef __cplusplus
extern "C" {
#endif

// Tells the format by its first bytes. EFORMAT: none of the four, malformed, cut short, or a side beyond
// SHEEN_IMAGE_MAX_SIDE_PX. EUNSUP: a variant that is not read (CMYK JPEG, palette of floats, deep EXR).
sheen_status sheen_raster_parse(sheen_raster *out, const void *data, size_t size_bytes, sheen_err *err);
sheen_status sheen_raster_load(sheen_raster *out, const char *path, sheen_err *err);
// Size only, from the header, without decoding the pixels.
sheen_status sheen_raster_probe(int *width_px, int *height_px, const void *data, size_t size_bytes,
                                sheen_err *err);

sheen_status sheen_png_parse(sheen_raster *out, const void *data, size_t size_bytes, sheen_err *err);
sheen_status sheen_jpeg_parse(sheen_raster *out, const void *data, size_t size_bytes, sheen_err *err);
// As it is coded: Y'CbCr, its chroma interpolated to all pixels (*is_ycbcr_out), else grey or RGB as above.
sheen_status sheen_jpeg_parse_coded(sheen_raster *out, bool *is_ycbcr_out, const void *data,
                                    size_t size_bytes, sheen_err *err);
sheen_status sheen_tiff_parse(sheen_raster *out, const void *data, size_t size_bytes, sheen_err *err);
sheen_status sheen_exr_parse(sheen_raster *out, const void *data, size_t size_bytes, sheen_err *err);
// Radiance (.hdr, RGBE): divided by the exposures that its header names.
sheen_status sheen_hdr_parse(sheen_raster *out, const void *data, size_t size_bytes, sheen_err *err);

// Writers replace the file in one step (file.h).
// 8- or 16-bit raster of 1 to 4 channels, as it is (no conversion).
sheen_status sheen_png_write(const char *path, const sheen_raster *r, sheen_err *err);
// The same into memory, which the caller frees.
sheen_status sheen_png_encode(uint8_t **data_out, size_t *size_bytes, const sheen_raster *r, sheen_err *err);
// A linear image of 1, 3 or 4 channels (alpha stays linear) as 8-bit sRGB PNG, clipped to 0..1.
sheen_status sheen_png_write_srgb(const char *path, const sheen_image *lin, sheen_err *err);
// Quality 1..100, 4:4:4; to memory (the caller frees *out) or to a file.
sheen_status sheen_jpeg_encode(uint8_t **out, size_t *size_bytes, const sheen_raster *r, int quality,
                               sheen_err *err);
sheen_status sheen_jpeg_write(const char *path, const sheen_raster *r, int quality, sheen_err *err);
// Radiance picture (.hdr, RGBE): 3 channels, linear, run-length coded.
sheen_status sheen_hdr_write(const char *path, const sheen_image *img, sheen_err *err);
// Scan lines, ZIP, half or float. channel_names: n_channels names, or NULL for Y / R G B / R G B A.
sheen_status sheen_exr_write(const char *path, const sheen_image *img, const char *const *channel_names,
                             bool half, sheen_err *err);
// The same into memory, which the caller frees. EARG, ENOMEM.
sheen_status sheen_exr_encode(uint8_t **data_out, size_t *size_bytes_out, const sheen_image *img,
                              const char *const *channel_names, bool half, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif

// SPDX-License-Identifier: Apache-2.0
// pixel_format.h - raw frames of cameras, as V4L2 names their formats, developed into pictures.
//
// Known: YUYV, NV12, GREY, Y10, Y12, Y16, RGB3, BGR3, and Bayer mosaics of all four orders with 8, 10, 12, 14 and 16
// bits, and with 10 and 12 bits packed.
#ifndef SHEEN_BASE_PIXEL_FORMAT_H
#define SHEEN_BASE_PIXEL_FORMAT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/image.h"

#ifdef __cplusplus
extern "C" {
#endif

// What a driver says of its numbers, in V4L2's own numbers (struct v4l2_pix_format); 0: the default of the colorspace.
typedef struct sheen_colorimetry {
    uint32_t colorspace, xfer_func, ycbcr_enc, quantization;
} sheen_colorimetry;

static inline bool sheen_colorimetry_known(const sheen_colorimetry *c)
{
    return c->colorspace || c->xfer_func || c->ycbcr_enc || c->quantization;
}

typedef struct sheen_pixel_layout {
    uint32_t fourcc; // V4L2_PIX_FMT_*
    int width_px, height_px, stride_bytes;
    sheen_colorimetry color;
} sheen_pixel_layout;

// True for a format of the list above.
bool sheen_pixels_known(uint32_t fourcc);
// Bytes from row to row where rows adjoin, and of the shortest whole frame in this layout (its last row may end before
// the stride does). 0: unknown format, or sides that it cannot have.
size_t sheen_pixels_stride(uint32_t fourcc, int width_px);
size_t sheen_pixels_size(const sheen_pixel_layout *layout);

// The curve that the reported numbers mean: mosaics are linear where no curve is named, other formats and JPEG (any
// other fourcc) follow V4L2's defaults. EUNSUP for curves that sheen has not (DCI-P3, SMPTE 2084).
sheen_status sheen_pixels_transfer(sheen_transfer *out, uint32_t fourcc, const sheen_colorimetry *color,
                                   sheen_err *err);

// The frame as RGB or grey of 16 bits, full scale 65535 at the format's largest code (white, where the range is limited;
// what lies outside is clipped). Chroma and mosaics are interpolated. The curve is left as it is.
// EFORMAT (short, impossible stride or sides), EUNSUP (unknown format or matrix), ENOMEM.
sheen_status sheen_pixels_develop(sheen_raster *out, const void *data, size_t size_bytes,
                                  const sheen_pixel_layout *layout, sheen_err *err);

// What a camera delivered: a raw format as above, or (fourcc 0, MJPEG or JPEG) a picture file as image_file.h reads it.
// A JPEG's matrix and range are JFIF's (BT.601, full) unless the layout's colour names others; then the codes come with
// 16 bits, what lies outside of a limited range clipped. Width and height of a picture are its own: compare them.
sheen_status sheen_payload_develop(sheen_raster *out, const void *data, size_t size_bytes,
                                   const sheen_pixel_layout *layout, sheen_err *err);

// True for a mosaic of colours (Bayer).
bool sheen_pixels_is_mosaic(uint32_t fourcc);
// The two halves of developing a mosaic: its samples, one channel of 16 bits; and the picture that is interpolated from
// such samples. EFORMAT, EUNSUP (no mosaic), ENOMEM.
sheen_status sheen_pixels_mosaic(sheen_raster *out, const void *data, size_t size_bytes,
                                 const sheen_pixel_layout *layout, sheen_err *err);
sheen_status sheen_mosaic_develop(sheen_raster *out, const sheen_raster *mosaic, uint32_t fourcc,
                                  sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif
